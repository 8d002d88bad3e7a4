"""The shader that evaluates a pixel, in GLSL and HLSL from one source."""

from __future__ import annotations

import re
from importlib import metadata, resources
from pathlib import Path

from skyshine.schemas.whole_files import write_whole

NAMES = {"GLSL": "skyshine.glsl", "HLSL": "skyshine.hlsl"}
_SOURCE = "pixel.shader.j2"
# Words of GLSL, which the source is written in, in the other languages.
_WORDS: dict[str, tuple[tuple[str, str], ...]] = {
    "GLSL": (),
    "HLSL": ((r"\bvec([234])\b", r"float\1"), (r"\bivec([234])\b", r"int\1"), (r"\bmix\(", "lerp(")),
}


def shader(language: str) -> str:
    """Text of the include.

    Parameters
    ----------
    language : {'GLSL', 'HLSL'}
    """
    import jinja2

    environment = jinja2.Environment(
        undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
    )
    source = resources.files(__package__).joinpath(_SOURCE).read_text(encoding="utf-8")
    text = environment.from_string(source).render(language=language, version=metadata.version("skyshine"))
    for pattern, word in _WORDS[language]:
        text = re.sub(pattern, word, text)
    return text


def write_shaders(folder: Path) -> list[Path]:
    """Write the include in every language into a folder."""
    paths = []
    for language, name in NAMES.items():
        write_whole(folder / name, shader(language))
        paths.append(folder / name)
    return paths
