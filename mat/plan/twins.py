"""Materials whose heat balance is that of another one: solved once, copied."""

from __future__ import annotations

from typing import Any

from skyshine.mat.job.load import LoadedJob
from skyshine.mat.plan.left_out import LeftOut
from skyshine.mat.scene.moisture import job_library
from skyshine.mat.scene.surface import surface_materials


def twins_left_out(loaded: LoadedJob, materials: tuple[str, ...]) -> list[LeftOut]:
    """Materials whose heat balance is that of another, by name the first of each."""
    job = loaded.trimmed
    library = job_library(job)
    every = surface_materials([library[name] for name in materials], job.operated)
    solved = [material for material in every if material.name not in job.temperatures_c]
    first: dict[tuple[Any, ...], str] = {}
    twins = {
        each.name: first[each.physics] for each in solved if first.setdefault(each.physics, each.name) != each.name
    }
    return [
        LeftOut(
            f"the heat balance of {name}",
            f"it is that of {other}: solved once and copied",
            "none",
            "nothing to restore: the table holds it",
        )
        for name, other in twins.items()
    ]
