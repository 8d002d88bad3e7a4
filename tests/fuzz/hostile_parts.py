"""Bad files for the parts that a database may hold beside its main arrays: response to shade, harmonics, tables of the
night, tracks of Sun and Moon.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import h5py
import hdf5_changes as change
import numpy as np

Edit = Callable[[h5py.File], object]
RESPONSE = ("response_altitude", "response_slope", "response_hour")
AXES = {
    "surface": (*RESPONSE, "lag", "temperature_offset", "forcing_time", "track_time"),
    "atmosphere": ("harmonic", "zonal_harmonic", "ground_temperature"),
}
# Arrays of each part, with values that they may not hold.
OUTSIDE: dict[str, dict[str, tuple[float, ...]]] = {
    "surface": {
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
        "extraterrestrial_irradiance": (-1.0, 0.0),
        "sun_elevation": (-91.0, 90.5),
        "sun_azimuth": (2000.0,),
        "sun_distance": (0.0, 1.2),
        "moon_elevation": (-91.0, 90.5),
        "moon_azimuth": (-2000.0,),
        "moon_distance": (0.0, 5e5),
        "moon_phase_angle": (-1.0, 181.0),
        "moon_illuminated_fraction": (-0.1, 1.1),
    },
    "atmosphere": {
        "ambient_radiance_harmonics": (),
        "ground_radiance_harmonics": (),
        "thermal_path_radiance_ratio": (-1.0,),
        "thermal_ambient_radiance": (-1.0,),
        "thermal_radiance_harmonics": (),
    },
}
# One of each part stands for the others.
SHAPED = {
    "surface": ("response_kernel", "moon_distance"),
    "atmosphere": ("ambient_radiance_harmonics", "thermal_radiance_harmonics"),
}
# A file without one of these is a sound file of an older version, which gives other answers.
MAY_BE_ABSENT = ("ambient_radiance_harmonics", "film_heat_loss")
RULED = {"surface": ("lag", "response_hour", "track_time"), "atmosphere": ("harmonic", "ground_temperature")}


def refused() -> Iterator[tuple[str, str, Edit]]:
    """Kind of the good file, name and change of each; every reader must refuse all of them."""
    for part in (_missing, _values, _axes, _rules, _arrays, _night, _ground):
        yield from part()


def _missing() -> Iterator[tuple[str, str, Edit]]:
    for kind, arrays in OUTSIDE.items():
        for name in (*arrays, *AXES[kind]):
            if name not in MAY_BE_ABSENT:
                yield kind, f"without-{name}", lambda file, n=name: file.pop(n)


def _values() -> Iterator[tuple[str, str, Edit]]:
    for kind, arrays in OUTSIDE.items():
        for name, outside in arrays.items():
            for value in (np.nan, np.inf, *outside):
                yield kind, f"{name}-of-{value:g}", lambda file, n=name, v=value: _fill(file, n, v)


def _fill(file: h5py.File, name: str, value: float) -> None:
    """All values of an array, so that no reader passes the wrong one by."""
    file[name][...] = np.full(file[name].shape, value)


def _axes() -> Iterator[tuple[str, str, Edit]]:
    nodes: dict[str, Callable[[np.ndarray], Any]] = {
        "short": lambda n: n[:1],
        "long": lambda n: np.append(n, n[-1:] + 1),
        "descending": lambda n: n[::-1],
        "empty": lambda n: n[:0],
        "in-two-dimensions": lambda n: n[np.newaxis],
    }
    for kind, axes in AXES.items():
        for name in axes:
            for word, of in nodes.items():
                yield kind, f"{name}-{word}", lambda f, a=name, of=of: change.replace(f, a, of(f[a][()]))
    for name in ("harmonic", "zonal_harmonic"):
        for word, step in (("of-others", 3), ("doubled", 0)):
            yield "atmosphere", f"{name}-{word}", lambda f, a=name, s=step: _other_codes(f, a, s)


def _other_codes(file: h5py.File, name: str, step: int) -> None:
    codes = file[name][()]
    codes[-1] = codes[-2] + step
    change.replace(file, name, codes)


def _rules() -> Iterator[tuple[str, str, Edit]]:
    words: dict[str, Any] = {"unknown": "cubic", "a-number": 3, "null": h5py.Empty(h5py.string_dtype())}
    for kind, axes in RULED.items():
        for name in axes:
            for word, value in words.items():
                yield (
                    kind,
                    f"{name}-interpolation-{word}",
                    lambda f, a=name, v=value: change.set_attribute(f, a, "interpolation", v),
                )
            yield kind, f"{name}-out_of_range-unknown", _attribute(name, "out_of_range", "extrapolate")
    for name in ("response_hour", "forcing_time"):
        yield "surface", f"{name}-period-of-another", _attribute(name, "period", 360.0)


def _attribute(name: str, key: str, value: Any) -> Edit:
    return lambda file: change.set_attribute(file, name, key, value)


def _arrays() -> Iterator[tuple[str, str, Edit]]:
    shapes: dict[str, Callable[[np.ndarray], Any]] = {
        "as-doubles": lambda v: v.astype(np.float64),
        "as-integers": lambda v: v.astype(np.int32),
        "with-an-axis-more": lambda v: v[..., np.newaxis],
        "cut": lambda v: v[..., :1],
        "empty": lambda v: v[..., :0],
        "without-space": lambda v: h5py.Empty("f4"),
    }
    for kind, names in SHAPED.items():
        for name in names:
            for word, of in shapes.items():
                yield kind, f"{name}-{word}", lambda f, a=name, of=of: change.replace(f, a, of(f[a][()]))
            yield kind, f"{name}-in-another-file", lambda f, a=name: change.as_external_link(f, a)
            yield kind, f"{name}-kept-elsewhere", lambda f, a=name: change.as_external(f, a)
            yield kind, f"{name}-without-scales", lambda f, a=name: f[a].attrs.pop("DIMENSION_LIST")


def _night() -> Iterator[tuple[str, str, Edit]]:
    values: dict[str, Any] = {
        "above-the-horizon": 5.0,
        "below-the-nadir": -91.0,
        "nan": np.nan,
        "a-text": "night",
        "an-array": np.full(3, -20.0),
        "without-value": h5py.Empty("f8"),
    }
    for word, value in values.items():
        yield "atmosphere", f"dark_below-{word}", _attribute("source_elevation", "dark_below", value)
    yield "atmosphere", "dark_below-missing", lambda file: file["source_elevation"].attrs.pop("dark_below")


def _ground() -> Iterator[tuple[str, str, Edit]]:
    for name in ("ground_emissivity", "ground_temperature", "ground_radiance"):
        yield "atmosphere", f"without-stated-{name}", lambda file, n=name: file.attrs.pop(n)
        yield "atmosphere", f"{name}-a-text", _attribute("/", name, "warm")
        yield "atmosphere", f"{name}-nan", _attribute("/", name, np.nan)
        yield "atmosphere", f"{name}-negative", _attribute("/", name, -1.0)
