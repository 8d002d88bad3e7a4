"""Settings of a job's accuracy: one number for the pixel, shared out over the keys of the job."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

from skyshine.mat.job.accuracy import by_number

KELVINS = (5.0, 3.0, 2.0, 1.0, 0.5, 0.3)  # K, tolerances of the pixel
BUILT_KELVIN = 1.0  # K, of these built always, with the finest
AS_WRITTEN = "as written"
GRIDS = ("atmosphere_grid", "surface_grid")
CHANGED = ("accuracy", *GRIDS)  # keys of the job that a setting may replace
# Kept from the job where a setting replaces the others: they are no steps of accuracy.
_KEPT = ("negligible_k", "seed")


@dataclass(frozen=True)
class Setting:
    """One way to build a job.

    Attributes
    ----------
    kelvin : float or None
        Asked of the pixel; None for the job as written.
    content : dict
        Keys of the job.
    """

    name: str
    kelvin: float | None
    content: dict[str, Any]


def settings_of(content: Mapping[str, Any], kelvins: Sequence[float]) -> list[Setting]:
    """The job as written, and at tolerances for the pixel.

    Parameters
    ----------
    content : mapping
        Keys of the job.
    kelvins : sequence of float
        Tolerances of the 99th percentile of the pixels.

    Returns
    -------
    list of Setting
        The job as written first.
    """
    as_written = Setting(AS_WRITTEN, None, deepcopy(dict(content)))
    return [as_written] + [Setting(f"{kelvin:g} K", kelvin, at_kelvin(content, kelvin)) for kelvin in kelvins]


def at_kelvin(content: Mapping[str, Any], kelvin: float) -> dict[str, Any]:
    """Keys of a job whose pixel is to be within so many kelvin.

    Nodes go where tolerances place them, between the ends of the job's axes.
    """
    changed = deepcopy(dict(content))
    accuracy = {key: value for key, value in (by_number(changed.get("accuracy")) or {}).items() if key in _KEPT}
    changed["accuracy"] = accuracy | {"pixel": f"{kelvin:g} K"}
    for grid in GRIDS:
        if grid in changed:
            changed[grid] = {key: value for key, value in (changed[grid] or {}).items() if key != "tolerance"}
    return changed
