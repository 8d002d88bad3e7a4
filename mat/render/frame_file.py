"""The frame file: buffers of another renderer, its camera, and the materials of its ids, as typed models.

A renderer gives depth, normals and ids of what each pixel sees. Metres count from the origin of its world, whose height
0 lies at `altitude_km`.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import pydantic
from pydantic import Field

from skyshine.mat.render.scene_file import (
    MAX_FRAMES,
    Azimuth,
    Camera,
    HourRange,
    Hours,
    LoadedFile,
    LoadedScene,
    Mesh,
    Point,
    SceneModel,
    Sensor,
    SurfaceModel,
)
from skyshine.mat.runtime.shade import SHADED_SKY
from skyshine.schemas.documents import StrictModel, parse_model, read_document
from skyshine.schemas.errors import InputError

SKY = "sky"  # in place of a material: the pixel sees the sky
STAR = "*"  # in the name of a file: what tells the frames of a folder apart
RendererName = Literal["blender", "mitsuba", "carla", "airsim", "isaac", "gazebo", "opencv"]
Row3 = tuple[float, float, float]
Row4 = tuple[float, float, float, float]


def _pattern(value: object) -> str:
    if not isinstance(value, str) or not value or value.count(STAR) > 1 or STAR in os.path.dirname(value):
        raise ValueError(
            f"found {value!r}; allowed: the path of a file from the frame file's folder, with at most one {STAR} in its"
            " name, in place of what tells the frames apart"
        )
    return value


BufferPath = Annotated[str, pydantic.BeforeValidator(_pattern)]


class Layer(StrictModel):
    """A picture of the renderer."""

    file: BufferPath = Field(
        description="EXR, PNG, TIFF, PFM or NPY; a * matches the part that differs between frames."
    )
    layer: str | None = Field(
        None, min_length=1, description="Layer of a file that has several, such as ViewLayer.Depth."
    )


class DepthLayer(Layer):
    """How far each pixel sees."""

    kind: Literal["planar", "distance"] | None = Field(
        None,
        description="Along the optical axis, or from the camera to the point; the renderer's own, where it has one.",
    )
    metres_per_value: float = Field(1.0, gt=0, le=1e3, description="Metres per stored unit; 0.001 for millimetres.")


class NormalLayer(Layer):
    """Normals; integers span -1 to 1."""

    space: Literal["world", "camera"] = Field("world", description="Axes of the normals.")


class IdLayer(Layer):
    """What each pixel shows."""

    encoding: Literal["number", "colour", "cryptomatte"] = Field(
        "number", description="The number in the first channel; the colour #RRGGBB; Cryptomatte's names and coverages."
    )
    labels: BufferPath | None = Field(None, description="JSON of Isaac with the names of ids or colours.")


class SunlitLayer(Layer):
    """Share of the direct light that reaches each pixel: 0 in the shade, 1 (of integers, the highest) in the light."""

    lasts_h: float = Field(24.0, gt=0, le=24, description="Hours before the frame for which the shade has lasted.")
    open_sky: float = Field(SHADED_SKY, ge=0, le=1, description="Open share of the sky above what lies in the shade.")


class Buffers(StrictModel):
    """The pictures of the renderer, all of one size."""

    depth: DepthLayer = Field(description="Depth, or distance, of each pixel.")
    ids: IdLayer = Field(description="Ids, colours or names of what each pixel shows.")
    normals: NormalLayer | None = Field(None, description="Without them they follow from the depth.")
    sunlit: SunlitLayer | None = Field(None, description="Without it, and without a mesh, all is in the light.")


class FrameCamera(StrictModel):
    """A pinhole camera; one way to say its lens and one to say its pose."""

    field_of_view_deg: float | None = Field(
        None, gt=0, lt=170, description="Horizontal field of view; the middle of the picture is the axis."
    )
    intrinsics: tuple[Row3, Row3, Row3] | None = Field(
        None, description="Camera matrix [pixel]; the upper left corner of the picture is 0, 0."
    )
    pose: tuple[Row4, Row4, Row4, Row4] | None = Field(
        None, description="Matrix from the camera's axes to the world's, for columns of numbers."
    )
    poses: BufferPath | None = Field(
        None, description="The same in a .npy or text file: one matrix, one a frame, or a file a frame."
    )
    position: Point | None = Field(None, description="Position in the renderer's world [m].")
    look_at: Point | None = Field(None, description="The point in the middle of the picture; the camera is level.")
    quaternion: Row4 | None = Field(None, description="Rotation from the camera's axes to the world's: w, x, y, z.")
    near_clip_m: float | None = Field(
        None, ge=0, le=1e3, description="Near clip distance of Mitsuba, from which its depth counts; by default 0.01."
    )

    @pydantic.model_validator(mode="after")
    def _once(self) -> Self:
        if (self.field_of_view_deg is None) == (self.intrinsics is None):
            raise ValueError("found both or neither of field_of_view_deg and intrinsics; allowed: one of them")
        keys = {name for name in ("pose", "poses", "position", "look_at", "quaternion") if getattr(self, name)}
        if keys not in ({"pose"}, {"poses"}, {"position", "look_at"}, {"position", "quaternion"}):
            raise ValueError(
                "found no pose of the camera, or two; allowed: pose, poses, position with look_at, or position with"
                " quaternion"
            )
        if self.position is not None and self.position == self.look_at:
            raise ValueError("found position and look_at at the same point; allowed: two points; move one")
        if self.intrinsics is not None:
            (fx, skew, _), (zero, fy, _), bottom_row = self.intrinsics
            if fx <= 0 or fy <= 0 or skew or zero or bottom_row != (0, 0, 1):
                raise ValueError("found intrinsics; allowed: [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] with fx and fy > 0")
        return self


class OwnTemperature(StrictModel):
    """A material with a temperature that is not the table's, such as that of an engine or of a person."""

    material: Annotated[str, Field(min_length=1)] = Field(
        description="Material of the databases that gives the reflectance."
    )
    temperature_k: float | None = Field(
        None, ge=150, le=1500, description="Temperature at all hours; by default that of the table."
    )


Entry = Annotated[
    Annotated[str, Field(min_length=1), pydantic.Tag("name")] | Annotated[OwnTemperature, pydantic.Tag("own")],
    pydantic.Discriminator(lambda value: "name" if isinstance(value, str) else "own"),
]


class FrameModel(StrictModel):
    """A whole frame file."""

    skyshine_frame: Literal[1] = Field(description="Version of the frame file.")
    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$", description="Begins the names of the pictures.")
    databases: str = Field(
        "built", min_length=1, description="Folder of a finished mat build, from the frame file's folder."
    )
    state: int = Field(1, ge=1, description="Atmospheric state of the databases, counted from 1.")
    bands: list[str] | None = Field(None, min_length=1, description="Names, b01 where the job gives none; default all.")
    source: Literal["sun", "moon"] = Field("sun", description="Source whose light and path radiance are read.")
    renderer: RendererName = Field(description="Renderer whose axes, depth and sky the buffers have.")
    up: Literal["y", "z"] = Field("z", description="Axis of the renderer's world that points up.")
    x_azimuth_deg: Azimuth | None = Field(
        None, description="Azimuth of the x axis of the renderer's world; by default 90, of AirSim 0."
    )
    altitude_km: float = Field(ge=-0.5, le=9, description="Altitude of height 0 of the renderer's world.")
    camera: FrameCamera = Field(description="Camera of the renderer.")
    buffers: Buffers = Field(description="Buffers that the renderer wrote.")
    materials: dict[str | int, Entry] = Field(
        min_length=1,
        description="Material of the databases for each id or name; 'sky'; or material and temperature_k.",
    )
    default_material: str | None = Field(
        None, min_length=1, description="Material of ids that `materials` lacks; without it they are refused."
    )
    mesh: Mesh | None = Field(
        None, description="What casts shadows and hides sky, in the renderer's world; in place of buffers.sunlit."
    )
    hours: Hours = Field(description="Local clock: of every frame, one for all, or several of one frame.")
    sensors: dict[str, Sensor] | None = Field(
        None, description="Sensors by name of the band; counts are written for these."
    )

    @pydantic.model_validator(mode="after")
    def _fits(self) -> Self:
        if self.mesh is not None and self.buffers.sunlit is not None:
            raise ValueError("found both mesh and buffers.sunlit; allowed: one of them; remove one")
        if self.renderer in ("airsim", "isaac") and self.buffers.depth.kind is None:
            raise ValueError(
                f"found no buffers.depth.kind; {self.renderer} writes both; allowed: planar (DepthPlanar,"
                " distance_to_image_plane) or distance (DepthPerspective, distance_to_camera); add it"
            )
        if self.camera.near_clip_m is not None and self.renderer != "mitsuba":
            raise ValueError("found camera.near_clip_m; allowed: for the renderer mitsuba alone; remove it")
        if self.renderer in ("carla", "airsim") and self.up != "z":
            raise ValueError(f"found up: y; allowed: z, for {self.renderer} has no other; remove it")
        return self


class MeshScene(LoadedScene):
    """The mesh of a frame as a scene without a camera; its errors are at the keys of the frame file."""

    @classmethod
    def of(cls, frame: LoadedFrame, mesh: Mesh) -> Self:
        """The scene of a mesh."""
        surface = SurfaceModel(altitude_km=frame.model.altitude_km, mesh=mesh)
        model = SceneModel.model_construct(
            skyshine_scene=1, name=frame.model.name, surface=surface, camera=Camera.model_construct()
        )
        return cls(model, frame.document)

    def error(self, location: tuple[str | int, ...], message: str) -> InputError:
        return super().error(location[1:], message)  # without the key 'surface' of a scene


class LoadedFrame(LoadedFile[FrameModel]):
    """A frame file with its place."""

    @cached_property
    def marks(self) -> tuple[str, ...]:
        """Text in place of the * for each frame, in ascending order; one empty text without a *.

        Raises
        ------
        InputError
            No file is there, some frames lack one, or there are too many.
        """
        of_files = {location: self._marks(location, name) for location, name in self._patterns().items()}
        several = {location: marks for location, marks in of_files.items() if marks is not None}
        if not several:
            return ("",)
        reference, reference_marks = next(iter(several.items()))
        for location, marks in several.items():
            lacking = sorted(reference_marks ^ marks)
            if lacking:
                lone = location if lacking[0] in reference_marks else reference
                raise self.error(
                    lone,
                    f"found no file for frame '{lacking[0]}'; allowed: one for every frame of {'.'.join(reference)}",
                )
        if len(reference_marks) > MAX_FRAMES:
            raise self.error(
                reference, f"found {len(reference_marks)} frames; allowed: {MAX_FRAMES}; render them in parts"
            )
        return tuple(
            sorted(
                reference_marks,
                key=lambda mark: [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", mark)],
            )
        )

    def path(self, location: tuple[str, ...], mark: str) -> Path:
        """The file of a frame.

        Raises
        ------
        InputError
            It lies outside the folder, or there is none.
        """
        name = self._patterns()[location].replace(STAR, mark)
        path = self.inside(location, name)
        if not path.is_file():
            raise self.error(location, f"found '{name}', which is no file at {path}; name one that is there")
        return path

    @property
    def hours(self) -> list[float]:
        """Local clock hours of the pictures: one for each frame, or several of a single frame.

        Raises
        ------
        InputError
            Their number is neither 1 nor that of the frames.
        """
        value, count = self.model.hours, len(self.marks)
        hours = value.hours() if isinstance(value, HourRange) else value
        if count > 1 and len(hours) not in (1, count):
            raise self.error(("hours",), f"found {len(hours)} hours and {count} frames; allowed: one hour, or {count}")
        return hours * count if len(hours) == 1 else hours

    def _patterns(self) -> dict[tuple[str, ...], str]:
        """Names of files by the key that gives them, depth first."""
        buffers = self.model.buffers
        patterns: dict[tuple[str, ...], str] = {}
        for name in ("depth", "ids", "normals", "sunlit"):
            layer = getattr(buffers, name)
            if layer is not None:
                patterns["buffers", name, "file"] = layer.file
        if buffers.ids.labels is not None:
            patterns["buffers", "ids", "labels"] = buffers.ids.labels
        if self.model.camera.poses is not None:
            patterns["camera", "poses"] = self.model.camera.poses
        return patterns

    def _marks(self, location: tuple[str, ...], name: str) -> set[str] | None:
        """Text in place of the * of a name; None where it has none."""
        path = self.inside(location, name)
        if STAR not in path.name:
            return None
        before, after = path.name.split(STAR)
        names = [file.name for file in path.parent.iterdir()] if path.parent.is_dir() else []
        marks = {
            file[len(before) : len(file) - len(after)]
            for file in names
            if file.startswith(before) and file.endswith(after) and len(file) > len(before) + len(after)
        }
        if not marks:
            raise self.error(location, f"found no file '{path}'; name those of the renderer")
        return marks


def load_frame(source: str | os.PathLike[str] | Mapping[str, Any], *, folder: Path | None = None) -> LoadedFrame:
    """Read, check and type a frame file.

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
    return LoadedFrame(parse_model(document, FrameModel, {"folder": document.file.resolve().parent}), document)
