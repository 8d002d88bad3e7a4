"""A database, read and checked whole before the first pixel, with h5py and numpy alone."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from .axis import Axis, Floats, SceneError
from .channels import Channels
from .layouts import (
    ARRAYS,
    CHANNEL_BENDING,
    CHANNEL_HARMONICS,
    CHANNEL_SHARES,
    CHANNELS,
    CIVIL_TWILIGHT,
    CLAMPED,
    FILM,
    FILM_BEFORE,
    FORMATS,
    GLOW,
    GROUND,
    HARMONICS,
    LIGHT,
    NIGHT,
    NIGHT_HARMONICS,
    RULES,
    SHADE,
    SHARES,
    SPECTRA,
    STATED,
    TRACKS,
    WAVELENGTH,
    WAVELENGTH_ROUNDING,
    WEIGHT_ROUNDING,
    WITHOUT_SOURCE,
    Layouts,
)

# Deflate packs at most 1032 bytes into one: a file that claims more does not hold it.
PACKING, SMALL = 1100, 1 << 20


class Database:
    """One file, read and checked whole: files come from anywhere, and nothing in one is believed before."""

    def __init__(self, path: Path, filetypes: Sequence[str], clamped: Sequence[str]) -> None:
        self.path, self.clamped = path, clamped
        self.arrays: dict[str, tuple[list[Axis], NDArray[np.float32]]] = {}
        self.codes: dict[str, int] = {}
        self.ground: dict[str, float] = {}  # of a file with harmonics
        self.ground_material, self.ground_temperature = "", math.nan  # of any atmosphere that says them
        self.filetype = ""
        self.channels: Channels | None = None
        self.parted = False  # light is read at each wavelength of the band
        try:
            if not path.is_file():
                raise OSError
            self.bytes = PACKING * path.stat().st_size + SMALL
            file = h5py.File(path, "r")
        except OSError:
            raise SceneError(f"{path}: is not a readable HDF5 file") from None
        with file:
            try:
                self._read(file, filetypes)
            except (OSError, KeyError, RuntimeError, ValueError, TypeError, AttributeError) as error:
                words = " ".join(str(error).split())
                raise SceneError(f"{path}: is damaged ({words:.100})") from None

    def _read(self, file: h5py.File, filetypes: Sequence[str]) -> None:
        filetype, version = (text(file, name) for name in ("filetype", "format_version"))
        majors = FORMATS[filetypes[0]]
        if filetype not in filetypes or not version.startswith(majors):
            allowed = f"{' or '.join(filetypes)} {' or '.join(f'{major}x' for major in majors)}"
            raise SceneError(f"{self.path}: holds {filetype[:40]!r} {version[:20]}; allowed: {allowed}")
        self.filetype = filetype
        if "atmq" in filetypes:
            self.ground_material = text(file, "ground_material")
            self.ground_temperature = number(file, "ground_temperature")
        in_channels = "atmq" in filetypes and version.startswith("3.")
        self.own_axes = not in_channels  # an array may have axes of its own, named after it: not in format 3
        stated = self._stated(file) if in_channels else {}
        for name, (axes, least, most) in (
            channel_layouts(file) if in_channels else self._layouts(file, filetype)
        ).items():
            self.arrays[name] = self._array(file, name, axes, least, most)
        self._check_shares()
        if in_channels:
            self._check_channels()
            self.channels = Channels(self.arrays, self._parts, stated, self.clamped)
        if self.codes_of(LIGHT).size:
            self._check_light(file)
        if NIGHT.keys() <= self.arrays.keys():
            self._check_night()
        if filetype == "band":
            self.codes = self._names(file, self.arrays["reflectance"][0][0])

    def _layouts(self, file: h5py.File, filetype: str) -> Layouts:
        """What the file must hold, by the first array of each part that may be absent."""
        if filetype == "band":
            return ARRAYS["band"] | (SPECTRA if SPECTRA.keys() & file.keys() else {})
        if filetype == "htt":
            parts = (SHADE, FILM, FILM_BEFORE, TRACKS)
            return ARRAYS["htt"] | {k: v for part in parts if next(iter(part)) in file for k, v in part.items()}
        layouts = ARRAYS["atmq"] | (HARMONICS if LIGHT in file else {})
        if next(iter(NIGHT)) in file:
            layouts = layouts | NIGHT | (NIGHT_HARMONICS if LIGHT in file else {})
        return layouts

    def _check_light(self, file: h5py.File) -> None:
        """The harmonics go together, and the file states the ground."""
        if (self.codes_of(LIGHT).size == 6) != (self.codes_of(GLOW).size == 3):
            raise SceneError(f"{self.path}: '{LIGHT}' and '{GLOW}' are of different harmonics")
        self.ground = {name: number(file, name) for name in GROUND}
        if not all(math.isfinite(value) and value >= 0 for value in self.ground.values()):
            raise SceneError(f"{self.path}: does not state the ground: {', '.join(GROUND)}")

    def _stated(self, file: h5py.File) -> dict[str, tuple[float, ...]]:
        """What a file in channels says of the air and of the paths that it is for."""
        if text(file, "layout") != "channels":
            raise SceneError(f"{self.path}: has the layout {text(file, 'layout')[:40]!r}; allowed: channels")
        stated = {name: numbers(file, name, count) for name, (count, _, _) in STATED.items()}
        for name, (_, least, most) in STATED.items():
            ends = stated[name]
            if not all(least <= value <= most for value in ends) or ends[0] > ends[-1]:
                raise SceneError(f"{self.path}: does not state '{name}', in {least:g} to {most:g} and ascending")
        return stated

    def _check_channels(self) -> None:
        """The weights sum to 1, and the source elevations say where it is dark."""
        if not abs(np.sum(self.arrays["channel_weight"][1], dtype=float) - 1) <= WEIGHT_ROUNDING:
            raise SceneError(f"{self.path}: 'channel_weight' does not sum to 1")
        if math.isnan(self.arrays["source_factor"][0][1].dark_below):
            raise SceneError(f"{self.path}: the source elevations of 'source_factor' do not state dark_below")

    def _check_shares(self) -> None:
        """The shares of the wavelengths sum to 1."""
        for name in SHARES:
            if name in self.arrays:
                sums = self.arrays[name][1].sum(axis=1, dtype=float)
                if not np.all(np.abs(sums - 1) <= WEIGHT_ROUNDING):
                    raise SceneError(f"{self.path}: the shares of a row of '{name}' do not sum to 1")

    @property
    def wavelengths(self) -> Floats:
        """Wavelengths of the band [um] at which the file parts light; none where it does not."""
        held = [self.arrays[name][0][-1].nodes for name in SHARES if name in self.arrays]
        return held[0] if held else np.empty(0)

    def part_light(self, band: Database) -> None:
        """Read the light of this atmosphere at each wavelength, where it and the file of the band hold what that takes;
        they are then of one band.
        """
        ours, theirs = self.wavelengths, band.wavelengths
        self.parted = ours.size > 0 and theirs.size > 0
        if self.parted and (
            ours.size != theirs.size or np.any(np.abs(ours - theirs) > WAVELENGTH_ROUNDING * np.abs(theirs))
        ):
            spans = [f"{nodes.size} from {nodes[0]:g} to {nodes[-1]:g} um" for nodes in (theirs, ours)]
            raise SceneError(f"{band.path}: has the wavelengths {spans[0]}; allowed: those of the air, {spans[1]}")

    def codes_of(self, harmonics: str) -> Floats:
        """Codes of the coefficients of `LIGHT` or `GLOW`; none where the file has no harmonics."""
        stored = harmonics if self.channels is None else self.channels.stored(harmonics)
        return self.arrays[stored][0][-1].nodes if stored in self.arrays else np.empty(0)

    def _check_night(self) -> None:
        """The axes of source elevation say where it is dark."""
        for name in WITHOUT_SOURCE.keys() & self.arrays.keys():
            if math.isnan(self.arrays[name][0][3].dark_below):
                raise SceneError(f"{self.path}: the source elevations of '{name}' do not state dark_below")

    def _dataset(self, file: h5py.File, name: str, dtype: str, rank: int) -> h5py.Dataset:
        """An array of this very file, of a type (in any byte order) and so many axes."""
        if name not in file and not isinstance(file.get(name, getlink=True), h5py.SoftLink):
            raise SceneError(f"{self.path}: lacks '{name}'")
        if not isinstance(file.get(name, getlink=True), h5py.HardLink):
            raise SceneError(f"{self.path}: '{name}' is a link to somewhere else")
        dataset = file[name]
        if not isinstance(dataset, h5py.Dataset):
            raise SceneError(f"{self.path}: '{name}' is not an array")
        if dataset.is_virtual or dataset.external is not None:
            raise SceneError(f"{self.path}: '{name}' is kept in another file")
        if dataset.dtype.newbyteorder("=") != np.dtype(dtype):
            raise SceneError(f"{self.path}: '{name}' has values of another type")
        if dataset.shape is None or len(dataset.shape) != rank or dataset.size == 0:
            raise SceneError(f"{self.path}: '{name}' has the shape {dataset.shape}; allowed: {rank} axes, none empty")
        if dataset.size * dataset.dtype.itemsize > self.bytes:
            raise SceneError(f"{self.path}: '{name}' claims more bytes than the file can hold")
        return dataset

    def _axis(self, file: h5py.File, quantity: str, name: str) -> tuple[Axis, h5py.Dataset]:
        """The quantity's own axis where the file has one, else the one that quantities share."""
        own = f"{quantity}_{name}" if self.own_axes and f"{quantity}_{name}" in file else name
        dataset = self._dataset(file, own, "i4" if RULES.get(name, ((), 0.0))[0] == ("exact",) else "f8", 1)
        policy = text(dataset, "out_of_range") if "out_of_range" in dataset.attrs else "error"
        if policy not in ("error", "clamp"):
            raise SceneError(f"{self.path}: the axis '{own}' has out_of_range {policy[:40]!r}; allowed: error, clamp")
        axis = Axis(
            name,
            dataset[()].astype(float),
            text(dataset, "interpolation"),
            number(dataset, "period") if "period" in dataset.attrs else 0.0,
            policy == "clamp" or name in CLAMPED or name.removeprefix("sky_") in self.clamped,
            number(dataset, "dark_below"),
        )
        if fault := axis.fault():
            raise SceneError(f"{self.path}: the axis '{own}' has {fault}")
        return axis, dataset

    def _array(
        self, file: h5py.File, quantity: str, names: Sequence[str], least: float, most: float
    ) -> tuple[list[Axis], NDArray[np.float32]]:
        dataset, axes = self._dataset(file, quantity, "f4", len(names)), []
        scales = scales_of(dataset)
        for k, name in enumerate(names):
            by_angle = name == "source_azimuth" and "scattering_angle" in file
            axis, nodes = self._axis(file, quantity, "scattering_angle" if by_angle else name)
            if dataset.shape[k] != axis.nodes.size:
                found = f"{dataset.shape[k]} values along '{axis.name}', which has {axis.nodes.size} nodes"
                raise SceneError(f"{self.path}: '{quantity}' has {found}")
            if len(scales) != len(names) or scales[k] != nodes:
                raise SceneError(f"{self.path}: '{quantity}' has other dimension scales than its axes")
            axes.append(axis)
        values = dataset[()]
        if not np.all((values >= least) & (values <= most) & np.isfinite(values)):
            raise SceneError(f"{self.path}: '{quantity}' holds values beyond {least:g} to {most:g}")
        return axes, values

    def _names(self, file: h5py.File, axis: Axis) -> dict[str, int]:
        """Codes of the materials by name."""
        dataset = self._dataset(file, "material_name", "O", 1)
        names = dataset.asstr()[()].tolist()
        if len(set(names)) != axis.nodes.size or len(names) != axis.nodes.size or not all(names):
            raise SceneError(f"{self.path}: 'material_name' does not hold a name for each code")
        return dict(zip(names, map(int, axis.nodes), strict=True))

    def value(self, quantity: str, where: Mapping[str, float]) -> float:
        """A quantity at a place; below the lowest elevation of the source, its light fades into what the air emits."""
        if self.channels is not None:
            return self.channels.value(quantity, where)
        if quantity in WITHOUT_SOURCE and next(iter(NIGHT)) in self.arrays:
            axis, height = self.arrays[quantity][0][3], where["source_elevation"]
            lowest, dark = axis.nodes[0], axis.dark_below
            if math.isfinite(height) and height < lowest and (height <= dark or lowest <= CIVIL_TWILIGHT):
                share = (height - dark) / (lowest - dark) if height > dark else 0.0
                total = share * self._interpolated(quantity, {**where, "source_elevation": lowest})
                emitted = WITHOUT_SOURCE[quantity]
                return total + (1.0 - share) * self._interpolated(emitted, where) if emitted else total
        return self._interpolated(quantity, where)

    def light(self, quantity: str, where: Mapping[str, float]) -> Floats:
        """Light on surfaces at each wavelength; one number for the whole band where light is not parted."""
        if self.channels is not None and self.parted:
            return self.channels.light(quantity, where)
        return np.array([self.value(quantity, where)])

    def transmittance(self, where: Mapping[str, float], reach: float) -> Floats:
        """Transmittance over a range, from that over the range of the place; (9) where light is not parted."""
        if self.channels is not None and self.parted:
            return self.channels.transmittance(where, reach)
        return np.array([math.exp(-5.5 * reach / self.value("beta_star", where))])

    def spectrum(self, quantity: str, where: Mapping[str, float]) -> Floats:
        """A quantity of this file of a band at each of its wavelengths."""
        return np.array([self._interpolated(quantity, {**where, WAVELENGTH: node}) for node in self.wavelengths])

    def _interpolated(self, quantity: str, where: Mapping[str, float]) -> float:
        """Linear interpolation in every axis."""
        return float(self._parts(quantity, where, 0))

    def _parts(self, quantity: str, where: Mapping[str, float], parts: int = 1) -> Floats:
        """Linear interpolation in the axes behind the first ones: the weighted sum over the corners of one cell."""
        axes, values = self.arrays[quantity]
        sides: list[list[tuple[int, float]]] = []  # of the cell, on each axis: those that have a share, with it
        for axis in axes[parts:]:
            lower, upper, weight = axis.locate(where[axis.name])
            sides.append([(node, share) for node, share in ((lower, 1.0 - weight), (upper, weight)) if share])
        total = np.zeros(values.shape[:parts])
        for corner in itertools.product(*sides):
            at: tuple[Any, ...] = (..., *(node for node, _ in corner))
            total += math.prod(share for _, share in corner) * values[at].astype(float)
        return total

    def material(self, given: str | float) -> float:
        """Code of a material given by code or by name."""
        if not isinstance(given, str):
            return given
        if given not in self.codes:
            raise SceneError(f"material: found '{given:.60}'; allowed: {', '.join(self.codes):.200}")
        return self.codes[given]


def channel_layouts(file: h5py.File) -> Layouts:
    """What a file in channels must hold: the harmonics together or none of them, the shares of wavelengths likewise."""
    parts = (CHANNEL_HARMONICS, CHANNEL_BENDING, CHANNEL_SHARES)
    return CHANNELS | {name: layout for part in parts if part.keys() & file.keys() for name, layout in part.items()}


def text(item: h5py.HLObject, name: str) -> str:
    """A text attribute; empty where there is none, or it is not one text."""
    value = item.attrs.get(name)
    if isinstance(value, bytes):
        return value.decode(errors="replace")
    return value if isinstance(value, str) else ""


def number(item: h5py.HLObject, name: str) -> float:
    """A number attribute; NaN where there is none, or it is not one number."""
    value = item.attrs.get(name)
    if value is None or isinstance(value, str | bytes) or np.size(value) != 1:
        return math.nan
    return float(np.reshape(value, ()))


def numbers(item: h5py.HLObject, name: str, count: int) -> tuple[float, ...]:
    """So many numbers of an attribute in one dimension, or one without; NaN where it is not that."""
    value = np.asarray(item.attrs.get(name, math.nan))
    if value.dtype.kind not in "iuf" or value.shape != ((count,) if count > 1 else ()):
        return (math.nan,) * count
    return tuple(np.atleast_1d(value).astype(float).tolist())


def scales_of(dataset: h5py.Dataset) -> list[h5py.Dataset]:
    """The first dimension scale of each axis, by the references of DIMENSION_LIST; h5py's `dims` believes its type."""
    if "DIMENSION_LIST" not in dataset.attrs:
        return []
    dtype = dataset.attrs.get_id("DIMENSION_LIST").dtype
    if (base := h5py.check_vlen_dtype(dtype)) is None or h5py.check_ref_dtype(base) is not h5py.Reference:
        return []
    return [dataset.file[references[0]] for references in dataset.attrs["DIMENSION_LIST"] if len(references)]
