"""Draws the pictures of the README anew: the starter job is built and its scene rendered.

Run ``python -m skyshine.mat.maintain.pictures FOLDER``; FOLDER is ``examples/pictures`` of the checkout.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

from skyshine.mat.api.build import build
from skyshine.mat.api.examples import starter_files
from skyshine.mat.api.scene import Scene

SHOWN = (
    "built/pictures/yellowstone_road.tmm.png",
    "built/pictures/s01.htt.png",
    "built/pictures/s01b01.atmq.png",
    "built/pictures/b02.band.png",
    "rendered/yellowstone_day.png",
)


def draw(folder: Path) -> None:
    """Put the pictures into a folder, under their names; all of them or, where something fails, none."""
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        for file in starter_files():
            shutil.copyfile(file, work / file.name)
        build(work / "job.yaml")
        Scene(work / "scene.yaml").render()
        for picture in SHOWN:
            shutil.copyfile(work / picture, folder / Path(picture).name)


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
