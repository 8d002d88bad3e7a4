"""How closely the tables of a job are computed: one number for the pixel, or each part by itself.

The error of a pixel is shared out by judgement: nodes of the tables, which cost most, may take all of it, for their
errors seldom add up, and it is their worst reads that ask for most nodes; spectral points, steps of the heat balance
and harmonics are cheap and take a third at most. `mat report` measures the sum.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
import pydantic
from pydantic import Field

from skyshine.mat.job.fields import Tolerance, tolerance, tolerance_parts
from skyshine.schemas.documents import StrictModel

# Shares of the pixel's kelvin: relative error of a compiled band (in 3-5 um 3e-3 leave 0.016 K and 1e-2 0.1 K of 99 %
# of pixels), ambient light on tilted faces, and what is omitted.
_SPECTRAL, _FACES, _NEGLIGIBLE = 6e-3, 0.5, 1 / 15
_PATHS, _TEMPERATURES = 1.0, 1.0  # shares of the pixel's kelvin for the nodes of atmospheric tables and of T
# Steps of the heat balance a day, from the pixel's kelvin on: 99 % of the temperatures are within 0.04 K with 96,
# 0.015 K with 144, 0.006 K with 192 (`surface.solver`).
_STEPS = ((0.3, 96), (0.1, 144), (0.0, 192))
SMALLEST_PIXEL_K, LARGEST_PIXEL_K = 0.05, 5.0
DEFAULT_PIXEL = "0.5 K"
_SURFACE_NODES = {"azimuth_deg", "slope_deg", "time"}  # axes of temperatures that a job without an accuracy keeps


def pixel_kelvin(value: str) -> str:
    """An error of a pixel in kelvin, as it is written.

    Raises
    ------
    ValueError
        It is none.
    """
    kelvin, unit = tolerance_parts(tolerance(value))
    if unit != "K" or not SMALLEST_PIXEL_K <= kelvin <= LARGEST_PIXEL_K:
        raise ValueError(
            f"found '{value}'; allowed: {SMALLEST_PIXEL_K:g} K to {LARGEST_PIXEL_K:g} K of a pixel; write 0.3 K, say"
        )
    return value


class Accuracy(StrictModel):
    """How closely the tables are to be computed and measured."""

    pixel: Annotated[Tolerance, pydantic.AfterValidator(pixel_kelvin)] = Field(
        DEFAULT_PIXEL,
        description=(
            "Error of 99 % of the pixels, such as 0.3 K, the worst within three times; in bands that end before 2.5 um"
            " 3 % of the light of a sunlit surface that reflects 0.3 counts as 1 K. It gives the other keys, and the"
            " tolerances of both grids, their values; those that are written keep theirs. A surface_grid with axes of"
            " its own keeps these unless the job writes an accuracy. Written alone, it may replace all"
            " keys: accuracy: 0.3 K. mat report measures the sum."
        ),
    )
    spectral_tolerance: float = Field(1e-3, ge=1e-4, le=0.05, description="Relative, of a compiled band.")
    negligible_k: float = Field(
        0.02,
        ge=0,
        le=1,
        description=(
            "Scattered light of a source is omitted from the atmospheric tables of a band where that provably changes"
            " no radiance seen by more, in kelvin at the temperature of the ground (300 K at most); 0 leaves none out."
        ),
    )
    solver_steps: Literal[48, 96, 144, 192, 288] = Field(
        96,
        description="Steps of the heat balance per day; columns whose temperature would ring are solved in "
        "192 or more.",
    )
    tilted_faces_k: float = Field(
        0.15,
        ge=0.05,
        le=1,
        description=(
            "Harmonics of ambient light on tilted faces: with a reflectance of 0.3 at 300 K, 6 harmonics are "
            "accurate to 0.15 K and 11 to 0.05 K."
        ),
    )
    seed: int = Field(
        1, ge=0, le=2**31 - 1, description="Seed of the random points at which table errors are measured."
    )


def by_number(accuracy: Any) -> Any:
    """The keys of accuracy that a single number sets.

    Raises
    ------
    ValueError
        It is a number without its unit.
    """
    if isinstance(accuracy, int | float):
        raise ValueError(f"found {accuracy}; allowed: a number and its unit, or keys; write accuracy: 0.3 K, say")
    return {"pixel": accuracy} if isinstance(accuracy, str) else accuracy


def names_a_pixel(job: Any) -> bool:
    """Whether the mapping of a job names the error of its pixel, and does not take the default."""
    accuracy = job.get("accuracy") if isinstance(job, dict) else None
    return isinstance(accuracy, str) or (isinstance(accuracy, dict) and "pixel" in accuracy)


def with_shares(job: Any) -> Any:
    """The mapping of a job with the shares of its pixel's error in the places that are not written.

    Whatever is no mapping, or names no pixel in the right form, is given back as it is, for the models to refuse.
    """
    if not isinstance(job, dict):
        return job
    try:
        stated = {"pixel": DEFAULT_PIXEL} | by_number(job.get("accuracy", {}))
        kelvin = tolerance_parts(pixel_kelvin(stated["pixel"]))[0]
    except (ValueError, TypeError):
        return job
    shares: dict[str, Any] = {
        "spectral_tolerance": float(np.clip(_SPECTRAL * kelvin, 1e-4, 0.05)),
        "negligible_k": _NEGLIGIBLE * kelvin,
        "solver_steps": next(steps for limit, steps in _STEPS if kelvin >= limit),
        "tilted_faces_k": float(np.clip(_FACES * kelvin, 0.05, 1.0)),
    }
    tolerances = {"atmosphere_grid": _PATHS * kelvin}
    surface = job.get("surface_grid", {})
    if names_a_pixel(job) or not (isinstance(surface, dict) and _SURFACE_NODES & surface.keys()):
        tolerances["surface_grid"] = _TEMPERATURES * kelvin
    completed = job | {"accuracy": shares | stated}
    for name, share in tolerances.items():
        grid = job.get(name, {})
        if isinstance(grid, dict):
            completed[name] = {"tolerance": f"{share:g} K"} | grid
    return completed
