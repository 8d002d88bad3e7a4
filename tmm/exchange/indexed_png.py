"""Indexed PNG: one palette entry a material, with a legend in JSON."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.materials.colours import material_colours
from skyshine.materials.library import MaterialLibrary, load_library
from skyshine.schemas.errors import InputError
from skyshine.tmm.database.levels import pure_level
from skyshine.tmm.exchange.files import write_bytes, write_json
from skyshine.tmm.exchange.image import MaterialImage, check_size
from skyshine.tmm.exchange.legend import legend, read_legend

MAX_MATERIALS = 255  # a palette has 256 entries, the first stands for no material


def write_png(folder: str | os.PathLike[str], image: MaterialImage) -> list[Path]:
    """Write ``NAME.png``, in the fixed colours of its materials, and ``NAME.legend.json``.

    Raises
    ------
    InputError
        There are more materials than palette entries, or a file cannot be written.
    """
    import io

    from PIL import Image

    if len(image.materials) > MAX_MATERIALS:
        raise InputError(
            f"'{image.name}' has {len(image.materials)} materials; allowed in an indexed PNG: {MAX_MATERIALS}; use --to"
            " gltf"
        )
    named = material_colours(tuple(image.materials.values()), load_library())
    colours = np.concatenate([np.zeros((1, 3), np.uint8), named])
    picture = Image.fromarray(image.index(first=1).astype(np.uint8)).convert("P")
    picture.putpalette(colours.tobytes(), "RGB")
    content = io.BytesIO()
    picture.save(content, format="PNG", optimize=False)
    paths = [Path(folder) / f"{image.name}{ending}" for ending in (".png", ".legend.json")]
    write_bytes(paths[0], content.getvalue())
    entries = {
        str(k): {**entry, "colour": "#{:02X}{:02X}{:02X}".format(*colours[k])} for k, entry in legend(image).items()
    }
    write_json(paths[1], {"image": paths[0].name, "no_material": 0, "materials": entries})
    return paths


def read_png(
    path: str | os.PathLike[str], legend_path: str | os.PathLike[str], library: MaterialLibrary
) -> MaterialImage:
    """Read an indexed or grey PNG (8 or 16 bit) with its legend; numbers that the legend has not are no material.

    Raises
    ------
    InputError
        The image is missing, damaged or in colour, or the legend is wrong.
    """
    numbers = read_indices(path)
    names = read_legend(legend_path, library)
    lookup = np.zeros(max(int(numbers.max()), *names) + 1, np.uint16)
    for number, name in names.items():
        lookup[number] = library.code(name)
    code = lookup[numbers]
    if not code.any():
        raise InputError(
            f"has no number that {Path(legend_path).name} names; check that they belong together", file=path
        )
    used = {int(c): library.by_code(int(c)).name for c in np.unique(code[code > 0])}
    return MaterialImage(Path(path).stem, used, pure_level(code))


def palette_keys(path: str | os.PathLike[str], numbers: list[int]) -> dict[int, str]:
    """How a job names the numbers of an image: by colour ("#RRGGBB") where it has a palette, else as they are."""
    from PIL import Image

    with Image.open(path) as picture:
        colours = picture.getpalette("RGB") if picture.mode == "P" else None
    if colours is None:
        return {number: str(number) for number in numbers}
    table = np.zeros((max(*numbers, 255) + 1, 3), int)
    table[: len(colours) // 3] = np.reshape(colours, (-1, 3))
    return {number: "#{:02X}{:02X}{:02X}".format(*table[number]) for number in numbers}


def read_indices(path: str | os.PathLike[str]) -> npt.NDArray[Any]:
    """Palette indices or grey values (H, W) of an image.

    Raises
    ------
    InputError
        It is missing, damaged or in colour.
    """
    from PIL import Image, UnidentifiedImageError

    if Path(path).exists() and not Path(path).is_file():
        raise InputError("is no file that can be read; check the image's path", file=path)
    try:
        with Image.open(path) as picture:
            check_size(picture.height, picture.width, path)
            if picture.mode not in ("P", "L", "1", "I;16"):
                raise InputError(
                    f"has the pixel type {picture.mode}; allowed: palette or grey of 8 or 16 bit; for colours that name"
                    " materials use 'labels' in a job",
                    file=path,
                )
            return np.array(picture.convert("L") if picture.mode == "1" else picture).astype(np.uint16)
    except FileNotFoundError:
        raise InputError("does not exist; check the image's path", file=path) from None
    except (UnidentifiedImageError, OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise InputError(
            f"is not a readable image ({str(error).splitlines()[0][:80]}); save it again", file=path
        ) from None
