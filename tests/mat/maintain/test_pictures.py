"""The pictures of all pages are those that one command draws."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from mat.maintain import pictures


def test_each_picture_of_a_page_is_drawn_by_the_command(pytestconfig):
    checkout = pytestconfig.rootpath
    drawn = {name.rsplit("/", 1)[-1] for name in pictures.SHOWN} | set(pictures.build_words.FILES)
    pages = [page.read_text(encoding="utf-8") for page in checkout.rglob("*.md") if ".venv" not in page.parts]
    shown = {name for page in pages for name in re.findall(r"\((?:\.\./)*(?:examples/)?pictures/([^)/]+)\)", page)}
    assert shown == drawn == {file.name for file in (checkout / "examples" / "pictures").iterdir() if file.is_file()}


def test_a_command_that_fails_leaves_the_pictures_alone(tmp_path):
    with pytest.raises(subprocess.CalledProcessError):
        pictures.draw(tmp_path, Path(shutil.which("false")))
    assert list(tmp_path.iterdir()) == []
