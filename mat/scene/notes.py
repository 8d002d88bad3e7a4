"""What `mat check` says of surfaces: what a job changes in those of the library, and what tilted faces lose where it
names no ground around them, in kelvin.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from skyshine.mat.job.by_material import value_for
from skyshine.mat.job.default_ground import lies_level
from skyshine.mat.job.model import Job
from skyshine.mat.job.moisture import water_fraction
from skyshine.mat.job.own_materials import job_materials
from skyshine.mat.job.warnings import merged
from skyshine.mat.scene.material_summary import material_summary
from skyshine.mat.scene.moisture import job_library
from skyshine.mat.surface.canopy import gap_towards
from skyshine.mat.surface.soil_moisture import dry_layer
from skyshine.materials.library import MaterialLibrary
from skyshine.materials.records import Material, OpenStand
from skyshine.schemas.arrays import Floats

_AZIMUTHS = np.array([0.0, 90.0, 180.0, 270.0])  # [degree] of slopes that are compared
_SOIL = "soil_loam_brown"
_STEPS = 48  # half hours: enough to know a difference to a tenth
# Materials of a kind that are solved; chosen. Glass and snow, which ground warms less, are among the bright ones.
_BRIGHT, _DARK, _LIGHT = 20, 4, 20


def surface_notes(job: Job, materials: Sequence[str]) -> list[str]:
    """A line for each material that the job's soil moisture changes, on which snow lies, or whose leaves have gaps."""
    dry, moist = job_materials(job.own_materials), job_library(job)
    names = [name for name in materials if moist[name].soil is not None and moist[name].surface != dry[name].surface]
    stands = [stand for name in materials if (stand := moist[name].opened) is not None]
    closed = [name for name in materials if dry[name].stand is not None and moist[name].opened is None]
    return [
        *(_moistened(dry[name], moist[name], value_for(job.soil_moisture, name)) for name in names),
        *(
            f"snow_on: {name} under {job.snow_on[name].depth_m:g} m of {job.snow_on[name].snow}"
            for name in materials
            if name in job.snow_on
        ),
        *map(_opened, stands),
        *(f"leaf_area_index: {name} without gaps between its leaves" for name in closed),
    ]


def _opened(stand: OpenStand) -> str:
    gap = float(gap_towards(stand.leaf_area, 1.0))
    clumped = "" if stand.leaves.stand is None or stand.leaves.stand.clumping == 1 else ", clumping counted"
    return (
        f"leaf_area_index: {stand.leaves.name} with {stand.leaf_area:.3g} m2/m2 of leaves{clumped}: {gap:.1%} of the"
        f" ground seen from above is {stand.soil.name}"
    )


def _moistened(dry: Material, moist: Material, value: float | str | None) -> str:
    def layer(material: Material) -> tuple[float, float]:
        top = material.thermal.layers[0]
        return top.conductivity, 1e-6 * top.density * top.heat_capacity

    before, after = material_summary(dry), material_summary(moist)
    assert dry.soil is not None and value is not None
    water = water_fraction(value, dry.name, dry.soil)
    above = 0.0 if dry.soil.layers == 1 else dry_layer(dry.soil.texture, water)
    (conducts, moist_heat), (conducted, dry_heat) = layer(moist), layer(dry)
    optical = ", ".join(
        f"{name.replace('_', ' ')} {before[name]:.3f} -> {after[name]:.3f}"
        for name in ("solar_absorptance", "thermal_emissivity")
    )
    resistance = moist.surface.surface_resistance
    fell_dry = f"its upper {1e3 * above:.0f} mm are dry, " if above else ""
    return (
        f"soil_moisture: {dry.name} with {water:.3g} m3/m3 of water: {fell_dry}conductivity {conducted:.3g} ->"
        f" {conducts:.3g} W/m/K, heat capacity {dry_heat:.3g} -> {moist_heat:.3g} MJ/m3/K, {optical}, "
        f"evaporates through {resistance:.3g} s/m"
    )


def ground_notes(job: Job, materials: Sequence[str]) -> list[str]:
    """A line for a ground that the job does not name, and one where tilted faces see ground as warm as the air, with
    what a ground changes.

    Faces as steep as the job has them, to four aspects, under the first state without a ground, are solved with and
    without it: the ground is the first of the job's level materials, or soil. A job that says which of them is the most
    common has it as ground (`default_ground`). Of many materials the brightest warm bodies, the darkest cold ones and
    those that keep the least heat are solved: of all 183 of the library on a summer day these have both ends of the
    change, -1.4 and +6.5 K.
    """
    assumptions = merged(
        (number, f"{state.ground_material} is taken as ground, {state.ground_origin}; name what lies there")
        for number, state in enumerate(job.states, 1)
        if state.ground_origin is not None
    )
    return [f"ground: {line}" for line in assumptions] + _without_ground(job, materials)


def _without_ground(job: Job, materials: Sequence[str]) -> list[str]:
    steepest = max(job.surface_grid.slope_deg)
    numbers = [number for number, state in enumerate(job.states, 1) if state.ground_material is None]
    library = job_library(job)
    grounds = [name for name in [*materials, _SOIL] if lies_level(library[name])]
    solved = _extremes(library, [name for name in materials if name not in job.temperatures_c])
    if not numbers or not solved or steepest == 0:
        return []
    number, ground = numbers[0], grounds[0]
    states = list(job.states)
    states[number - 1] = states[number - 1].model_copy(update={"ground_material": ground})
    named = job.model_copy(update={"states": states})
    before, after = (_faces(variant, number, solved, steepest) for variant in (job, named))
    change = after - before
    colder, warmer = float(change.min()), float(change.max())
    return [
        f"ground: state {number} names no ground_material, so tilted faces see ground as warm as the air: with"
        f" {ground} those of {steepest:g} degrees change by {colder:+.1f} to {warmer:+.1f} K; name what lies there"
    ]


def _extremes(library: MaterialLibrary, names: list[str]) -> list[str]:
    """Names of materials between which the changes of all lie; all names where they are few."""
    if len(names) <= _BRIGHT + _DARK + _LIGHT:
        return names
    from skyshine.mat.scene.surface import surface_materials  # slow to import

    surfaces = {surface.name: surface for surface in surface_materials([library[name] for name in names])}

    def warms(name: str) -> float:
        return surfaces[name].solar_absorptance - surfaces[name].thermal_emissivity

    def inertia(name: str) -> float:
        layer = surfaces[name].thermal.layers[0]
        return layer.conductivity * layer.density * layer.heat_capacity

    by_light = sorted(names, key=warms)
    chosen = {*by_light[:_BRIGHT], *by_light[-_DARK:], *sorted(names, key=inertia)[:_LIGHT]}
    return [name for name in names if name in chosen]


def _faces(job: Job, number: int, materials: Sequence[str], slope: float) -> Floats:
    """Temperatures (materials x faces, times) [K] of a state, counted from 1."""
    from skyshine.mat.scene.surface import scene_inputs, surface_materials  # slow to import
    from skyshine.mat.surface.days import solve_days
    from skyshine.mat.surface.forcing import Scene

    sun, weather, sky = scene_inputs(job, number)
    altitude = np.array([1e3 * job.surface_altitudes_km[0]])
    scene = Scene(sun, weather, sky, altitude, np.full(_AZIMUTHS.shape, slope), _AZIMUTHS)
    library = job_library(job)
    rows = []
    for material in surface_materials([library[name] for name in materials], job.operated, weather.wetting):
        temperatures = np.empty((_AZIMUTHS.size, _STEPS))
        for columns, solution in solve_days(material, scene.days[-1:], steps=_STEPS, fine_steps=None):
            temperatures[columns] = solution.temperature
        rows.append(temperatures)
    return np.concatenate(rows)
