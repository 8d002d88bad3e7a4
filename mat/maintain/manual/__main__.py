"""Builds the documentation site; needs the extra ``docs``.

Run ``python -m mat.maintain.manual CHECKOUT OUT``. Notebooks are shown with the results that they have. Warnings are
errors: a link or an anchor that leads nowhere, a page that no page names, a page that loads something from another
machine.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from mat.maintain.manual.outside import requests_of_folder
from mat.maintain.manual.sources import gather


def build(checkout: Path, out: Path) -> int:
    """Write the site into a folder; the exit status is 1 where something is wrong with it.

    Parameters
    ----------
    checkout, out : Path
    """
    with tempfile.TemporaryDirectory() as name:
        tree = Path(name) / "site"
        tree.mkdir()
        gather(checkout.resolve(), tree)
        command = [sys.executable, "-m", "sphinx", "--quiet", "--fail-on-warning", "--keep-going", "--builder", "html"]
        process = subprocess.run([*command, "--doctree-dir", f"{name}/doctrees", tree, out], check=False)
    requests = requests_of_folder(out) if process.returncode == 0 else []
    for line in requests:
        print(f"loads from another machine: {line}", file=sys.stderr)
    return 1 if process.returncode or requests else 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Build the documentation site.")
    parser.add_argument("checkout", type=Path)
    parser.add_argument("out", type=Path)
    arguments = parser.parse_args()
    sys.exit(build(arguments.checkout, arguments.out))
