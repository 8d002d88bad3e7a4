"""Colour and texture at several scales, for classifiers that see more than a texel's own colour.

Chromaticities and energies of logarithms last in shadow, where light is weaker and bluer but its ratios between
neighbours are kept; see Finlayson et al. 2006, "On the removal of shadows from images", IEEE TPAMI 28:59-68.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.tmm.features.colour import DistinctColours, to_lab, to_linear
from skyshine.tmm.images.texture import Windowed

RADII = (2, 6, 16)  # radii of the boxes, in texels, beside the texel itself
GRADIENT_RADII = (4, 12)  # texels
MARGIN = max(RADII) + 1  # texels about a window that its features depend on
DARK = 0.004  # added to linear light before logarithms: about the first step of 8 bit sRGB that is above noise
BRIGHT = 1e6  # times white, to which light is limited, so that squares and sums of features stay finite
SHADOW_LIGHT = (0.22, 0.26, 0.36)  # skylight's share of clear-sky irradiance in red, green and blue
SHADOW_SPREAD = 0.25  # shadow spread of the logarithm of that share between shadows
# Spread of the logarithm of light between photographs of a library, found by leaving sheets of orthophotos out: all
# channels together (exposure, haze), and red and blue by themselves (season, hour, film).
LIGHT_SPREAD, TINT_SPREAD = 0.14, (0.03, 0.0, 0.05)
SHADOW_AREA = 0.5  # share of a training window that is put in shadow
BLOCK_COLOURS = 1 << 16  # whose light is computed at a time: float64 of all of them would be most of the memory
BLOB = 24  # texels: standard deviation of the noise whose level sets are the shadows' outlines
PENUMBRA = 0.15  # penumbra of that noise's own standard deviation, over which the light fades


def names() -> tuple[str, ...]:
    """Names of the F features, in their order."""
    lab = [f"{channel}_{radius}" for radius in (0, *RADII) for channel in ("L", "a", "b")]
    chroma = [f"log_{ratio}_{radius}" for radius in RADII for ratio in ("R/G", "B/G")]
    spread = [f"log_deviation_{radius}" for radius in RADII]
    gradient = [f"{what}_{radius}" for radius in GRADIENT_RADII for what in ("log_gradient", "coherence")]
    return (*lab, *chroma, *spread, *gradient)


def light_planes(colours: npt.NDArray[Any], encoding: str) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """L*a*b* and linear light, both (3, N) float32, of colours (N, C) as a texture stores them."""
    lab, linear = (np.empty((3, len(colours)), np.float32) for _ in range(2))
    for start in range(0, len(colours), BLOCK_COLOURS):
        part = slice(start, start + BLOCK_COLOURS)
        flat = colours[part, :3]
        if flat.dtype.kind == "f":
            flat = np.clip(flat, -BRIGHT, BRIGHT)
        lab[:, part], linear[:, part] = to_lab(flat, encoding).T, to_linear(flat, encoding).T
    return lab, linear


class LightPlanes:
    """L*a*b* and linear light of the windows of a texture: of each distinct colour once, where they are known."""

    def __init__(self, texture: Windowed, colours: DistinctColours) -> None:
        self._texture, self._colours = texture, colours
        self._shared = None if colours.colours is None else light_planes(colours.colours, texture.encoding)

    def window(
        self, rows: slice, columns: slice
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], npt.NDArray[np.bool_]]:
        """L*a*b* and linear light (3, h, w) float32, and validity (h, w), of a window."""
        pixels, valid = self._texture.window(rows, columns)
        colours, index = self._colours.of(pixels, valid)
        if colours is None and self._shared is not None:
            planes = self._shared
        else:
            if colours is None:
                colours, index = self._colours.in_use(index)
            planes = light_planes(colours, self._texture.encoding)
        lab, linear = (np.take(part, index.ravel(), axis=1).reshape(3, *valid.shape) for part in planes)
        return lab, linear, valid


def features(
    lab: npt.NDArray[np.float32], linear: npt.NDArray[np.float32], valid: npt.NDArray[np.bool_], step: int = 1
) -> npt.NDArray[Any]:
    """Features of every texel of a window, or of every `step`-th row and column of them.

    lab, linear : (3, h, w) float32; L*a*b* and linear light; written to.
    valid : (h, w) bool; texels without data take the mean of those with data.

    Returns
    -------
    (F, h, w) float32
        The outer `MARGIN` of them depends on what lies beyond, taken as mirrored.
    """
    if not valid.all():
        for part in (lab, linear):
            part[:, ~valid] = part[:, valid].mean(axis=1, keepdims=True) if valid.any() else 0
    return _stack(lab, np.maximum(linear, 0), step)


def _stack(lab: npt.NDArray[np.float32], linear: npt.NDArray[np.float32], step: int) -> npt.NDArray[Any]:
    coarse = lab[:, ::step, ::step]
    stack = np.empty((len(names()), *coarse.shape[1:]), np.float32)
    stack[:3] = coarse
    at = 3
    for means in zip(*(box_means(plane, RADII, step) for plane in lab), strict=True):
        stack[at : at + 3] = means
        at += 3
    for means in zip(*(box_means(plane, RADII, step) for plane in linear), strict=True):
        red, green, blue = (np.log(part + np.float32(DARK)) for part in means)
        stack[at], stack[at + 1] = red - green, blue - green
        at += 2
    light = np.log(linear[1] + np.float32(DARK))
    for squared, level in zip(*(box_means(part, RADII, step) for part in (light * light, light)), strict=True):
        stack[at] = 0.5 * np.log(np.maximum(squared - level**2, 0) + np.float32(1e-4))
        at += 1
    down, across = (np.gradient(light, axis=i) if light.shape[i] > 1 else np.zeros_like(light) for i in (0, 1))
    products = down * down, across * across, down * across
    for dd, aa, da in zip(*(box_means(product, GRADIENT_RADII, step) for product in products), strict=True):
        energy = dd + aa
        stack[at] = 0.5 * np.log(np.maximum(energy, 0) + np.float32(1e-4))
        # Coherence of the structure tensor, (l1 - l2) / (l1 + l2) of its eigenvalues (Bigun and Granlund 1987).
        stack[at + 1] = np.sqrt((dd - aa) ** 2 + 4 * da**2) / (energy + np.float32(1e-4))
        at += 2
    return stack


def box_means(plane: npt.NDArray[np.float32], radii: tuple[int, ...], step: int = 1) -> list[npt.NDArray[Any]]:
    """Means of a plane (h, w) over boxes of several radii, at every `step`-th row and column.

    Beyond its edges the plane is mirrored.
    """
    from scipy.ndimage import uniform_filter1d

    height, margin = len(plane), max(radii)
    sums = np.empty((height + 2 * margin + 1, plane.shape[1]))  # over the rows above each, those mirrored included
    sums[0] = 0
    for k, row in enumerate(np.pad(np.arange(height), margin, mode="symmetric")):
        np.add(sums[k], plane[row], out=sums[k + 1])
    means = []
    for radius in radii:
        top, size = margin - radius, 2 * radius + 1
        rows = sums[top + size : top + size + height : step] - sums[top : top + height : step]
        rows /= size
        means.append(uniform_filter1d(rows.astype(np.float32), size, axis=1, mode="reflect")[:, ::step])
    return means


def in_other_light(linear: npt.NDArray[np.float32], random: np.random.Generator) -> npt.NDArray[Any]:
    """Linear light (h, w, 3) as another photograph of a library might have it."""
    gain = np.exp(LIGHT_SPREAD * random.standard_normal() + np.array(TINT_SPREAD) * random.standard_normal(3))
    return (linear * gain).astype(np.float32)


def in_shadow(
    colours: npt.NDArray[Any], encoding: str, random: np.random.Generator
) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """A window with smooth random shadows on it.

    colours : (h, w, C)
    random : Generator

    Returns
    -------
    colours : (h, w, 3) float32; linear light.
    shadow : (h, w) bool; where less than half of the direct light is left.
    """
    from scipy.ndimage import gaussian_filter

    height, width = colours.shape[:2]
    noise = gaussian_filter(random.standard_normal((height, width)), BLOB, mode="wrap")
    noise /= noise.std() or 1.0
    shade = 1 / (1 + np.exp(-(noise - np.quantile(noise, 1 - SHADOW_AREA)) / (PENUMBRA / 4)))
    left = np.array(SHADOW_LIGHT) * np.exp(SHADOW_SPREAD * random.standard_normal())
    linear = to_linear(colours.reshape(-1, colours.shape[2])[:, :3], encoding).reshape(height, width, 3)
    return (linear * (1 - shade[..., np.newaxis] * (1 - left))).astype(np.float32), shade > 0.5
