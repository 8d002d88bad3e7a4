"""The scene file: a surface, a camera, hours and bands of built databases, as typed models.

Metres count from the origin of the scene: x to the east, y to the north, z up from `surface.altitude_km`. The origin of
a plan is its centre, that of a mesh the origin of its file.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Generic, Literal, Protocol, Self, TypeVar

import numpy as np
import pydantic
from pydantic import Field

from skyshine.mat.runtime.shade import SHADED_SKY
from skyshine.schemas.documents import Document, StrictModel, parse_model, read_document
from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import job_path

MAX_RAYS = 1 << 22  # rays of a frame, for memory
MAX_FRAMES = 1000  # files of a run


def _existing(value: object, info: pydantic.ValidationInfo) -> Path:
    if isinstance(value, Path):
        return value
    if not isinstance(value, str) or not value:
        raise ValueError(f"found {value!r}; allowed: the path of a file, relative to the scene file")
    path = job_path((info.context or {}).get("folder", "."), value)
    if not path.is_file():
        raise ValueError(
            f"found '{value}', which is no file at {path}; allowed: a path from the scene's folder; fix it"
        )
    return path


SceneFilePath = Annotated[
    pydantic.InstanceOf[Path],
    pydantic.BeforeValidator(_existing),
    pydantic.WithJsonSchema({"type": "string", "minLength": 1}),
]
Hour = Annotated[float, Field(ge=0, lt=24)]
Metres = Annotated[float, Field(ge=-1e6, le=1e6)]
Point = tuple[Metres, Metres, Metres]
Azimuth = Annotated[float, Field(ge=-360, le=360)]
Side = Annotated[int, Field(ge=1, le=16384)]


class HeightMap(StrictModel):
    """Heights of a plan as an image that covers the same ground as its texture."""

    image: SceneFilePath = Field(description="One channel; TIFF, or what else OpenImageIO reads as stored numbers.")
    metres_per_value: float = Field(1.0, gt=0, le=1e5, description="Height of one step of the stored numbers.")
    metres_at_zero: Metres = Field(0.0, description="Height of a stored 0 above surface.altitude_km.")


class Plan(StrictModel):
    """A texture seen from above, such as an aerial photograph, on level ground or over heights."""

    texture: SceneFilePath = Field(description="Path of the .tmm.h5 file.")
    metres_per_texel: float = Field(gt=0, le=1e4, description="Along both sides of a texel.")
    top_azimuth_deg: Azimuth = Field(0.0, description="Azimuth of the top of the image.")
    height_map: HeightMap | None = Field(None, description="Heights of the ground; without one it is level.")


class TextureOfMaterial(StrictModel):
    """Material codes over the texture coordinates of a mesh."""

    texture: SceneFilePath = Field(description="A .tmm.h5 file; its first texel lies at the texture coordinate (0, 0).")


MeshMaterial = Annotated[
    Annotated[str, Field(min_length=1), pydantic.Tag("name")] | Annotated[TextureOfMaterial, pydantic.Tag("texture")],
    pydantic.Discriminator(lambda value: "name" if isinstance(value, str) else "texture"),
]


class Mesh(StrictModel):
    """Triangles of a glTF or OBJ file."""

    file: SceneFilePath = Field(description="A .glb, .gltf or .obj file.")
    materials: dict[str, MeshMaterial] = Field(
        min_length=1, description="Material of the databases, or a texture, for each material of the file by its name."
    )
    up: Literal["y", "z"] = Field("y", description="Axis of the file that points up; glTF says y, OBJ says nothing.")
    x_azimuth_deg: Azimuth = Field(90.0, description="Azimuth of the x axis of the file.")
    metres_per_unit: float = Field(
        1.0, gt=0, le=1e6, description="Metres per unit of the file's coordinates; glTF says 1."
    )


class SurfaceModel(StrictModel):
    """What is seen: exactly one of a plan and a mesh."""

    altitude_km: float = Field(ge=-0.5, le=9, description="Altitude of height 0.")
    plan: Plan | None = Field(None, description="A texture seen from above.")
    mesh: Mesh | None = Field(None, description="Triangles with materials.")
    unknown_material: str | None = Field(
        None,
        min_length=1,
        description="Material of texels to which their texture gives none; without it they are refused.",
    )

    replaced_materials: dict[str, str] = Field(
        {},
        description="Materials that the databases lack, with those that replace them; mat check --scene names them.",
    )
    shaded_materials: dict[str, Annotated[float, Field(ge=0, le=1)]] = Field(
        {},
        description="Materials on which no direct light falls all day, as ground under trees, each with the open share"
        " of its sky.",
    )

    shaded_sky: float = Field(
        SHADED_SKY,
        ge=0,
        le=1,
        description="Open share of the sky above ground that a texture's layer of shade shows in the shade; no direct"
        " light falls there all day.",
    )
    vertices: Literal["centre", "nearest"] | None = Field(
        None,
        description="Temperatures at the vertices of the faces alone, as an older runtime has them: of the material in"
        " the centre of a face, or of the texel nearest to each vertex; without it each pixel has its own.",
    )

    @pydantic.model_validator(mode="after")
    def _one_surface(self) -> Self:
        if (self.plan is None) == (self.mesh is None):
            raise ValueError("found both or neither of plan and mesh; allowed: one of them")
        return self


class PlanView(StrictModel):
    """An observer who looks straight down at every pixel, as an orthophoto does."""

    height_m: float = Field(gt=0, le=1e5, description="Height of the observer above surface.altitude_km.")
    size: tuple[Side, Side] = Field(description="Columns and rows.")
    samples: int = Field(1, ge=1, le=8, description="Rays along each side of a pixel, which is the mean of them.")
    centre_m: tuple[Metres, Metres] = Field((0.0, 0.0), description="Centre of the picture: east and north.")
    width_m: float | None = Field(
        None, gt=0, le=1e6, description="Width of the picture; by default the surface fits in."
    )
    top_azimuth_deg: Azimuth | None = Field(
        None, description="Azimuth of the top of the picture; by default that of the plan, north for a mesh."
    )


class Station(StrictModel):
    """Position and aim of the camera at an hour."""

    hour: Hour = Field(description="Local clock.")
    position_m: Point = Field(description="Position of the camera: east, north and up.")
    look_at_m: Point = Field(description="The point in the middle of the picture.")


class Perspective(StrictModel):
    """A pinhole camera, still or on a track."""

    field_of_view_deg: float = Field(gt=0, lt=170, description="Horizontal field of view.")
    size: tuple[Side, Side] = Field(description="Columns and rows.")
    samples: int = Field(1, ge=1, le=8, description="Rays along each side of a pixel, which is the mean of them.")
    position_m: Point | None = Field(None, description="Position of the camera: east, north and up.")
    look_at_m: Point | None = Field(None, description="The point in the middle of the picture.")
    track: list[Station] | None = Field(
        None,
        min_length=1,
        max_length=MAX_FRAMES,
        description="Stations of a moving camera, instead of position_m, look_at_m and hours.",
    )

    @pydantic.model_validator(mode="after")
    def _one_place(self) -> Self:
        still = (self.position_m is not None, self.look_at_m is not None)
        if not (all(still) if self.track is None else not any(still)):
            raise ValueError("found no place of the camera, or two; allowed: position_m and look_at_m, or track")
        stations = [(self.position_m, self.look_at_m)] if self.track is None else []
        stations += [(station.position_m, station.look_at_m) for station in self.track or []]
        for position, look_at in stations:
            if position == look_at:
                raise ValueError("found position_m and look_at_m at the same point; allowed: two points; move one")
        return self


class Camera(StrictModel):
    """Exactly one of two kinds of camera."""

    perspective: Perspective | None = Field(None, description="A pinhole camera.")
    plan_view: PlanView | None = Field(None, description="An observer who looks straight down at every pixel.")

    @pydantic.model_validator(mode="after")
    def _one_kind(self) -> Self:
        if (self.perspective is None) == (self.plan_view is None):
            raise ValueError("found both or neither of perspective and plan_view; allowed: one of them")
        rays = self.size[0] * self.size[1] * self.samples**2
        if rays > MAX_RAYS:
            raise ValueError(f"found a picture of {rays} rays; allowed: {MAX_RAYS}; make size or samples smaller")
        return self

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows."""
        return self._kind.size

    @property
    def samples(self) -> int:
        """Rays along each side of a pixel."""
        return self._kind.samples

    @property
    def _kind(self) -> Perspective | PlanView:
        kind = self.perspective or self.plan_view
        assert kind is not None
        return kind


class HourRange(StrictModel):
    """Equal steps through a part of the day."""

    first: Hour = Field(description="Local clock.")
    last: Hour = Field(description="Local clock, not before the first.")
    step: float = Field(gt=0, le=24, description="Hours between two pictures.")

    @pydantic.model_validator(mode="after")
    def _few(self) -> Self:
        if self.last < self.first or (self.last - self.first) / self.step >= MAX_FRAMES:
            raise ValueError(f"allowed: last after first, and at most {MAX_FRAMES} hours; change first, last or step")
        return self

    def hours(self) -> list[float]:
        """All of them."""
        count = int(np.floor((self.last - self.first) / self.step + 1e-9)) + 1
        return [self.first + self.step * number for number in range(count)]


Hours = Annotated[
    Annotated[list[Hour], Field(min_length=1, max_length=MAX_FRAMES), pydantic.Tag("list")]
    | Annotated[HourRange, pydantic.Tag("range")],
    pydantic.Discriminator(lambda value: "list" if isinstance(value, list | tuple) else "range"),
]


class Sensor(StrictModel):
    """Equation (44): counts of N bits from radiance in W m^-2 sr^-1."""

    bits: int = Field(12, ge=1, le=16, description="Bits of a count.")
    gain: float = Field(gt=0, description="G: radiance of the highest count where buffer_gain is 1 and offset 0.")
    buffer_gain: float = Field(1.0, gt=0, description="BG: factor on the counts.")
    offset: float = Field(0.0, ge=-1, le=1, description="DC: taken from radiance over gain before it is counted.")


class _OfDatabases(Protocol):
    @property
    def databases(self) -> str: ...


FileModel = TypeVar("FileModel", bound=_OfDatabases)


class SceneModel(StrictModel):
    """A whole scene file."""

    skyshine_scene: Literal[1] = Field(description="Version of the scene file.")
    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$", description="Begins the names of the pictures.")
    databases: str = Field(
        "built", min_length=1, description="Folder of a finished mat build, from the scene's folder."
    )
    state: int = Field(1, ge=1, description="Atmospheric state of the databases, counted from 1.")
    bands: list[str] | None = Field(None, min_length=1, description="Names, b01 where the job gives none; default all.")
    source: Literal["sun", "moon"] = Field("sun", description="Source whose light and path radiance are read.")
    surface: SurfaceModel = Field(description="What is seen.")
    camera: Camera = Field(description="Camera of the scene.")
    hours: Hours | None = Field(None, description="Local clock; 0 to 21 by 3 without it.")
    sensors: dict[str, Sensor] | None = Field(
        None, description="Sensors by name of the band; counts are written for these."
    )

    @pydantic.model_validator(mode="after")
    def _hours_once(self) -> Self:
        perspective = self.camera.perspective
        if perspective is not None and perspective.track is not None and self.hours is not None:
            raise ValueError("found hours and a track, which has its own; allowed: one of them; remove one")
        return self


@dataclass(frozen=True)
class LoadedFile(Generic[FileModel]):
    """A file that asks for pictures, with the place it came from."""

    model: FileModel
    document: Document

    @property
    def folder(self) -> Path:
        """Folder against which the paths of the file are read."""
        return self.document.file.resolve().parent

    @property
    def databases(self) -> Path:
        """Folder of the databases.

        Raises
        ------
        InputError
            It lies outside the folder of the file, and the user has not allowed that.
        """
        return self.inside(("databases",), self.model.databases)

    def inside(self, location: tuple[str, ...], name: str) -> Path:
        """The path that a key of the file names; raises as `databases`."""
        try:
            return job_path(self.folder, name)
        except ValueError as error:
            raise self.error(location, str(error)) from None

    def error(self, location: tuple[str | int, ...], message: str) -> InputError:
        """An error at a key of the file."""
        return self.document.error(location, f"{'.'.join(map(str, location))}: {message}")


class LoadedScene(LoadedFile[SceneModel]):
    """A scene with the file it came from."""

    @property
    def hours(self) -> list[float]:
        """Local clock hours of the frames."""
        perspective, hours = self.model.camera.perspective, self.model.hours
        if perspective is not None and perspective.track is not None:
            return [station.hour for station in perspective.track]
        if isinstance(hours, list):
            return hours
        return (hours or HourRange(first=0.0, last=21.0, step=3.0)).hours()


def load_scene(source: str | os.PathLike[str] | Mapping[str, Any], *, folder: Path | None = None) -> LoadedScene:
    """Read, check and type a scene.

    Parameters
    ----------
    source : path or mapping
        A YAML file, or its content as plain data.
    folder : Path, optional
        Base folder of relative paths in a mapping; by default the working directory.

    Raises
    ------
    InputError
        With file:line:column of the first thing that does not fit.
    """
    document = read_document(source, folder)
    return LoadedScene(parse_model(document, SceneModel, {"folder": document.file.resolve().parent}), document)
