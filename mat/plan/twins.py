"""Materials whose heat balance is that of another one: solved once, copied."""

from __future__ import annotations

from collections.abc import Hashable

from skyshine.mat.job.load import LoadedJob
from skyshine.mat.plan.left_out import LeftOut
from skyshine.mat.scene.moisture import job_library
from skyshine.mat.scene.surface import given_temperatures, surface_materials
from skyshine.mat.scene.weather import wetting_of


def twins_left_out(loaded: LoadedJob, materials: tuple[str, ...]) -> list[LeftOut]:
    """Materials whose heat balance is that of another, by name the first of each."""
    job = loaded.trimmed
    library = job_library(job)
    given = {name for state in job.states for name in given_temperatures(job, state)}
    solved = [library[name] for name in materials if name not in given]
    wettings = {wetting_of(state.weather) for state in job.states}
    by_weather = [surface_materials(solved, job.operated, wetting) for wetting in wettings]
    representatives: dict[tuple[Hashable, ...], str] = {}
    twins = {}
    for column in zip(*by_weather, strict=True):
        physics, name = tuple(material.physics for material in column), column[0].name
        if representatives.setdefault(physics, name) != name:
            twins[name] = representatives[physics]
    return [
        LeftOut(
            f"the heat balance of {name}",
            f"it is that of {representative}: solved once and copied",
            "none",
            "nothing to restore: the table contains it",
        )
        for name, representative in twins.items()
    ]
