"""One fixed colour a material, by which pictures and exported palettes show it.

It is the colour that the material has in daylight, by its reflectance spectrum, moved as little as it takes to differ
from the packaged materials before it. So a picture of a material map looks like a photograph, and the same material has
the same colour in every picture.
"""

from __future__ import annotations

import csv
import warnings
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine import materials
from skyshine.materials.library import MaterialLibrary

FILE = "colours.csv"
WAVELENGTHS = np.arange(0.38, 0.7801, 0.005)  # um
CHROMA = 1.8  # times that of the spectrum: on a map, materials lie beside others than in nature
DARKEST, BRIGHTEST = 25.0, 97.0  # L* that 0 and 100 become, so that black stays that of no material
# Linear sRGB of XYZ (IEC 61966-2-1).
_SRGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])


def natural_colour(wavelength: npt.NDArray[np.float64], reflectance: npt.NDArray[np.float64]) -> npt.NDArray[Any]:
    """Colour (3,) sRGB, 0 to 1, of a surface beside a white one in the same light.

    Parameters
    ----------
    wavelength : (N,) float64
        Ascending [um].
    reflectance : (N,) float64
        0 to 1.

    Notes
    -----
    Colour matching functions of the CIE 1931 observer as the lobes of Wyman, Sloan and Shirley 2013, "Simple analytic
    approximations to the CIE XYZ color matching functions", J. Comput. Graph. Tech. 2(2):1-11. The light has the same
    power at all wavelengths; its white is scaled to that of sRGB (von Kries in XYZ).

    Examples
    --------
    >>> natural_colour(np.array([0.3, 1.0]), np.array([1.0, 1.0])).round(2).tolist()
    [1.0, 1.0, 1.0]
    >>> natural_colour(np.array([0.3, 0.6, 0.61, 1.0]), np.array([0.0, 0.0, 1.0, 1.0])).round(1).tolist()
    [0.8, 0.0, 0.0]
    """
    sensitivity = _matching(1000 * WAVELENGTHS)
    response = sensitivity @ np.interp(WAVELENGTHS, wavelength, reflectance) / sensitivity.sum(axis=1)
    white = np.linalg.inv(_SRGB).sum(axis=1)
    linear = np.clip(_SRGB @ (response * white), 0, 1)
    encoded: npt.NDArray[np.float64] = np.where(
        linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055
    )
    return encoded


def _matching(nm: npt.NDArray[np.float64]) -> npt.NDArray[Any]:
    """Sensitivities (3, N) of the CIE 1931 observer at wavelengths (N,) in nm."""

    def lobe(height: float, centre: float, below: float, above: float) -> npt.NDArray[Any]:
        bell: npt.NDArray[Any] = height * np.exp(-(((nm - centre) * np.where(nm < centre, below, above)) ** 2) / 2)
        return bell

    return np.stack(
        [
            lobe(0.362, 442.0, 0.0624, 0.0374)
            + lobe(1.056, 599.8, 0.0264, 0.0323)
            + lobe(-0.065, 501.1, 0.0490, 0.0382),
            lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322),
            lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725),
        ]
    )


def spread_colours(colours: npt.NDArray[np.float64], apart: float) -> npt.NDArray[Any]:
    """Move colours (K, 3) sRGB, each as little as it takes to be `apart` in CIELAB from those before it.

    Chroma and the lightness of what is dark are raised first. The result is rounded to 8 bit, (K, 3) uint8.
    """
    from skimage.color import lab2rgb, rgb2lab

    steps = np.arange(-60, 61, 4.0)
    moves = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    moves = moves[np.argsort((moves**2).sum(axis=1), kind="stable")]
    chosen = np.empty((len(colours), 3))
    result = np.empty((len(colours), 3), np.uint8)
    for k, colour in enumerate(rgb2lab(colours)):
        start = (DARKEST + colour[0] / 100 * (BRIGHTEST - DARKEST), *(CHROMA * colour[1:]))
        candidates = start + moves
        candidates = candidates[(candidates[:, 0] >= DARKEST) & (candidates[:, 0] <= BRIGHTEST)]
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Conversion from CIE-LAB", category=UserWarning)
            displayable = rgb2lab(lab2rgb(candidates))  # what lies beyond sRGB comes back at its border
        far = ((displayable[:, np.newaxis] - chosen[:k]) ** 2).sum(axis=2).min(axis=1, initial=np.inf) >= apart**2
        at = np.argmax(far & (np.abs(displayable - candidates).max(axis=1) < 2))
        result[k] = np.rint(255 * lab2rgb(displayable[at]))
        chosen[k] = rgb2lab(result[k] / 255)
    return result


def material_colours(names: Sequence[str], library: MaterialLibrary) -> npt.NDArray[np.uint8]:
    """Colours (K, 3) of materials, sRGB; no two are the same and none is black.

    Those of the packaged materials are fixed; a material of a user's own library has that of its spectrum, and one that
    the library does not have is magenta.
    """
    fixed, assigned = _packaged(), {(0, 0, 0)}
    colours = np.empty((len(names), 3), np.uint8)
    for k, name in enumerate(names):
        if name in fixed:
            colour = fixed[name]
        elif name in library:
            material = library[name]
            red, green, blue = spread_colours(
                natural_colour(material.wavelength, material.reflectance)[np.newaxis], 0.0
            )[0]
            colour = int(red), int(green), int(blue)
        else:
            colour = 255, 0, 255
        while colour in assigned:  # the next one, which looks alike
            number = (sum(part << shift for part, shift in zip(colour, (16, 8, 0), strict=True)) + 1) % (1 << 24)
            colour = number >> 16, number >> 8 & 255, number & 255
        assigned.add(colour)
        colours[k] = colour
    return colours


@lru_cache(maxsize=1)
def _packaged() -> dict[str, tuple[int, int, int]]:
    with open(materials.path() / FILE, encoding="utf-8", newline="") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return {row["material"]: (int(row["red"]), int(row["green"]), int(row["blue"])) for row in rows}
