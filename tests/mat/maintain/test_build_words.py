"""The log and the terminal of a build, as one command draws them for the documents."""

import pytest

from mat.maintain import build_words


@pytest.mark.parametrize("name", ["month_build.log", "month_build.svg"])
def test_the_drawn_files_are_in_the_checkout(pytestconfig, name):
    text = (pytestconfig.rootpath / "examples" / "pictures" / name).read_text(encoding="utf-8")
    assert "s30" in text and "61" in text


@pytest.mark.validation  # 3 s: a program of developers
def test_a_build_is_drawn(tmp_path, tiny_job, build_inline, monkeypatch):
    monkeypatch.setattr(build_words, "build", build_inline)
    text, picture = build_words.draw(tmp_path, tiny_job(), steps=(1, 3))
    lines = text.read_text().splitlines()
    assert lines[0] == "$ mat build job.yaml --verbose" and sum("built in" in line for line in lines) == 3
    assert lines[-1].startswith("built: 3 files in ")
    drawn = picture.read_text()
    assert drawn.startswith("<svg") and "1/3" in drawn and "3/3" in drawn
