"""Draws the pictures of the README anew: the starter job is built and its scene rendered.

Run ``python -m skyshine.mat.maintain.pictures FOLDER``; FOLDER is ``examples/pictures`` of the checkout.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

SHOWN = (
    "built/pictures/yellowstone_road.tmm.png",
    "built/pictures/s01.htt.png",
    "built/pictures/s01b01.atmq.png",
    "built/pictures/b02.band.png",
    "rendered/yellowstone_day.png",
)


def draw(folder: Path, mat: Path) -> None:
    """Put the pictures into a folder, under their names; all of them or, where something fails, none.

    Parameters
    ----------
    folder : Path
    mat : Path
        The command.

    Raises
    ------
    subprocess.CalledProcessError
        The command fails.
    """
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        for arguments in (("init", work), ("build", work / "job.yaml"), ("render", work / "scene.yaml")):
            subprocess.run([mat, *arguments], check=True)
        for picture in SHOWN:
            shutil.copyfile(work / picture, folder / Path(picture).name)


if __name__ == "__main__":
    draw(Path(sys.argv[1]), Path(sys.executable).with_name("mat"))
