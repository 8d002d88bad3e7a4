"""The pictures of the README are those that one command draws."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from skyshine.mat.maintain import pictures


def test_each_picture_of_the_readme_is_drawn_by_the_command(pytestconfig):
    shown = re.findall(r"\(examples/pictures/([^)]+)\)", (pytestconfig.rootpath / "README.md").read_text())
    assert sorted(shown) == sorted(name.rsplit("/", 1)[-1] for name in pictures.SHOWN)


def test_a_command_that_fails_leaves_the_pictures_alone(tmp_path):
    with pytest.raises(subprocess.CalledProcessError):
        pictures.draw(tmp_path, Path(shutil.which("false")))
    assert list(tmp_path.iterdir()) == []
