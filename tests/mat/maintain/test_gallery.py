"""The gallery: twelve pictures, small, each under lines that name it."""

import shlex

import click
import pytest
from PIL import Image

from mat.maintain import gallery
from mat.maintain.manual.command_pages import GROUPS


def test_the_page_shows_twelve_pictures_under_the_blocks_that_draw_them():
    shown = list(gallery.sections())
    assert len(shown) == 12
    for _, text, picture in shown:
        path = (gallery.PAGE.parent / picture).resolve()
        assert path.is_file() and path.stat().st_size <= gallery.LARGEST
        named = path.name in text or "mat render" in text or "--to gpu" in text
        assert named, f"no line of the block names {path.name}"
    own = {picture.rpartition("/")[2] for _, _, picture in shown if "/gallery/" in picture}
    assert {path.name for path in gallery.PICTURES.iterdir()} == own


def test_python_of_the_page_is_python_and_commands_are_those_that_exist():
    for language, text, _ in gallery.sections():
        if language == "python":
            compile(text, "gallery.md", "exec")
            continue
        for line in text.splitlines():
            program, name, *arguments = shlex.split(line)
            if program != "chromium":
                context = click.Context(GROUPS[program], **GROUPS[program].context_settings)
                command = GROUPS[program].get_command(context, name)
                # An unknown option is refused.
                command.make_parser(click.Context(command, parent=context)).parse_args(arguments)


@pytest.mark.validation  # 15 s
@pytest.mark.parametrize("text", [text for language, text, _ in gallery.sections() if language == "python"])
def test_python_of_the_page_runs(text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(text, "gallery.md", "exec"), {})
    assert len(list(tmp_path.glob("*.png"))) == 1


def test_a_picture_of_many_colours_is_made_to_fit(tmp_path):
    Image.effect_noise((1400, 900), 60).save(tmp_path / "noise.png")
    flat = Image.new("RGB", (1400, 900), "white")
    flat.paste("black", (100, 100, 900, 500))
    flat.save(tmp_path / "flat.png")
    gallery.shrink(tmp_path / "flat.png", tmp_path / "small.png")
    with Image.open(tmp_path / "small.png") as small:
        assert small.width == max(gallery.WIDTHS) and small.convert("L").getextrema() == (0, 255)
    with pytest.raises(ValueError, match="is larger than"):
        gallery.shrink(tmp_path / "noise.png", tmp_path / "small.png")
