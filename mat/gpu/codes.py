"""A ``.tmm`` database as textures: 16-bit numbers of mixtures with their mip levels, and the mixtures."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.mat.gpu.air import source_of
from skyshine.mat.gpu.container import GpuFile, texture
from skyshine.tmm.database.levels import WEIGHT_TOTAL
from skyshine.tmm.database.reader import TmmFile

MOST = 1 << 16  # numbers of a 16-bit texture
WIDTH = 1024  # mixtures in a row of their texture
_STEPS = (WEIGHT_TOTAL, 1000, 200, 100, 40, 20, 10, 4, 2, 1)  # shares are rounded to one of them, if need be


def export_codes(file: TmmFile, name: str) -> GpuFile:
    """Numbers of mixtures by texel, its share in the shade where the file has that, and the mixtures themselves.

    Shares are rounded where a texture has more mixtures than a 16-bit texture can number; the header states by how
    much.

    Parameters
    ----------
    name : str
        Name of the database.
    """
    levels = [_mixtures(file, level) for level in range(file.levels)]
    shapes = [file.size(level) for level in range(file.levels)]
    rows = np.concatenate(levels)
    for steps in _STEPS:
        rounded = _rounded(rows, steps)
        mixtures, number = np.unique(rounded, axis=0, return_inverse=True)
        if len(mixtures) <= MOST:
            break
    largest = float(np.abs(rounded[:, 3:].astype(float) - rows[:, 3:]).max(initial=0.0)) / WEIGHT_TOTAL
    number = number.reshape(-1).astype(np.uint16)
    height = -(-len(mixtures) // WIDTH)
    table = np.zeros((height * WIDTH, 2, 4), np.uint16)
    table[: len(mixtures), 0, :3], table[: len(mixtures), 1, :3] = mixtures[:, :3], mixtures[:, 3:]
    textures, start = {}, 0
    for level, (down, across) in enumerate(shapes):
        texels = number[start : start + down * across].reshape(down, across)
        textures[f"level{level}"] = texture("R16UI", texels, "number of the mixture of a texel, rows from the top")
        start += down * across
        if file.has_shade:
            shade = file.array(f"levels/{level}/shade")
            textures[f"shade{level}"] = texture("R8", shade, "share of a texel in the shade of the photograph, 0 to 1")
    textures["mixtures"] = texture(
        "RGBA16UI",
        table.reshape(height, WIDTH * 2, 4),
        f"mixture n at column 2 (n mod {WIDTH}), row n div {WIDTH}: three material codes, then their shares",
    )
    numbers = {
        "width": file.width,
        "height": file.height,
        "levels": file.levels,
        "mixtures": len(mixtures),
        "share_total": WEIGHT_TOTAL,
        "material": [int(code) for code in file.materials],
        "material_name": list(file.materials.values()),
        "texture": str(file.attributes["texture"]),
    }
    stated = {"units": "1", "largest": largest, "of": "share"}
    return GpuFile("texture", source_of(name, file.attributes), textures, numbers, stated)


def _mixtures(file: TmmFile, level: int) -> npt.NDArray[np.uint16]:
    """Codes and shares (n, 6) of the texels of a level; unused places have code 0."""
    codes, shares = (file.array(f"levels/{level}/{part}").reshape(-1, 3) for part in ("mix_code", "mix_weight"))
    return np.concatenate([np.where(shares > 0, codes, 0), shares], axis=1).astype(np.uint16)


def _rounded(rows: npt.NDArray[np.uint16], steps: int) -> npt.NDArray[np.uint16]:
    """Shares rounded to multiples of 1 / steps; the first takes what is missing to the whole."""
    if steps == WEIGHT_TOTAL:
        return rows
    rounded = rows.astype(np.int64)
    share = np.round(rounded[:, 3:] * (steps / WEIGHT_TOTAL)).astype(np.int64) * WEIGHT_TOTAL // steps
    occupied = rounded[:, 0] > 0
    share[:, 0] = np.where(occupied, WEIGHT_TOTAL - share[:, 1:].sum(axis=1), 0)
    rounded[:, 3:] = share
    rounded[:, 1:3][share[:, 1:] == 0] = 0
    return rounded.astype(np.uint16)
