"""What a job changes in the surfaces of the library, in words for those who check it."""

from __future__ import annotations

from collections.abc import Sequence

from skyshine.mat.job.by_material import value_for
from skyshine.mat.job.model import Job
from skyshine.mat.job.moisture import water_fraction
from skyshine.mat.job.own_materials import job_materials
from skyshine.mat.scene.material_summary import material_summary
from skyshine.mat.scene.moisture import job_library
from skyshine.mat.surface.canopy import gap_towards
from skyshine.mat.surface.soil_moisture import dry_layer
from skyshine.materials.records import Material, OpenStand


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
