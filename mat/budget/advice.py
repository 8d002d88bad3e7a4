"""What keys of a job would take away from the error of its pixels, measured on the views of the error budget."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skyshine.mat.budget.budget import Budget
from skyshine.mat.budget.sizes import RADIANCE, in_kelvin, kelvin, measures, reported
from skyshine.schemas.arrays import Floats
from skyshine.schemas.quantity import quantity

# Sources of error of a pixel by the key that makes them smaller; without one they belong to the method.
KEYS: dict[str, tuple[str, ...]] = {
    "atmosphere_grid: {tolerance: ...}": (
        "emitted_transmittance",
        "reflected_wavelengths",
        "beta_star_table",
        "path_radiance_table",
        "near_range",
        "ambient_table",
        "direct_table",
    ),
    "surface_grid: {tolerance: ...}": ("temperature_table",),
    "accuracy: {spectral_tolerance: ...}": ("compiled_band",),
    "accuracy: {solver_steps: ...}": ("solver_steps",),
    "accuracy: {tilted_faces_k: ...}": ("tilted_sky",),
}
NO_KEY = "no key: linear responses to shadows and walls, tables of the band"
OF_THE_METHOD = ("shade", "surroundings", "normalisation", "reflectance")


@dataclass(frozen=True)
class Gain:
    """What one key could take away at most.

    Attributes
    ----------
    key : str
        Key of the job.
    sources : tuple of str
        Sources of error that the key reduces.
    before, after : float
        Rms error of the pixel, and of the pixel without these sources: K, or W m^-2 sr^-1 below 2.5 um.
    """

    key: str
    sources: tuple[str, ...]
    before: float
    after: float

    @property
    def share(self) -> float:
        """Part of the pixel's error that would go; below 0 where the sources cancel others."""
        return 1.0 - self.after / self.before if self.before > 0 else 0.0


def gains(budget: Budget) -> list[Gain]:
    """Keys by what they could take away, the most first.

    The error that the sources of a key make alone, view by view, is taken from the error of the pixel. That is exact
    where errors add up, and the most that the key can give: a smaller tolerance leaves some of it.
    """
    pixel = budget.errors["pixel"]
    candidates = []
    for key, names in (*KEYS.items(), (NO_KEY, OF_THE_METHOD)):
        present = tuple(name for name in names if name in budget.errors)
        if present:
            remainder = pixel - sum(_counted(budget, name) for name in present)
            candidates.append(Gain(key, present, _rms(budget, pixel), _rms(budget, remainder)))
    return sorted(candidates, key=lambda gain: gain.after)


def _counted(budget: Budget, name: str) -> Floats:
    """Errors of a source on the views that it counts for, 0 on the others."""
    rows = budget.counted.get(name)
    error = budget.errors[name]
    return error if rows is None else np.where(rows[:, np.newaxis], error, 0.0)


def _rms(budget: Budget, error: Floats) -> float:
    return measures(kelvin(budget, error) if in_kelvin(budget) else error)["rms"]


def described(budget: Budget) -> list[dict[str, object]]:
    """The gains as plain values, in the shape of every command's JSON."""
    unit = "K" if in_kelvin(budget) else RADIANCE
    return [
        {
            "key": gain.key,
            "sources": list(gain.sources),
            "pixel": quantity(gain.before, unit),
            "without": quantity(gain.after, unit),
        }
        for gain in gains(budget)
    ]


def headline(budgets: Sequence[Budget]) -> str:
    """One sentence on the set of tables whose pixels err most, and on what would help.

    Tables in kelvin count before those whose radiance has no equivalent temperature.
    """
    if not budgets:
        return "Nothing was measured."
    largest = max(budgets, key=lambda budget: (in_kelvin(budget), _rms(budget, budget.errors[_total(budget)])))
    total = _total(largest)
    error = largest.errors[total]
    size = reported(kelvin(largest, error) if in_kelvin(largest) else error)
    unit = "K" if in_kelvin(largest) else "W m⁻² sr⁻¹"
    location = f"state {largest.state}, {largest.response.lower:.3g}-{largest.response.upper:.3g} µm, {largest.source}"
    if len(budgets) > 1:
        location += ", the worst of the sets of tables"
    text = f"The error of a pixel is {size['rms']:.2g} {unit} rms"
    if np.isfinite(size["p99"]):
        text += f" and within {size['p99']:.2g} {unit} in 99 % of the pixels"
    pixel = _rms(largest, largest.errors["pixel"])
    if total == "all":
        text += f", as a runtime has it that reads the tables once a frame, and {pixel:.2g} {unit} rms where it reads"
        text += f" them at each pixel ({location})"
    else:
        text += f" ({location})"
    best = gains(largest)[0]
    if best.share < 0.05:
        return f"{text}; no single key takes more than {max(best.share, 0):.0%} of that away."
    if best.key == NO_KEY:
        return f"{text}; most of that comes from {' and '.join(best.sources)}, which no key makes smaller."
    return f"{text}; {best.key} could take that to {best.after:.2g} {unit} rms at best."


def _total(budget: Budget) -> str:
    """Name of the row that has most of a runtime's sources of error."""
    return "all" if "all" in budget.errors else "pixel"
