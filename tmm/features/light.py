"""Light of a texture: linear from what its file contains and back, in windows, and masks with the edges of light."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.tmm.features.colour import to_linear
from skyshine.tmm.images.texture import Windowed

LEAST_LIGHT = 2e-3  # fraction of white: where sensors and compression leave no ratio of channels
LUMINANCE = (0.2126, 0.7152, 0.0722)  # luminance of linear Rec. 709
GUIDED_RADIUS = 6  # texels of the guided filter
_EDGE = 0.02  # variance of the logarithm below which the guided filter takes no edge: a seventh of the light
_LEAK = 0.05  # weight of the guided filter, that is taken for none and, likewise, for all
_WINDOW, _WINDOWS = 512, 16  # texels and number of the windows in which a whole texture is looked at


def linear_light(colours: npt.NDArray[Any], encoding: str) -> npt.NDArray[np.float64]:
    """Linear light (h, w, C) of a window's colours; near infrared is linear as it is stored."""
    light: npt.NDArray[np.float64] = np.empty(colours.shape)
    flat = colours.reshape(-1, colours.shape[-1])
    light[..., :3] = to_linear(flat[:, :3], encoding).reshape(*colours.shape[:2], 3)
    if colours.shape[-1] > 3:
        scale = np.iinfo(colours.dtype).max if colours.dtype.kind == "u" else 1.0
        light[..., 3:] = colours[..., 3:] / np.float64(scale)
    return np.nan_to_num(light, posinf=0.0, neginf=0.0)


def light_windows(texture: Windowed) -> Iterator[tuple[npt.NDArray[Any], npt.NDArray[np.bool_]]]:
    """Linear light and validity of windows spread over a texture; all of a small one."""
    rows, columns = (max(length // _WINDOW, 1) for length in (texture.height, texture.width))
    windows = [(row, column) for row in range(rows) for column in range(columns)]
    for number in np.unique(np.linspace(0, len(windows) - 1, min(_WINDOWS, len(windows))).astype(int)):
        row, column = windows[number]
        top, left = row * texture.height // rows, column * texture.width // columns
        bottom, right = (row + 1) * texture.height // rows, (column + 1) * texture.width // columns
        colours, valid = texture.window(slice(top, bottom), slice(left, right))
        yield linear_light(colours, texture.encoding), valid.copy()


def stored_light(light: npt.NDArray[Any], encoding: str, dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    """Linear light (h, w, C) as a file of this encoding and type stores it."""
    values = light
    if encoding == "srgb":  # IEC 61966-2-1; near infrared is stored as it is
        colours = light[..., :3]
        bent = np.where(
            colours > 0.0031308, 1.055 * np.maximum(colours, 0.0031308) ** (1 / 2.4) - 0.055, 12.92 * colours
        )
        values = np.concatenate([bent, light[..., 3:]], axis=-1)
    if dtype.kind == "f":
        return values.astype(dtype)
    limit = np.iinfo(dtype).max
    stored: npt.NDArray[Any] = np.rint(np.clip(values, 0.0, 1.0) * limit).astype(dtype)
    return stored


def guided(mask: npt.NDArray[Any], guide: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """A mask (h, w), 0 to 1, with the edges of its guide (h, w), the logarithm of light."""
    slope, offset = guided_lines(mask, guide, GUIDED_RADIUS, _EDGE)
    filtered: npt.NDArray[Any] = np.clip((slope * guide + offset - _LEAK) / (1 - 2 * _LEAK), 0.0, 1.0)
    return filtered


def guided_lines(
    planes: npt.NDArray[Any], guide: npt.NDArray[Any], radius: int, edge: float
) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Slopes and offsets (..., h, w) by which planes (..., h, w) follow their guide (h, w), where its variance in a box
    is above `edge` (He, Sun and Tang 2013, IEEE TPAMI 35:1397-1409).
    """
    from scipy.ndimage import uniform_filter

    def mean(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        averaged: npt.NDArray[Any] = uniform_filter(values, 2 * radius + 1, mode="reflect", axes=(-2, -1))
        return averaged

    average, level = mean(guide), mean(planes)
    variance = np.maximum(mean(guide * guide) - average**2, 0) + guide.dtype.type(edge)
    slope = (mean(guide * planes) - average * level) / variance
    return mean(slope), mean(level - slope * average)
