"""What the channels and values of an image are taken to be, by what the file says and by its texels.

A fourth channel that a file calls alpha is often none: GDAL writes it so by default beside three bands, and engines
pack heights into it. Cameras and satellites fill a part of 16 bits.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError, nearest
from skyshine.tmm.images.georeference import is_tiff
from skyshine.tmm.images.raster import Raster

CLEAR = 0.5  # least share of the texels that alpha has at one of its ends; heights and near infrared have few there
# Whites of 16 bit files: of 8, 10, 11, 12 and 14 bits, and of reflectance times 10,000 (Sentinel-2, Landsat).
WHITES = (255, 1023, 2047, 4095, 10_000, 16_383)
PART = 4  # the brightest texels of a 16 bit image below this part of the full scale are taken to be white
BRIGHTEST = 99.9  # percentile that counts as the brightest: single texels shine
SAMPLE = 1 << 22  # texels that are looked at, about
PIECE_TEXELS = 1 << 21  # read at a time


@dataclass(frozen=True)
class Intake:
    """What the channels and values of an image are taken to be.

    colours : tuple of int; channels of red, green, blue and, where there is one, near infrared.
    alpha : int or None; channel of alpha.
    opaque : float; value of alpha that is fully opaque.
    white : float or None; stored value of white; None: the largest value of the type.
    interpretation : dict of str to str; the same in words, by what it is about.
    warnings : tuple of str; what may not be meant.
    """

    colours: tuple[int, ...]
    alpha: int | None
    opaque: float
    white: float | None
    interpretation: dict[str, str]
    warnings: tuple[str, ...] = field(default=())


def take_in(path: Path, image: Raster, near_infrared: str | None, alpha: str, white: float | str | None) -> Intake:
    """Find what the channels and values of an image are.

    Raises InputError: the image lacks a channel.

    near_infrared : str or None; name or number, from 1, of that channel, by the job; ``none`` where there is none.
    alpha : {"auto", "no-data", "ignore"}; ``no-data``: what the file calls alpha is alpha, whatever its values.
    white : float, "auto" or None; ``auto``: by the data; None: the largest value of the type.
    """
    names = image.channel_names
    infrared_channel = None if near_infrared in (None, "none") else _named(path, names, str(near_infrared))
    alpha_channel = (
        image.alpha if image.alpha is not None else 3 if image.channels == 4 and infrared_channel is None else None
    )
    alpha_channel = None if alpha_channel == infrared_channel else alpha_channel
    sample = _sample(image) if alpha_channel is not None or (white == "auto" and image.dtype == np.uint16) else None
    is_alpha, why = alpha_channel is not None, "as the file says"
    opaque = float(np.iinfo(image.dtype).max) if image.dtype.kind == "u" else 1.0
    if alpha_channel is not None and sample is not None:
        if image.dtype == np.uint16 and sample[:, alpha_channel].max(initial=0) <= 255:
            opaque = 255.0
        if alpha != "no-data":
            is_alpha, why = _like_alpha(sample[:, alpha_channel], opaque, image.alpha is not None)
    colours = _colours(path, names, {alpha_channel, infrared_channel} - {None})
    infrared = infrared_channel
    interpretation, warnings = {"colours": ", ".join(names[i] for i in colours)}, []
    if (
        alpha_channel is not None
        and not is_alpha
        and infrared_channel is None
        and near_infrared is None
        and is_tiff(path)
    ):
        infrared = alpha_channel
    if infrared is not None:
        interpretation["near infrared"] = f"{names[infrared]} ({'by the job' if infrared_channel is not None else why})"
    if alpha_channel is not None and is_alpha:
        interpretation["alpha"] = f"{names[alpha_channel]} ({why})" + (", ignored" if alpha == "ignore" else "")
    elif alpha_channel is not None and infrared != alpha_channel:
        interpretation["not used"] = f"{names[alpha_channel]} ({why})"
    level = white if isinstance(white, float) else None
    if white == "auto" and image.dtype == np.uint16 and sample is not None:
        level = _white(sample[:, list(colours)])
    if level is not None:
        interpretation["white"] = f"{level:g} of {np.iinfo(np.uint16).max}"
        if white == "auto":
            warnings.append(
                f"its 16 bit values fill less than a quarter of their range; {level:g} is taken to be white: say "
                "'white' if it is another value"
            )
    picked = (*colours, *(() if infrared is None else (infrared,)))
    alpha_used = alpha_channel if is_alpha and alpha != "ignore" else None
    return Intake(picked, alpha_used, opaque, level, interpretation, tuple(warnings))


def _sample(image: Raster) -> npt.NDArray[Any]:
    """Texels (N, C) of a regular grid."""
    step = max(int(np.sqrt(image.height * image.width / SAMPLE)), 1)
    down = max(PIECE_TEXELS // image.width // step, 1) * step
    bands = []
    for top in range(0, image.height, down):
        rows = image.rows(top, min(top + down, image.height))
        bands.append(rows[::step, ::step].reshape(-1, image.channels).copy())
    return np.concatenate(bands)


def _like_alpha(values: npt.NDArray[Any], opaque: float, stated: bool) -> tuple[bool, str]:
    """Whether values (N,) are those of alpha, and why."""
    ends = float(np.mean((values <= 0) | (values >= opaque)))
    two = len(np.unique(values[: 1 << 16])) <= 2 and len(np.unique(values)) <= 2
    if stated:
        what = "the file says alpha, and"
        return (two or ends >= CLEAR), (
            f"{what} it has two values" if two else f"{what} {100 * ends:.0f} % of its texels are clear or opaque"
        )
    if two and ends == 1:
        return True, "it has the two values of a mask"
    return False, "the fourth of four, and no mask"


def _white(colours: npt.NDArray[Any]) -> float | None:
    """The value that is white, of texels (N, 3) of 16 bits; None where they fill them."""
    brightest = float(np.percentile(colours, BRIGHTEST)) if colours.size else 0.0
    if not 0 < brightest < np.iinfo(np.uint16).max / PART:
        return None
    return float(next(white for white in WHITES if white >= brightest))


def _colours(path: Path, names: list[str], others: set[Any]) -> tuple[int, ...]:
    """Numbers of the channels red, green and blue; grey is repeated."""
    left = [i for i in range(len(names)) if i not in others]
    if {"R", "G", "B"} <= set(names):
        return tuple(names.index(c) for c in "RGB")
    if len(left) == 1:
        return tuple(left * 3)
    if len(left) >= 3:
        return tuple(left[:3])
    raise InputError(f"has the channels {', '.join(names)}; allowed: grey or R, G, B, with or without A", file=path)


def _named(path: Path, names: list[str], channel: str) -> int:
    if channel in names:
        return names.index(channel)
    if channel.isdecimal() and 1 <= int(channel) <= len(names):
        return int(channel) - 1
    raise InputError(
        f"has no channel '{channel}'; {nearest(channel, names)}, or a number from 1 to {len(names)}", file=path
    )
