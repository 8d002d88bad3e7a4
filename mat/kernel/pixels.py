"""The functions of `pixels.h` by `ctypes`: databases and tables in memory of Python, one scratch a thread."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable, Mapping
from ctypes import POINTER, byref, c_char_p, c_double, c_int32, c_size_t, c_void_p
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.kernel.library import function, library
from skyshine.schemas.arrays import Floats

SURFACE, BAND, AIR = range(3)  # kinds of databases
LINEAR, PERIODIC, EXACT = range(3)  # rules of axes
(
    OUTSIDE, CODE, TWILIGHT, DIRECTION, SHARE, LENGTH, NO_MATERIAL, NO_RESPONSE, NO_GROUND, NOT_FINITE, LACKS, NODES,
    VALUES, SUM, NUMBER, BANDS,
) = range(1, 17)  # fmt: skip
NUMBERS = (
    "ground_emissivity", "ground_temperature", "ground_radiance", "ground_albedo", "ground_code", "ground_altitude_km",
    "scale_height_km", "range_first", "range_last", "altitude_first", "altitude_last", "clamp_range", "clamp_altitude",
    "clamp_elevation",
)  # fmt: skip
QUANTITIES = (
    "beta_star", "path_radiance_ratio", "path_radiance_ratio_by_angle", "ambient_radiance", "direct_radiance",
    "ambient_radiance_harmonics", "ground_radiance_harmonics", "optical_depth", "valid",
)  # fmt: skip
PIXELS = (
    "material", "share", "temperature", "surface_altitude", "surface_azimuth", "surface_slope", "time", "range",
    "line_range", "altitude", "elevation", "source_elevation", "source_azimuth", "source_heading", "normal",
    "to_source", "to_observer", "sight_elevation", "sight_heading", "lit_share", "sky_view", "wall_temperature",
    "shade", "shaded_sky", "shaded_temperature", "ground_material", "ground_temperature",
)  # fmt: skip
TERMS = (
    "temperature", "blackbody_radiance", "beta_star", "transmittance", "thermal", "path", "skyshine", "diffuse",
    "specular", "radiance",
)  # fmt: skip
STEPS = 288  # steps of a day
_CODES = {"material", "ground_material"}
_ALIGNMENT = 64  # bytes, of a vector of eight doubles


class Failure(ctypes.Structure):
    """`SkyFailure`."""

    _fields_ = (
        ("status", c_int32),
        ("kind", c_int32),
        ("row", c_size_t),
        ("name", c_char_p),
        ("found", c_double),
        ("least", c_double),
        ("most", c_double),
    )


class KernelRefusal(Exception):
    """A call that the library refuses, with its `Failure`."""

    def __init__(self, failure: Failure) -> None:
        self.status, self.kind, self.row = failure.status, failure.kind, failure.row
        self.name, self.found = failure.name.decode(), failure.found
        self.least, self.most = failure.least, failure.most
        super().__init__(f"{self.name}: status {self.status} at {self.row}, found {self.found:g}")


def aligned(size: int) -> npt.NDArray[np.uint8]:
    """Memory of so many bytes whose first is at a multiple of 64."""
    memory = np.empty(size + _ALIGNMENT, np.uint8)
    start = -memory.ctypes.data % _ALIGNMENT
    return memory[start : start + size]


class _Scratch(threading.local):
    def __init__(self) -> None:
        self.memory = aligned(0)

    def of(self, size: int) -> int:
        if self.memory.size < size:
            self.memory = aligned(size)
        address: int = self.memory.ctypes.data
        return address


_SCRATCH = _Scratch()


@cache
def _single(name: str, restype: Any, *argtypes: Any) -> Callable[..., Any]:
    """A function that is compiled once."""
    called = getattr(library(), f"skyshine_{name}")
    called.argtypes, called.restype = argtypes, restype
    return called  # type: ignore[no-any-return]


@cache
def _vectors(name: str) -> Callable[..., Any]:
    """A function that is compiled for several vectors; the types of its arguments are those of the call."""
    return function(f"skyshine_{name}", None, c_int32)


@cache
def array_names(kind: int) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Arrays of a kind of database in the order of the library, each with the names of its axes."""
    array = _single("array_name", c_char_p, c_int32, c_int32)
    axis = _single("axis_name", c_char_p, c_int32, c_int32, c_int32)
    names: list[tuple[str, tuple[str, ...]]] = []
    while name := array(kind, len(names)):
        axes: list[str] = []
        while of := axis(kind, len(names), len(axes)):
            axes.append(of.decode())
        names.append((name.decode(), tuple(axes)))
    return tuple(names)


class Database:
    """A database in the memory of the library: arrays in single precision, axes, numbers.

    Parameters
    ----------
    kind : int
        `SURFACE`, `BAND` or `AIR`.
    """

    def __init__(self, kind: int) -> None:
        self.kind = kind
        self.memory = aligned(_single("database_size", c_size_t)())
        self._arrays: list[npt.NDArray[Any]] = []
        _single("database_begin", None, c_void_p, c_int32)(self.memory.ctypes.data, kind)

    def set_array(self, number: int, values: npt.NDArray[Any]) -> None:
        """Hand over an array by its place in `array_names`."""
        self._arrays.append(np.ascontiguousarray(values, np.float32))
        address = self._arrays[-1].ctypes.data
        _single("set_array", None, c_void_p, c_int32, c_void_p)(self.memory.ctypes.data, number, address)

    def set_axis(
        self, number: int, axis: int, nodes: Floats, rule: int, period: float, dark_below: float, clamps: bool
    ) -> None:
        """Hand over an axis of an array."""
        self._arrays.append(np.ascontiguousarray(nodes, float))
        nodes_array = self._arrays[-1]
        types = c_void_p, c_int32, c_int32, c_void_p, c_size_t, c_int32, c_double, c_double, c_int32
        position = self.memory.ctypes.data, number, axis, nodes_array.ctypes.data, nodes_array.size
        _single("set_axis", None, *types)(*position, rule, period, dark_below, clamps)

    def set_numbers(self, numbers: Mapping[str, float]) -> None:
        """Hand over numbers by their names in `NUMBERS`."""
        for name, value in numbers.items():
            index = NUMBERS.index(name)
            _single("set_number", None, c_void_p, c_int32, c_double)(self.memory.ctypes.data, index, value)


class Tables:
    """Tables of databases, any of which may be None, arranged for the calls below.

    Raises
    ------
    KernelRefusal
        Atmosphere and band are not of one band; the methods raise it for what `pixels.h` lists.
    """

    def __init__(self, surface: Database | None, band: Database | None, air: Database | None) -> None:
        self.databases = surface, band, air
        addresses = [None if database is None else database.memory.ctypes.data for database in self.databases]
        size = _single("tables_size", c_size_t, *[c_void_p] * 3)(*addresses)
        self._memory = aligned(size)
        make = _single("tables_make", c_int32, *[c_void_p] * 4, POINTER(Failure))
        self._called(make, *addresses)
        self._scratch = int(_single("scratch_size", c_size_t, c_void_p)(self._address))
        self.wavelengths = int(_single("wavelengths", c_size_t, c_void_p)(self._address))

    @property
    def _address(self) -> int:
        address: int = self._memory.ctypes.data
        return address

    def _called(self, called: Callable[..., Any], *arguments: Any) -> None:
        failure = Failure()
        if called(c_void_p(self._address), *arguments, byref(failure)):
            raise KernelRefusal(failure)

    def _computed(self, name: str, *arguments: Any) -> None:
        self._called(_vectors(name), *arguments, c_void_p(_SCRATCH.of(self._scratch)))

    def pixels(self, count: int, materials: int, lines: int, inputs: Mapping[str, npt.ArrayLike]) -> dict[str, Floats]:
        """Terms of equation (1), (count,) each by the names of `TERMS`; arguments by those of `PIXELS`."""
        arrays = {name: np.ascontiguousarray(v, np.int32 if name in _CODES else float) for name, v in inputs.items()}
        results = {name: np.empty(count) for name in TERMS}
        pixels, terms = _addresses(PIXELS, arrays), _addresses(TERMS, results)
        self._computed("pixel_terms", c_size_t(count), c_size_t(materials), c_size_t(lines), pixels, terms)
        return results

    def quantity(self, quantity: str, coordinates: list[Floats], *, by_wavelength: bool) -> Floats:
        """A quantity of `QUANTITIES` at places: range, altitude, elevation and up to two more, (n,) each."""
        arrays = {str(number): np.ascontiguousarray(values, float) for number, values in enumerate(coordinates)}
        count, spectral = arrays["0"].size, by_wavelength or quantity == "optical_depth"
        values = np.empty((count, self.wavelengths) if spectral else count)
        addresses, number = _addresses(tuple("01234"), arrays), QUANTITIES.index(quantity)
        self._computed(
            "quantity",
            c_int32(number),
            c_int32(by_wavelength),
            c_size_t(count),
            addresses,
            c_void_p(values.ctypes.data),
        )
        return values

    def ambient(
        self, coordinates: list[Floats], slope: Floats, azimuth: Floats, ground: Floats | None, *, by_wavelength: bool
    ) -> Floats:
        """Light of the sky (n,) or (n, B) on faces at places: range, altitude, elevation, source elevation; azimuth
        from the source, temperature of the ground [K] or that which the file states.
        """
        arrays = {str(number): np.ascontiguousarray(values, float) for number, values in enumerate(coordinates)}
        faces = [None if v is None else np.ascontiguousarray(v, float) for v in (slope, azimuth, ground)]
        count = arrays["0"].size
        values = np.empty((count, self.wavelengths) if by_wavelength else count)
        addresses = [None if array is None else c_void_p(array.ctypes.data) for array in (*faces, values)]
        self._computed(
            "ambient", c_int32(by_wavelength), c_size_t(count), _addresses(tuple("01234"), arrays), *addresses
        )
        return values

    def heated(self, faces: list[npt.NDArray[Any]], absorbed: Floats, hours: Floats) -> Floats:
        """Temperatures (n, T) of faces (material, altitude, azimuth, slope; (n,) each) under changes of heat (n, steps)
        at hours (n, T).
        """
        values, heat, times = np.empty(hours.shape), np.ascontiguousarray(absorbed, float), np.ascontiguousarray(hours)
        face_arrays = _faces(faces)
        self._computed(
            "heated", c_size_t(len(values)), _addresses(tuple("0123"), face_arrays), c_void_p(heat.ctypes.data),
            c_size_t(heat.shape[1]), c_void_p(times.ctypes.data), c_size_t(hours.shape[1]),
            c_void_p(values.ctypes.data),
        )  # fmt: skip
        return values

    def changes(self, faces: list[npt.NDArray[Any]], absorbed: Floats, temperature: Floats, highest: Floats) -> Floats:
        """Changes of temperature (n, STEPS) by heat (n, STEPS), of faces with temperatures (n, STEPS) in the open, NaN
        where they are not known, and highest ones (n,).
        """
        inputs = [np.ascontiguousarray(values, float) for values in (absorbed, temperature, highest)]
        face_arrays, values = _faces(faces), np.empty((len(highest), STEPS))
        addresses = [c_void_p(array.ctypes.data) for array in (*inputs, values)]
        self._computed("changes", c_size_t(len(values)), _addresses(tuple("0123"), face_arrays), *addresses)
        return values

    def absorbed(
        self,
        faces: list[npt.NDArray[Any]],
        shaded: Floats,
        sky_view: Floats,
        facing: float | None,
        facing_emissivity: float,
    ) -> Floats:
        """Change of the heat (n, STEPS) that faces absorb, of surroundings of each or of all: `shaded` (n or 1, STEPS),
        `sky_view` (n or 1,).
        """
        face_arrays, count = _faces(faces), len(faces[0])
        rows = max(len(shaded), sky_view.size)
        surroundings = {
            "shaded": np.ascontiguousarray(np.broadcast_to(shaded, (rows, STEPS)), float),
            "sky_view": np.ascontiguousarray(np.broadcast_to(sky_view.ravel(), rows), float),
            "facing": np.full(rows, np.nan if facing is None else facing, float),
            "facing_emissivity": np.full(rows, facing_emissivity, float),
        }
        values = np.empty((count, STEPS))
        self._computed(
            "absorbed", c_size_t(count), _addresses(tuple("0123"), face_arrays),
            _addresses(tuple(surroundings), surroundings),
            c_int32(rows > 1), c_void_p(values.ctypes.data),
        )  # fmt: skip
        return values


def _faces(faces: list[npt.NDArray[Any]]) -> dict[str, npt.NDArray[Any]]:
    return {
        str(number): np.ascontiguousarray(values, float if number else np.int32) for number, values in enumerate(faces)
    }


def _addresses(names: tuple[str, ...], arrays: Mapping[str, npt.NDArray[Any]]) -> Any:
    """A structure of addresses; 0 where an array is not given."""
    return (c_void_p * len(names))(*[arrays[name].ctypes.data if name in arrays else None for name in names])
