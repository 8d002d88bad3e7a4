"""Draws the pictures of the README anew: the starter job is built and its scene rendered.

Run ``python -m skyshine.mat.maintain.pictures FOLDER``; FOLDER is ``examples/pictures`` of the checkout.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

from click.testing import CliRunner

from skyshine.mat.cli import main as mat
from skyshine.schemas.errors import CheckFailed

SHOWN = (
    "built/pictures/yellowstone_road.tmm.png",
    "built/pictures/s01.htt.png",
    "built/pictures/s01b01.atmq.png",
    "built/pictures/b02.band.png",
    "rendered/yellowstone_day.png",
)


def draw(folder: Path) -> None:
    """Put the pictures into a folder, under their names.

    Raises
    ------
    CheckFailed
        A command fails, with what it says.
    """
    with tempfile.TemporaryDirectory() as work:
        for arguments in (("init", work), ("build", f"{work}/job.yaml"), ("render", f"{work}/scene.yaml")):
            result = CliRunner().invoke(mat, list(arguments))
            if result.exit_code:
                raise CheckFailed(f"mat {' '.join(arguments)}: {result.output}")
        for picture in SHOWN:
            shutil.copyfile(Path(work) / picture, folder / Path(picture).name)


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
