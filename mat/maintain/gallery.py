"""Runs the blocks of the gallery's page and puts the pictures that they draw beside the other pictures of the pages.

Run ``python -m mat.maintain.gallery FOLDER``; what FOLDER has of earlier builds is kept. It needs Chromium
for one picture. Look at what it draws.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from itertools import product
from pathlib import Path

from PIL import Image

CHECKOUT = Path(__file__).parents[2]
PAGE = CHECKOUT / "examples" / "manual" / "gallery.md"
PICTURES = CHECKOUT / "examples" / "pictures" / "gallery"
WIDTHS = (1000, 800, 640, 500)  # pixels; the widest of which a palette fits
LARGEST = 60_000  # bytes of a picture
COLOURS = ((256, 128), (64, 32))  # colours of a palette: with 64 or fewer colour bars have steps, so they come last


def sections() -> Iterator[tuple[str, str, str]]:
    """Language and text of the block of each section, and the name of its picture."""
    for section in PAGE.read_text(encoding="utf-8").split("\n## ")[1:]:
        block = re.search(r"^```(sh|python)\n(.*?)^```", section, re.MULTILINE | re.DOTALL)
        picture = re.search(r"!\[[^\]]+\]\(([^)]+)\)", section)
        if block is None or picture is None:
            raise ValueError(f"{PAGE}: {section.splitlines()[0]}: a block and a picture are wanted")
        yield block[1], block[2], picture[1]


def draw(folder: Path) -> None:
    """Run the blocks in a folder and keep their pictures.

    Raises
    ------
    subprocess.CalledProcessError
        A block fails.
    FileNotFoundError
        A block draws no picture of the name that the page shows.
    """
    folder.mkdir(exist_ok=True)
    PICTURES.mkdir(exist_ok=True)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for language, text, shown in sections():
        program = ["sh", "-e", "-c"] if language == "sh" else [sys.executable, "-c"]
        text = re.sub(r"^mat init (\w+)(.*)$", r"test -e \1 || mat init \1\2", text, flags=re.MULTILINE)
        subprocess.run([*program, text], cwd=folder, check=True, env=os.environ | {"PATH": path, "MPLBACKEND": "agg"})
        name = Path(shown).name
        if (PAGE.parent / shown).resolve().parent == PICTURES:
            drawn = sorted(folder.rglob(name), key=lambda file: len(file.parts))
            if not drawn:
                raise FileNotFoundError(f"{name}: no block draws it")
            shrink(drawn[0], PICTURES / name)


def shrink(source: Path, target: Path) -> None:
    """Write a picture, or the middle of an animated one, as wide and with as many colours as fit the limit of bytes."""
    with Image.open(source) as opened:
        opened.seek(getattr(opened, "n_frames", 1) // 2)  # frame of an animated day: noon
        original = opened.convert("RGB")
    for palettes, widest in product(COLOURS, WIDTHS):
        width = min(widest, original.width)
        picture = original.resize((width, round(original.height * width / original.width)), Image.Resampling.LANCZOS)
        for colours in palettes:
            palette = picture.quantize(colours, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)  # keeps lines
            palette.save(target, optimize=True)
            if target.stat().st_size <= LARGEST:
                return
    raise ValueError(f"{target.name}: is larger than {LARGEST} bytes with {colours} colours")


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
