"""Snow that lies on things in all states of a job."""

from __future__ import annotations

from collections.abc import Iterable

from pydantic import Field

from skyshine.materials.library import MaterialLibrary
from skyshine.materials.records import Material
from skyshine.schemas.documents import StrictModel
from skyshine.schemas.errors import nearest
from skyshine.tmm.job.materials import MaterialName


class SnowCover(StrictModel):
    """Snow on a material."""

    depth_m: float = Field(ge=0.005, le=10, description="Depth of the snow.")
    snow: MaterialName = Field("snow_fine", description="Material of the snow: its spectrum, density and conductivity.")


def carries_snow(material: Material) -> bool:
    """Whether snow lies on a material as a layer: on no leaves, snow, ice or open water."""
    surface = material.surface
    return not (surface.canopy or surface.snow or (surface.wetness == 1 and surface.surface_resistance == 0))


def check_snow(covers: dict[str, SnowCover], of_job: Iterable[str], library: MaterialLibrary) -> None:
    """Refuse snow on what a job does not have or what carries none, and snow that is none.

    Raises
    ------
    ValueError
    """
    if not covers:
        return
    names = [name for name in of_job if carries_snow(library[name])]
    for name, cover in covers.items():
        if name not in names:
            raise ValueError(
                f"found '{name}', which is no material of the job on which snow lies as a layer (leaves, snow and open"
                f" water are none); {nearest(name, names)}"
            )
        if library[cover.snow].group != "snow":
            kinds = [candidate for candidate in library.names if library[candidate].group == "snow"]
            raise ValueError(f"found {name} under '{cover.snow}', which is no snow; {nearest(cover.snow, kinds)}")
