"""Draws all pictures of the pages: the starter job is built and its scene rendered, a material gets its card, a
month is built for its words.

Run ``python -m mat.maintain.pictures FOLDER``; FOLDER is ``examples/pictures`` of the checkout. It takes some
minutes.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from mat.maintain import build_words
from mat.maintain.textures import three_ways

CARD = "asphalt_road"
SHOWN = (
    "built/pictures/yellowstone_road.tmm.png",
    "built/pictures/s01.htt.png",
    "built/pictures/s01b01.atmq.png",
    "built/pictures/b02.band.png",
    "street/rendered/street_day.png",
    f"{CARD}.card.png",
    "three_ways.png",
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
        street = shutil.copytree(Path(__file__).parents[2] / "examples" / "street", work / "street")
        for arguments in (
            ("init", work),
            ("build", work / "job.yaml"),
            ("build", street / "job.yaml"),
            ("render", street / "scene.yaml"),
            ("materials", CARD, "--out", work / f"{CARD}.card.png"),
        ):
            subprocess.run([mat, *arguments], check=True)
        build_words.draw(work)
        three_ways.draw(work / "three_ways.png", folder.resolve().parent / "textures" / "job.tmm.yaml")
        for picture in (*SHOWN, *build_words.FILES):
            shutil.copyfile(work / picture, folder / Path(picture).name)


if __name__ == "__main__":
    draw(Path(sys.argv[1]), Path(sys.executable).with_name("mat"))
