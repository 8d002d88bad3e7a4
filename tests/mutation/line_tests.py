"""Which tests run a line: recorded once by the package ``coverage``, for planting faults quickly.

    python tests/mutation/line_tests.py lines.coverage [FOLDER OF TESTS ...]

A test counts for the lines that run inside its function; what its fixtures run is known of no test.
"""

from __future__ import annotations

import argparse
import importlib.util
import subprocess
import sys
import tempfile
from collections import Counter
from functools import cached_property
from pathlib import Path

CHECKOUT = Path(__file__).parents[2]
FOLDERS = ("tests/mat", "tests/materials", "tests/schemas", "tests/tmm")
LONGEST = 6  # lines of a statement
SETTINGS = """[run]
dynamic_context = test_function
include =
    {folders}
data_file = {file}
"""


class LineTests:
    """Tests by the line that they run.

    Parameters
    ----------
    file : path
        That this program wrote.
    """

    def __init__(self, file: Path):
        from coverage import CoverageData

        self._data = CoverageData(str(file))
        self._data.read()

    @cached_property
    def _files(self) -> dict[str, str]:
        """Recorded names of files by their path in the package."""
        return {
            f"{folder.name}/{Path(name).relative_to(folder).as_posix()}": name
            for name in self._data.measured_files()
            for folder in _folders()
            if Path(name).is_relative_to(folder)
        }

    @cached_property
    def _lines_of_test(self) -> Counter[str]:
        """How many lines each test runs: those with few are quick."""
        counts: Counter[str] = Counter()
        for name in self._files.values():
            for tests in self._data.contexts_by_lineno(name).values():
                counts.update(tests)
        return counts

    def of(self, module: str, line: int, most: int) -> list[str]:
        """Node ids of tests that run a line, those with the fewest lines first.

        Of a line that no test runs, as those of constants and of what fixtures build, the tests that run any line of
        its module.

        Parameters
        ----------
        module : str
            Path in the package.
        line : int
        most : int
            Number of tests.
        """
        recorded = self._data.contexts_by_lineno(self._files[module]) if module in self._files else {}
        # A statement of several lines may be recorded at an earlier one.
        lines = (set(recorded.get(number, ())) - {""} for number in range(line, max(0, line - LONGEST), -1))
        tests = next((tests for tests in lines if tests), set().union(*recorded.values()) - {""})
        nodes = []
        for test in sorted(tests, key=lambda test: (self._lines_of_test[test], test)):
            dotted, _, function = test.rpartition(".")
            if (CHECKOUT / (path := dotted.replace(".", "/") + ".py")).is_file():
                nodes.append(f"{path}::{function}")
        return nodes[:most]


def _folders() -> list[Path]:
    """Folders of the installed package, as ``coverage`` names them."""
    package = Path(importlib.util.find_spec("skyshine").origin).parent
    return [(package / name).resolve() for name in ("mat", "materials", "schemas", "tmm")]


def record(file: Path, folders: list[str]) -> int:
    """Run tests and write which lines each runs; the exit status is that of pytest."""
    with tempfile.TemporaryDirectory() as work:
        settings = Path(work) / "coverage.ini"
        folders_of_package = "\n    ".join(f"{folder}/*" for folder in _folders())
        settings.write_text(SETTINGS.format(file=file.resolve(), folders=folders_of_package), encoding="utf-8")
        command = [sys.executable, "-m", "coverage", "run", f"--rcfile={settings}", "-m", "pytest", "-q"]
        return subprocess.run([*command, "-p", "no:cacheprovider", *folders], cwd=CHECKOUT).returncode


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path)
    parser.add_argument("folders", nargs="*", default=list(FOLDERS))
    given = parser.parse_args()
    sys.exit(record(given.file, given.folders))
