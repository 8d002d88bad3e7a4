"""An error budget in numbers: by source, by material, by field of view and slant, and its pixel scales.

Pixel values are those of equation (44). The note says that its function int rounds to the nearest integer. The nearest
to x - 1/2, halves upwards, is the largest integer that is not above x.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.budget.advice import described as advice
from skyshine.mat.budget.advice import headline
from skyshine.mat.budget.budget import PIXEL_SOURCES, SOURCES, Budget
from skyshine.mat.budget.frames import FIELDS_OF_VIEW
from skyshine.mat.budget.sizes import RADIANCE, in_kelvin, kelvin, measures, reported
from skyshine.mat.budget.views import OBSERVERS_KM
from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.quantity import quantity

WHOLE = ("pixel", "all", "tables")  # errors of several sources together
SLANTS = ((0.0, 3.0), (3.0, 10.0), (10.0, 30.0), (30.0, 90.0))  # degree of the line of sight from the horizon


BITS = (8, 12, 14, 16)


@dataclass(frozen=True)
class PixelScale:
    """Settings of a pixel buffer.

    Attributes
    ----------
    gain : float
        G, W m^-2 sr^-1: L/G is 1 at the highest radiance.
    buffer_gain, offset : float
        BG and DC: the lowest radiance gives pixel 0, the highest 2^bits - 1.
    """

    bits: int
    gain: float
    buffer_gain: float
    offset: float

    @classmethod
    def of(cls, lowest: float, highest: float, bits: int) -> PixelScale:
        """Settings that spread a range of radiance over all pixel values; a range of no width is one step wide."""
        if not 0 <= lowest <= highest or not np.isfinite(highest) or highest == 0:
            raise ValueError(f"no range of radiance: {lowest} to {highest}")
        offset = min(lowest / highest, 1 - 0.5**bits)
        return cls(bits, highest, 1 / (1 - offset), offset)

    @property
    def step(self) -> float:
        """Radiance from one pixel value to the next, W m^-2 sr^-1."""
        return self.gain / (self.buffer_gain * float(2**self.bits))

    def pixel(self, radiance: npt.ArrayLike) -> Integers:
        """Pixel values of radiances, (44); L/G is clipped to 0 to 1, and the value to the range of the buffer.

        Raises
        ------
        ValueError
            A radiance is not a number.
        """
        share = np.clip(np.asarray(radiance, float) / self.gain, 0.0, 1.0)
        if np.any(np.isnan(share)):
            raise ValueError("a radiance is not a number")
        value = np.floor(2**self.bits * self.buffer_gain * (share - self.offset))
        pixel: Integers = np.clip(value, 0, 2**self.bits - 1).astype(np.int64)
        return pixel

    def radiance(self, pixel: npt.ArrayLike) -> Floats:
        """Radiance in the middle of those that give a pixel value, W m^-2 sr^-1."""
        middle = np.asarray(pixel) + 0.5
        radiance: Floats = self.gain * (middle / (2**self.bits * self.buffer_gain) + self.offset)
        return radiance


def describe(budget: Budget) -> dict[str, Any]:
    """All numbers of a budget, in the shape of every command's JSON."""
    return {
        "state": budget.state,
        "band": budget.band,
        "wavelength": quantity([budget.response.lower, budget.response.upper], "um"),
        "source": budget.source,
        "materials": list(budget.materials),
        "views": len(budget.views),
        "errors": {name: _source(budget, name) for name in SOURCES if name in budget.errors},
        "dominant": dominant(budget),
        "advice": advice(budget),
        "regions": {name: _region(budget, rows) for name, rows in regions(budget).items() if rows.any()},
        "extrapolation": {
            "field_of_view": quantity(list(FIELDS_OF_VIEW), "degree"),
            "slant": [quantity(list(span), "degree") for span in SLANTS],
            "rms_kelvin": {name: quantity(_by_slant(budget, e), "K") for name, e in budget.extrapolation.items()},
            "rms": {
                name: quantity(_by_slant(budget, e, in_radiance=True), RADIANCE)
                for name, e in budget.extrapolation.items()
            },
        },
        "frames": {
            "field_of_view": quantity(list(FIELDS_OF_VIEW), "degree"),
            "rms_kelvin": {
                name: quantity([measures(kelvin(budget, e))["rms"] for e in errors], "K")
                for name, errors in budget.frames.items()
            },
            "rms": {
                name: quantity([measures(e)["rms"] for e in errors], RADIANCE) for name, errors in budget.frames.items()
            },
        },
        "radiance": quantity([float(budget.radiance.min()), float(budget.radiance.max())], RADIANCE),
        "pixel_scales": [_scale(budget, bits) for bits in BITS],
    }


def _source(budget: Budget, name: str) -> dict[str, Any]:
    error = budget.errors[name]
    counted = budget.counted.get(name)
    weight = None if counted is None else np.broadcast_to(counted[:, None] * 1.0, error.shape)
    if error.ndim == 3:
        weight = budget.assigned_share
    error_kelvin = kelvin(budget, error)
    by_material = [
        measures(part[:, number], _of_material(weight, error.ndim, number))["rms"]
        for part in (error, error_kelvin)
        for number in range(len(budget.materials))
    ]
    count = len(budget.materials)
    return {
        "what": SOURCES[name],
        "radiance": {key: quantity(value, RADIANCE) for key, value in reported(error, weight).items()},
        "temperature": {key: quantity(value, "K") for key, value in reported(error_kelvin, weight).items()},
        "rms_by_material": {
            material: {
                "radiance": quantity(by_material[i], RADIANCE),
                "temperature": quantity(by_material[count + i], "K"),
            }
            for i, material in enumerate(budget.materials)
        },
    }


def _of_material(weight: Floats | None, dims: int, number: int) -> Floats | None:
    """Weights of a material's errors: by assigned material, or of each view."""
    if weight is None:
        return None
    return weight[number] if dims == 3 else weight[:, number]


def regions(budget: Budget) -> dict[str, Booleans]:
    """Views by the surroundings of their faces, and by the observer's height."""
    circumstances, views = budget.circumstances, budget.views
    day = views.source_elevation > 0
    dark = circumstances.in_shade | ~day if budget.source == "sun" else np.zeros(len(views), bool)
    return {
        "in the open, lit": ~circumstances.walled & ~dark,
        "in the shade by day": circumstances.in_shade & day,
        "in a shadow before": circumstances.shaded & ~circumstances.in_shade,
        "beside a wall": circumstances.walled,
        "source below the horizon": ~day,
        "within 100 m": views.near,
        **{
            f"from the height of {name}": ~views.near & (views.height >= low) & (views.height <= high)
            for name, (low, high) in OBSERVERS_KM.items()
        },
    }


def _region(budget: Budget, rows: Booleans) -> dict[str, Any]:
    """Errors of the pixel on some views."""
    error = budget.errors["pixel"]
    return {
        "views": int(rows.sum()),
        "radiance": {key: quantity(value, RADIANCE) for key, value in reported(error[rows]).items()},
        "temperature": {key: quantity(value, "K") for key, value in reported(kelvin(budget, error)[rows]).items()},
    }


def dominant(budget: Budget) -> str:
    """One sentence on the error of a pixel as a runtime has it, and on the sources of which it is made."""
    unit = "K" if in_kelvin(budget) else RADIANCE

    def rms(name: str) -> float:
        error = budget.errors[name]
        return measures(kelvin(budget, error) if in_kelvin(budget) else error)["rms"]

    sizes = sorted(((rms(name), name) for name in PIXEL_SOURCES if name in budget.errors), reverse=True)
    (largest, name), (second, next_name) = sizes[:2]
    once = (
        f"{rms('all'):.2g} {unit} rms in a runtime that reads the tables once a frame, "
        if "all" in budget.errors
        else ""
    )
    sources = f"{name.replace('_', ' ')} ({largest:.2g}), then {next_name.replace('_', ' ')} ({second:.2g})"
    return (
        f"A pixel errs by {once}{rms('pixel'):.2g} {unit} rms where the tables are read at each pixel;"
        f" the largest source of the latter is {sources}."
    )


def _by_slant(budget: Budget, error: Floats, in_radiance: bool = False) -> list[list[float]]:
    """Rms by field of view and slant; not a number where no view has the slant."""
    slant = np.abs(budget.views.elevation)
    rows = []
    for values in error:
        values = values if in_radiance else kelvin(budget, values)
        inside = [(slant >= low) & ((slant < high) | (high == 90)) for low, high in SLANTS]
        rows.append([measures(values[part])["rms"] if part.any() else float("nan") for part in inside])
    return rows


def _scale(budget: Budget, bits: int) -> dict[str, Any]:
    """Gain, buffer gain and offset of (44) for the radiance of these views, and the error of the pixel values."""
    scale = PixelScale.of(float(budget.radiance.min()), float(budget.radiance.max()), bits)
    error = scale.radiance(scale.pixel(budget.radiance)) - budget.radiance
    as_kelvin, in_radiance = measures(kelvin(budget, error)), measures(error)
    return {
        "bits": bits,
        "G": quantity(scale.gain, RADIANCE),
        "BG": quantity(scale.buffer_gain, "1"),
        "DC": quantity(scale.offset, "1"),
        "step": quantity(scale.step, RADIANCE),
        "rms": quantity(in_radiance["rms"], RADIANCE),
        "maximum": quantity(in_radiance["maximum"], RADIANCE),
        "rms_kelvin": quantity(as_kelvin["rms"], "K"),
        "maximum_kelvin": quantity(as_kelvin["maximum"], "K"),
    }


def by_size(errors: Mapping[str, Any]) -> list[str]:
    """Names of the errors of a budget: sums of several first, then each source by its rms, falling.

    In kelvin; where no radiance has an equivalent temperature, in radiance.
    """

    def rms(name: str) -> float:
        values = [errors[name][kind]["rms"]["value"] for kind in ("temperature", "radiance")]
        return float(next(value for value in values if value is not None))

    return sorted(errors, key=lambda name: (name not in WHOLE, -rms(name)))


def describe_all(budgets: Sequence[Budget], notes: Sequence[str], *, job: str, seed: int) -> dict[str, Any]:
    """The report as plain values."""
    return {
        "job": job,
        "seed": seed,
        "method": METHOD,
        "headline": headline(budgets),
        "budgets": [describe(budget) for budget in budgets],
        "notes": list(notes),
    }


METHOD = (
    "Random views of every material: a quarter of them within 100 m, three in eight from drones (0.02 to 0.5 km above"
    " the surface), aircraft (1 to 12 km) and satellites (from 200 km), as far as the tables reach, even in solid"
    " angle; the others from any altitude of the tables, ranges even in their logarithm. The Sun at all hours, the"
    " Moon above the horizon, half of the lit surfaces near its mirror image. Of the faces 40 % are in a shadow, 20"
    " % have left one, 30 % are beside a wall. Truth: equations (5), (18), (26), (33) over all spectral points, the"
    " light of sky, ground and wall over each face's own hemisphere, temperatures from each face's own heat balance"
    " under its shadows and beside its walls, with ground before it that has its shade. Rows that are no source of the"
    " pixel's state what is omitted: the aureole behind buildings, ground in the band's light, one lobe, depth buffer"
    " and edges within a pixel. Each source is the change of radiance that it makes alone."
)
