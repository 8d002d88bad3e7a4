"""Bad files for the parts that a table of temperatures may hold beside its main array: response to shade, films of
water, tracks of Sun and Moon.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import h5py
import hdf5_changes as change
import numpy as np

Edit = Callable[[h5py.File], object]
RESPONSE = ("response_altitude", "response_slope", "response_hour")
AXES = (*RESPONSE, "lag", "temperature_offset", "forcing_time", "track_time")
# Arrays of each part, with values that they may not hold.
OUTSIDE: dict[str, tuple[float, ...]] = {
    "response_kernel": (),
    "response_temperature": (-1.0,),
    "heat_loss_slope": (-1.0, 0.0),
    "heat_loss_excess": (),
    "solar_absorptance": (-0.5, 1.5),
    "thermal_emissivity": (-0.5, 1.5),
    "melting_heat": (-1.0,),
    "film_heat_loss": (),
    "film_evaporation": (),
    "film_sunlight": (),
    "absorbed_sunlight": (-1.0,),
    "film_capacity": (-0.1,),
    "rain": (-1e-4,),
    "highest_temperature": (-1.0, 0.0),
    "direct_normal_irradiance": (-1.0,),
    "diffuse_irradiance": (-1.0,),
    "sky_irradiance": (-1.0,),
    "air_temperature": (-1.0, 0.0),
    "solar_elevation": (-91.0, 90.5),
    "solar_azimuth": (400.0,),
    "aureole_share": (-0.1, 1.1),
    "sun_elevation": (-91.0, 90.5),
    "sun_azimuth": (2000.0,),
    "sun_distance": (0.0, 1.2),
    "moon_elevation": (-91.0, 90.5),
    "moon_azimuth": (-2000.0,),
    "moon_distance": (0.0, 5e5),
    "moon_phase_angle": (-1.0, 181.0),
    "moon_illuminated_fraction": (-0.1, 1.1),
}
SHAPED = ("response_kernel", "moon_distance")  # one of each part stands for the others
MAY_BE_ABSENT = ("film_heat_loss",)  # without it a file is a sound one of a dry day
RULED = ("lag", "response_hour", "track_time")


def refused() -> Iterator[tuple[str, Edit]]:
    """Name and change of the good file; every reader must refuse all of them."""
    for part in (_missing, _values, _axes, _rules, _arrays):
        yield from part()


def _missing() -> Iterator[tuple[str, Edit]]:
    for name in (*OUTSIDE, *AXES):
        if name not in MAY_BE_ABSENT:
            yield f"without-{name}", lambda file, n=name: file.pop(n)


def _values() -> Iterator[tuple[str, Edit]]:
    for name, outside in OUTSIDE.items():
        for value in (np.nan, np.inf, *outside):
            yield f"{name}-of-{value:g}", lambda file, n=name, v=value: _fill(file, n, v)


def _fill(file: h5py.File, name: str, value: float) -> None:
    """All values of an array, so that no reader passes the wrong one by."""
    file[name][...] = np.full(file[name].shape, value)


def _axes() -> Iterator[tuple[str, Edit]]:
    nodes: dict[str, Callable[[np.ndarray], Any]] = {
        "short": lambda n: n[:1],
        "long": lambda n: np.append(n, n[-1:] + 1),
        "descending": lambda n: n[::-1],
        "empty": lambda n: n[:0],
        "in-two-dimensions": lambda n: n[np.newaxis],
    }
    for name in AXES:
        for word, of in nodes.items():
            yield f"{name}-{word}", lambda f, a=name, of=of: change.replace(f, a, of(f[a][()]))


def _rules() -> Iterator[tuple[str, Edit]]:
    words: dict[str, Any] = {"unknown": "cubic", "a-number": 3, "null": h5py.Empty(h5py.string_dtype())}
    for name in RULED:
        for word, value in words.items():
            yield f"{name}-interpolation-{word}", _attribute(name, "interpolation", value)
        yield f"{name}-out_of_range-unknown", _attribute(name, "out_of_range", "extrapolate")
    for name in ("response_hour", "forcing_time"):
        yield f"{name}-period-of-another", _attribute(name, "period", 360.0)


def _attribute(name: str, key: str, value: Any) -> Edit:
    return lambda file: change.set_attribute(file, name, key, value)


def _arrays() -> Iterator[tuple[str, Edit]]:
    shapes: dict[str, Callable[[np.ndarray], Any]] = {
        "as-doubles": lambda v: v.astype(np.float64),
        "as-integers": lambda v: v.astype(np.int32),
        "with-an-axis-more": lambda v: v[..., np.newaxis],
        "cut": lambda v: v[..., :1],
        "empty": lambda v: v[..., :0],
        "without-space": lambda v: h5py.Empty("f4"),
    }
    for name in SHAPED:
        for word, of in shapes.items():
            yield f"{name}-{word}", lambda f, a=name, of=of: change.replace(f, a, of(f[a][()]))
        yield f"{name}-in-another-file", lambda f, a=name: change.as_external_link(f, a)
        yield f"{name}-kept-elsewhere", lambda f, a=name: change.as_external(f, a)
        yield f"{name}-without-scales", lambda f, a=name: f[a].attrs.pop("DIMENSION_LIST")
