"""Settings of a job's accuracy: one number for the pixel, shared out over the keys of the job."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, fields
from typing import Any

from skyshine.mat.job.accuracy import LARGEST_PIXEL_K, Accuracy, by_number, with_shares
from skyshine.mat.job.atmosphere import AtmosphereGrid
from skyshine.mat.job.default_nodes import OBSERVER_HEIGHTS_KM
from skyshine.mat.job.fields import clock_text
from skyshine.mat.job.model import Job
from skyshine.mat.job.surface import SURFACE_HEIGHTS_KM, SurfaceGrid
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.scene.grids import path_grid

KELVINS = (5.0, 3.0, 2.0, 1.0, 0.5, 0.3, 0.2, 0.1)
QUICK_KELVINS = (5.0, 1.0)
AS_WRITTEN, DRAFT, DEFAULT_AXES = "as written", "draft", "default axes"
GRIDS = ("atmosphere_grid", "surface_grid")
CHANGED = ("accuracy", *GRIDS)  # keys of the job that a setting may replace
DRAFT_KELVIN = LARGEST_PIXEL_K  # as roughly as a job may ask
# Kept from the job where a setting replaces the others: they are no steps of accuracy.
_KEPT = ("negligible_k", "seed")
GRID_AXES = tuple(field.name for field in fields(PathGrid))


@dataclass(frozen=True)
class Setting:
    """One way to build a job.

    Attributes
    ----------
    name : str
    kelvin : float or None
        Asked of the pixel; None for the job as written, as a draft and on the default axes.
    content : dict
        Keys of the job.
    """

    name: str
    kelvin: float | None
    content: dict[str, Any]


def settings_of(content: Mapping[str, Any], job: Job, kelvins: Sequence[float]) -> list[Setting]:
    """The job as written, as a draft, on the default axes, and at tolerances for the pixel.

    Parameters
    ----------
    content : mapping
        Keys of the job.
    job : Job
        The same, with the nodes that its query limits read: the ends of its axes.
    kelvins : sequence of float
        99 % of pixels are asked to be within each.

    Returns
    -------
    list of Setting
        The job as written first. The default axes are left out where the job is written with them.
    """
    settings = [Setting(AS_WRITTEN, None, deepcopy(dict(content))), Setting(DRAFT, None, as_draft(content, job))]
    if not _on_default_axes(job):
        settings.append(Setting(DEFAULT_AXES, None, on_default_axes(content, job)))
    return settings + [Setting(f"{kelvin:g} K", kelvin, at_kelvin(content, kelvin)) for kelvin in kelvins]


def at_kelvin(content: Mapping[str, Any], kelvin: float) -> dict[str, Any]:
    """Keys of a job whose pixel is to be within so many kelvin.

    Nodes go where tolerances place them, between the ends of the job's axes and in the layout that it names.
    """
    changed = deepcopy(dict(content))
    changed["accuracy"] = _kept(changed) | {"pixel": f"{kelvin:g} K"}
    for grid in GRIDS:
        if grid in changed:
            changed[grid] = {key: value for key, value in (changed[grid] or {}).items() if key != "tolerance"}
    return changed


def as_draft(content: Mapping[str, Any], job: Job) -> dict[str, Any]:
    """Keys of a job on every other node of its axes, or of the default ones where it names a tolerance, as roughly
    computed as a job may ask.

    Parameters
    ----------
    job : Job
        Whose axes' nodes are taken.
    """
    changed, air, surface = deepcopy(dict(content)), job.atmosphere_grid, job.surface_grid
    written = {name: getattr(path_grid(job), name).tolist() for name in GRID_AXES}
    level = {"altitude_km": job.surface_altitudes_km, "slope_deg": surface.slope_deg}
    pixel = with_shares({"accuracy": {"pixel": f"{DRAFT_KELVIN:g} K"}})["accuracy"]
    changed["accuracy"] = _kept(changed) | {key: pixel[key] for key in pixel if key not in ("pixel", *_KEPT)}
    for key, nodes in (
        ("atmosphere_grid", _default_air(job) if air.tolerances else written),
        ("surface_grid", _default_surface(job) if surface.tolerance else level),
    ):
        changed[key] = {name: _every_other(values) for name, values in nodes.items()}
    changed["surface_grid"]["azimuth_deg"] = surface.azimuth_deg[::2]
    changed["surface_grid"]["time"] = [clock_text(time) for time in surface.times[::2]]
    return changed


def on_default_axes(content: Mapping[str, Any], job: Job) -> dict[str, Any]:
    """Keys of a job that names neither accuracy nor nodes, on axes with the same ends.

    Parameters
    ----------
    job : Job
        Whose axes' ends are taken.
    """
    changed = deepcopy(dict(content))
    accuracy = _kept(changed)
    changed.pop("accuracy", None)
    if accuracy:
        changed["accuracy"] = accuracy
    surface = job.surface_grid
    # Where a job writes an axis, no quantity has nodes of its own on it.
    plain = _whole_default_air(job)
    changed["atmosphere_grid"] = {name: nodes for name, nodes in _default_air(job).items() if nodes != plain[name]}
    changed["surface_grid"] = _default_surface(job)
    if len(surface.azimuth_deg) == 1:
        changed["surface_grid"]["azimuth_deg"] = surface.azimuth_deg
    if len(surface.times) == 1:
        changed["surface_grid"]["time"] = [clock_text(surface.times[0])]
    return changed


def _on_default_axes(job: Job) -> bool:
    """Whether a job names neither accuracy nor other nodes than those between the ends of its axes."""
    kept = {key: getattr(job.accuracy, key) for key in _KEPT}
    air, surface, plain = job.atmosphere_grid, job.surface_grid, SurfaceGrid()
    return (
        job.accuracy == Accuracy(**kept)
        and not air.tolerances
        and surface.tolerance is None
        and _default_air(job) == {name: getattr(path_grid(job), name).tolist() for name in GRID_AXES}
        and _default_surface(job) == {"altitude_km": job.surface_altitudes_km, "slope_deg": surface.slope_deg}
        and (len(surface.azimuth_deg) == 1 or surface.azimuth_deg == plain.azimuth_deg)
        and (len(surface.times) == 1 or surface.time is None)
    )


def _default_air(job: Job) -> dict[str, list[float]]:
    """Default nodes of the atmospheric tables between the ends of a job's axes."""
    plain, grid = _whole_default_air(job), path_grid(job)
    return {name: _between(plain[name], getattr(grid, name).tolist()) for name in GRID_AXES}


def _whole_default_air(job: Job) -> dict[str, list[float]]:
    heights = [round(job.site.altitude_km + height, 9) for height in OBSERVER_HEIGHTS_KM]
    return AtmosphereGrid().model_dump() | {"altitude_km": heights}


def _default_surface(job: Job) -> dict[str, list[float]]:
    """The same of the temperature table's altitudes and slopes."""
    heights = [job.site.altitude_km + height for height in SURFACE_HEIGHTS_KM]
    return {
        "altitude_km": _between(heights, job.surface_altitudes_km),
        "slope_deg": _between(SurfaceGrid().slope_deg, job.surface_grid.slope_deg),
    }


def _kept(content: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in (by_number(content.get("accuracy")) or {}).items() if key in _KEPT}


def _every_other(nodes: Sequence[float]) -> list[float]:
    """Every other node, with both ends and 0: the horizon."""
    return sorted({*nodes[::2], nodes[-1], *(node for node in nodes if node == 0)})


def _between(nodes: Sequence[float], ends: Sequence[float]) -> list[float]:
    """Nodes between the first and the last of others, with these two."""
    low, high = ends[0], ends[-1]
    return sorted({low, high, *(round(node, 9) for node in nodes if low < node < high)})
