"""The YAML job: what a scene needs, as typed models with defaults, limits and units.

Units are in the key names here, at the edge; everything behind this module is in SI.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self, cast

import pydantic
import yaml
from pydantic import Field

from skyshine.mat.atmosphere.gases.absorption import (
    check_water_continuum,
    default_water_continuum,
    packaged_water_continuum,
)
from skyshine.mat.job.accuracy import Accuracy, by_number, with_shares
from skyshine.mat.job.atmosphere import AXES, AtmosphereGrid, Band, State
from skyshine.mat.job.default_nodes import OBSERVER_HEIGHTS_KM
from skyshine.mat.job.fields import Tolerance, by_hour
from skyshine.mat.job.leaf_area import LeafAreaIndex
from skyshine.mat.job.moisture import SoilMoisture
from skyshine.mat.job.own_materials import Definitions, OwnMaterials
from skyshine.mat.job.query_limits import QueryLimits
from skyshine.mat.job.series import MEMBER_LIMIT
from skyshine.mat.job.site import Site
from skyshine.mat.job.sites import SitesChoice
from skyshine.mat.job.snow import SnowCover
from skyshine.mat.job.surface import (
    SURFACE_HEIGHTS_KM,
    OperatedCelsius,
    Operation,
    SurfaceGrid,
)
from skyshine.mat.job.textures import FinishedTexture, JobTexture
from skyshine.mat.quantities.channels.coordinates import TOP_KM
from skyshine.mat.radiometry.spherical_harmonics import COUNTS
from skyshine.schemas.documents import StrictModel
from skyshine.schemas.errors import InputError
from skyshine.tmm.job.materials import MaterialName
from skyshine.tmm.job.model import TextureJob, check_distinct_names


def _or_its_name(schema: dict[str, Any]) -> None:
    """Allow a name in the place of each value of a mapping, in its JSON Schema."""
    schema["additionalProperties"] = {"anyOf": [schema["additionalProperties"], {"type": "string"}]}


SIX_HOLD_K = 0.15  # tests/validation/test_tilted_faces.py
WaterContinuum = Literal["mt_ckd_4.3_closure", "mt_ckd_4.3", "mt_ckd_2.4", "lowtran7"]


def _kind_of_choice(value: object) -> str:
    return "names" if isinstance(value, list) else "own" if isinstance(value, dict) else "word"


MaterialChoice = Annotated[
    Annotated[Literal["used", "all"], pydantic.Tag("word")]
    | Annotated[list[MaterialName], Field(min_length=1), pydantic.Tag("names")]
    | Annotated[OwnMaterials, pydantic.Tag("own")],
    pydantic.Discriminator(_kind_of_choice),
]


def _packaged_continuum(name: str) -> str:
    try:
        check_water_continuum(name, packaged_water_continuum())
    except InputError as error:
        raise ValueError(error.message) from None
    return name


def _default_continuum() -> WaterContinuum:
    return cast(WaterContinuum, default_water_continuum())


class Output(StrictModel):
    """Where the files go."""

    folder: str = Field("built", min_length=1, description="Relative to the job file.")
    pictures: bool = Field(True, description="Whether a PNG of each database is drawn beside it.")
    max_gigabytes: float = Field(
        100.0,
        gt=0,
        le=1e6,
        description="Largest size of all tables together, before compression; a larger job is refused.",
    )
    max_file_gigabytes: float = Field(
        1.0,
        gt=0,
        le=64,
        description="Largest size of one table, before compression; its computation takes some times as much memory.",
    )


def _one_site_or_several(schema: dict[str, Any]) -> None:
    """Ask for a whole site only where a job has no sites, in its JSON Schema."""
    site = schema["properties"]["site"]
    name = site.pop("$ref")
    site["anyOf"] = [{"$ref": name}, {"type": "object"}]
    schema["required"].remove("site")
    several = {"required": ["sites"]}
    place = {"description": "Place and time.", "$ref": name}
    schema["if"], schema["else"] = several, {"required": ["site"], "properties": {"site": place}}


class Job(StrictModel):
    """A whole job."""

    model_config = pydantic.ConfigDict(json_schema_extra=_one_site_or_several)

    skyshine: Literal[1] = Field(description="Version of the job format.")
    name: str = Field(
        min_length=1,
        max_length=80,
        description="Name of the job, stored in every file; letters, digits, dots, dashes, underscores.",
    )
    site: Site = Field(
        description=(
            "Place and time; they give the positions of Sun and Moon. With sites, what all of them have in common."
        )
    )
    sites: SitesChoice | None = Field(
        None,
        exclude=True,
        description=(
            "Several sites in the place of one: a list, a CSV table with the columns of a site, or a grid of tiles;"
            " each has databases of its own in a folder of its name, all are in one catalogue. {site} in the texts of"
            " states is the name of the site."
        ),
    )
    states: list[State] = Field(
        min_length=1,
        max_length=MEMBER_LIMIT,
        description="States of the atmosphere with its weather; each has databases of its own.",
    )
    bands: list[Band] = Field(
        max_length=99,
        description="Bands of wavelength, even or with a response; each has databases of its own. [] for "
        "temperatures alone.",
    )
    sources: list[Literal["sun", "moon"]] = Field(
        ["sun", "moon"], min_length=1, max_length=2, description="Light sources for which tables are built."
    )
    textures: Annotated[tuple[JobTexture, ...], Field(max_length=10_000)] = Field(
        (), description="Images to classify, or finished .tmm.h5 files."
    )
    materials: MaterialChoice = Field(
        "used",
        description=(
            "Those the textures use, all of the library, or names; or a mapping of names, in which one of the job's own"
            " is defined: mine: {like: concrete, absorptance: 0.8}, and one of the library has no value."
        ),
    )
    operated: dict[MaterialName, Operation] = Field(
        {},
        description=(
            "Back boundaries of materials in operation: engines, heated rooms, cold stores; or the name of one that the"
            " material has: engine_deck: idling."
        ),
        json_schema_extra=_or_its_name,
    )
    temperatures_c: dict[MaterialName, Annotated[float | list[float], by_hour(OperatedCelsius)]] = Field(
        {}, description="Temperatures given by hand in place of the heat balance, one or 24 at the hours 0 to 23."
    )
    # These are excluded from dumps: they change the materials, whose digest is in the identity of every table that
    # reads them.
    soil_moisture: SoilMoisture | None = Field(
        None,
        exclude=True,
        description=(
            "Water in the pores of soil, sand and gravel: dry, moist (the least that keeps the surface moist), wet"
            " (all), or m3/m3; for all such materials, or by material. It moves conductivity, heat capacity,"
            " reflectance at all wavelengths and evaporation together. By default they are as the library has them: dry"
            " above, half full below."
        ),
    )
    leaf_area_index: LeafAreaIndex | None = Field(
        None,
        exclude=True,
        description=(
            "Area of one side of the leaves over that of the ground, m2/m2, by which soil is seen and lit through their"
            " gaps: 0 to 20, or library for the material's own; for all materials with a stand of leaves (grass,"
            " shrub, crops, trees), or by material. By default library; closed, one skin of leaves, where a job"
            " operates the stand."
        ),
    )
    snow_on: dict[MaterialName, SnowCover] = Field(
        {},
        exclude=True,
        description=(
            "Snow that lies on roofs, vehicles, roads or bare ground in all states, by material: car_paint_red:"
            " {depth_m: 0.1}. They look and melt like the snow, over what is below; snow cover of open land is a"
            " material itself."
        ),
    )
    atmosphere_grid: AtmosphereGrid = Field(AtmosphereGrid(), description="Nodes of the atmospheric tables.")
    surface_grid: SurfaceGrid = Field(SurfaceGrid(), description="Nodes of the temperature tables.")
    accuracy: Annotated[Accuracy, pydantic.BeforeValidator(by_number, json_schema_input_type=Tolerance | Accuracy)] = (
        Field(Accuracy(), description="Accuracy of the computation.")
    )
    water_continuum: Annotated[WaterContinuum, pydantic.AfterValidator(_packaged_continuum)] = Field(
        default_factory=_default_continuum,
        description=(
            "Water vapour continuum of the bands and of the light that heats the ground. By default mt_ckd_4.3_closure:"
            " MT_CKD 4.3 with its foreign continuum for closure from 610 to 1380 cm-1, closer to longwave measured on"
            " humid nights; in a package built without MT_CKD lowtran7. mt_ckd_2.4 is for comparison with codes of its"
            " time, lowtran7 is in the public domain."
        ),
    )
    query_limits: QueryLimits | None = Field(
        None,
        alias="needs",
        description="Limits of the reads of scenes; nodes and sources that none of that reads are omitted.",
    )
    output: Output = Field(Output(), description="Folder of the files, pictures, and how large they may be.")

    _own_materials: Definitions = pydantic.PrivateAttr(())

    @property
    def own_materials(self) -> Definitions:
        """Materials that the job defines, by name; a loaded job has the names of all in `materials`."""
        return self._own_materials

    def with_own_materials(self) -> Job:
        """The job with a list in the place of a mapping of materials."""
        if not isinstance(self.materials, dict):
            return self
        job = self.model_copy(update={"materials": list(self.materials)})
        job._own_materials = tuple(
            (name, definition) for name, definition in self.materials.items() if definition is not None
        )
        return job

    @pydantic.model_validator(mode="before")
    @classmethod
    def _shared_out(cls, data: Any) -> Any:
        return with_shares(data)

    @property
    def observer_altitudes_km(self) -> list[float]:
        """Altitudes of the atmospheric tables; by default with the base and the top of every cloud, where the view
        changes.
        """
        if self.atmosphere_grid.altitude_km:
            return self.atmosphere_grid.altitude_km
        layers = [cloud.layer() for state in self.states for cloud in state.clouds]
        edges = {z / 1e3 for layer in layers for z in (layer.base, layer.top)} - {0.0}
        heights = sorted(set(OBSERVER_HEIGHTS_KM) | edges)
        return [round(self.site.altitude_km + height, 9) for height in heights]

    def atmosphere_axes(self) -> dict[str, list[float]]:
        """Nodes of the axes of the atmospheric tables."""
        return {
            name: self.observer_altitudes_km if name == "altitude_km" else getattr(self.atmosphere_grid, name)
            for name in AXES
        }

    def sampled_axes(self) -> dict[str, list[float]]:
        """Axes of the cells in which random lines of sight are drawn: ends of the job's axes, default nodes between.

        So what a file states does not depend on how many nodes a job writes; observers in space are at the top of the
        air.
        """
        defaults = AtmosphereGrid().model_dump()
        defaults["altitude_km"] = [self.site.altitude_km + height for height in OBSERVER_HEIGHTS_KM]
        axes = {}
        for name, nodes in self.atmosphere_axes().items():
            low, high = (min(end, TOP_KM) if name == "altitude_km" else end for end in (nodes[0], nodes[-1]))
            axes[name] = sorted({low, *(node for node in defaults[name] if low < node < high), high})
        return axes

    @property
    def texture_jobs(self) -> tuple[TextureJob, ...]:
        """Textures that the build classifies."""
        return tuple(texture for texture in self.textures if isinstance(texture, TextureJob))

    @property
    def finished_textures(self) -> tuple[Path, ...]:
        """Databases of the other textures."""
        return tuple(texture.database for texture in self.textures if isinstance(texture, FinishedTexture))

    @property
    def ambient_harmonics(self) -> int:
        """Number of harmonics of ambient light in the atmospheric tables; 0 where all faces are level."""
        if self.surface_grid.slope_deg[-1] == 0:
            return 0
        return COUNTS[0] if self.accuracy.tilted_faces_k >= SIX_HOLD_K else COUNTS[1]

    @property
    def surface_altitudes_km(self) -> list[float]:
        """Altitudes of the temperature table."""
        return self.surface_grid.altitude_km or [round(self.site.altitude_km + h, 9) for h in SURFACE_HEIGHTS_KM]

    @property
    def band_names(self) -> list[str]:
        """Names of all bands, in their order."""
        return [band.name or f"b{number:02d}" for number, band in enumerate(self.bands, 1)]

    @property
    def needed_bands(self) -> list[int]:
        """Numbers of the bands that are built, counted from 1."""
        selected = None if self.query_limits is None else self.query_limits.bands
        return [number for number, name in enumerate(self.band_names, 1) if selected is None or name in selected]

    def band_name(self, index: int) -> str:
        """Name of a band, counted from 1: that of the job, or one by its order."""
        return self.bands[index - 1].name or f"b{index:02d}"

    def on_date_of_state(self, index: int) -> Job:
        """The job with its site on the date of a state, counted from 1."""
        day = self.states[index - 1].date or self.site.date
        return self.model_copy(update={"site": self.site.model_copy(update={"date": day})})

    @pydantic.model_validator(mode="after")
    def _above_ground(self) -> Self:
        for name, altitudes in (("atmosphere", self.observer_altitudes_km), ("surface", self.surface_altitudes_km)):
            if altitudes[0] < self.site.altitude_km:
                raise ValueError(
                    f"found {altitudes[0]:g} in {name}_grid.altitude_km; allowed: at least the site's altitude_km, "
                    f"{self.site.altitude_km:g}; raise it, or lower the site"
                )
        return self

    @pydantic.model_validator(mode="after")
    def _operated_once(self) -> Self:
        for name in self.operated:
            if name in self.temperatures_c:
                raise ValueError(f"found '{name}' in operated and in temperatures_c; allowed: one of them; remove one")
        if isinstance(self.materials, list | dict):
            surrounding = {name for state in self.states for name in state.surrounding_materials}
            for name in [*self.operated, *self.temperatures_c]:
                if name not in self.materials and name not in surrounding:
                    raise ValueError(
                        f"found the operated '{name}', which is not in materials; add it there or remove it here"
                    )
        return self

    @pydantic.model_validator(mode="after")
    def _level_ground(self) -> Self:
        limits = None if self.query_limits is None else self.query_limits.slope_deg
        lowest = {
            "surface_grid.slope_deg": self.surface_grid.slope_deg[0],
            "needs.slope_deg": limits[0] if limits else 0,
        }
        for state in self.states:
            for key, slope in lowest.items():
                if state.ground_material is not None and slope > 0:
                    raise ValueError(
                        f"found ground_material '{state.ground_material}' and {key} from {slope:g} on; allowed: from 0"
                        " on, since the ground is level; add 0"
                    )
        return self

    @pydantic.model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.materials == "used" and not self.textures:
            raise ValueError(
                "found 'materials: used' without textures; allowed: used with textures, all, or a list of names; "
                "name the materials"
            )
        for name in self.band_names:
            if self.band_names.count(name) > 1:
                raise ValueError(
                    f"found the band '{name}' twice; allowed: names once each, b01, b02 ... for bands without one;"
                    " rename it"
                )
        check_distinct_names(self.texture_jobs)
        if len(set(self.sources)) != len(self.sources):
            raise ValueError("found a source twice; allowed: sun and moon once each; remove one")
        return self


def resolved_text(content: dict[str, Any]) -> str:
    """YAML text of a resolved job or a part of it, the same for the same content."""
    return str(yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=10_000))
