"""Ground around the surfaces of states that name none: the job's most common level material."""

from __future__ import annotations

from skyshine.mat.job.model import Job
from skyshine.materials.library import MaterialLibrary
from skyshine.materials.records import Material
from skyshine.tmm.database.usage import library_usage

# m, roughness length of plants some 0.7 m high (0.13 of their height, Brutsaert 1982): higher ones are no ground
# to look at, but are placed on it.
_ROUGHEST_GROUND = 0.09


def lies_level(material: Material) -> bool:
    """Whether a material is ground: endless to the wind, and no shrub, crop or tree."""
    surface = material.surface
    return surface.exposure == "field" and surface.roughness_length <= _ROUGHEST_GROUND


def with_default_ground(job: Job, library: MaterialLibrary) -> Job:
    """The job with a ground for each state that names none.

    It is the level material with the largest share of the finished textures, without any the first of `materials`.
    Images that are still to be classified, and `materials: all`, say nothing; nor is ground needed where all faces are
    level, or the table has no level faces.

    Raises
    ------
    InputError
        A finished texture is damaged.
    """
    limits, slopes = job.query_limits, job.surface_grid.slope_deg
    lowest = max(slopes[0], limits.slope_deg[0] if limits and limits.slope_deg else 0.0)
    unnamed = [state.ground_material is None for state in job.states]
    if not any(unnamed) or lowest > 0 or slopes[-1] == 0:
        return job
    listed = job.materials if isinstance(job.materials, list) else []
    by_share = library_usage(job.finished_textures) if job.finished_textures else {}
    needed = library.names if limits is None or limits.materials is None else limits.materials
    level = [n for n in [*by_share, *listed] if n in library and n in needed and lies_level(library[n])]
    if not level:
        return job
    origin = "largest share of the finished textures" if level[0] in by_share else "first of materials that lies level"
    states = [
        state.with_ground(level[0], origin) if needs else state
        for state, needs in zip(job.states, unnamed, strict=True)
    ]
    return job.model_copy(update={"states": states})
