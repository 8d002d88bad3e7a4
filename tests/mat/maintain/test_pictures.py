"""The pictures of the README are those that one command draws."""

import re

import pytest

from skyshine.mat.maintain import pictures
from skyshine.schemas.errors import CheckFailed


def test_each_picture_of_the_readme_is_drawn_by_the_command(pytestconfig):
    shown = re.findall(r"\(examples/pictures/([^)]+)\)", (pytestconfig.rootpath / "README.md").read_text())
    assert sorted(shown) == sorted(name.rsplit("/", 1)[-1] for name in pictures.SHOWN)


def test_a_build_that_fails_leaves_the_pictures_alone(tmp_path, monkeypatch):
    def fail(job):
        raise CheckFailed("no tables here")

    monkeypatch.setattr(pictures, "build", fail)
    with pytest.raises(CheckFailed, match="no tables here"):
        pictures.draw(tmp_path)
    assert list(tmp_path.iterdir()) == []
