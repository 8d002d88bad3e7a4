"""Bad and unusual files in what an atmosphere alone holds: its numbers, channels, harmonics and ground."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import h5py
import hdf5_changes as change
import numpy as np
from hostile_cases import ARRAYS, EQUAL, REFUSE, Case, edited
from hostile_cases import AXES as SHARED_AXES

# Arrays with values that they may not hold, and axes.
OUTSIDE: dict[str, tuple[float, ...]] = {
    "effective_radius": (0.0, -6371.0),
    "log_mean_extinction": (-300.0, 300.0),
    "absorber_factor": (),
    "channel_weight": (-0.1, 1.5),
    "thermal_reference": (-1.0,),
    "thermal_ratio": (-1.0,),
    "end_rise": (-1.5, 1.5),
    "source_reference": (-1.0,),
    "scattered_ratio": (),
    "source_factor": (),
    "source_rise": (-91.0, 95.0),
    "direct_light": (),
    "thermal_sky_factor": (),
    "scattered_harmonics": (),
    "ground_emission": (-1.0,),
}
AXES = (  # beside those that another subject has
    *("channel", "absorber", "source_part", "surface_height", "target_height", "sky_source_elevation"),
    *("elevation_above_rise", "direct_light_part", "scattered_harmonics_part"),
    *("harmonic", "zonal_harmonic", "ground_temperature"),
)
GROUND = ("ground_emissivity", "ground_temperature", "ground_radiance")
SHAPED = ("log_mean_extinction", "end_rise", "absorber_factor", "effective_radius", "ground_emission")


def cases() -> Iterator[Case]:
    """The cases of this subject; names are unique."""
    for part in (_attributes, _dark, _ground, _missing, _values, _axes, _arrays):
        yield from part()
    yield edited("atmosphere", "codes-not-in-line", EQUAL, lambda f: change.replace(f, "channel", f["channel"][()] * 7))


def _refused(name: str, edit: Callable[[h5py.File], object]) -> Case:
    return edited("atmosphere", name, REFUSE, edit)


def _attributes() -> Iterator[Case]:
    no_number = {"a-text": "high", "nan": np.nan, "without-value": h5py.Empty("f8"), "three": [1.0, 2.0, 3.0]}
    values: dict[str, dict[str, Any]] = {
        "ground_altitude_km": no_number
        | {"inf": np.inf, "below-the-sea": -5.0, "in-metres": 100.0, "pair": [0.0, 1.0]},
        "scale_height_km": no_number | {"zero": 0.0, "negative": -12.0, "inf": np.inf},
        "range_km": no_number
        | {"one": 5.0, "descending": [20.0, 1.0], "negative": [-1.0, 20.0], "endless": [0, np.inf]},
        "altitude_km": no_number
        | {"one": 5.0, "descending": [1.0, 0.5], "half-nan": [0.0, np.nan], "square": [[0, 1.0]]},
    }
    for key, wrong in values.items():
        yield _refused(f"without-{key}", lambda file, k=key: file.attrs.pop(k))
        for word, value in wrong.items():
            yield _refused(f"{key}-{word}", lambda f, k=key, v=value: change.set_attribute(f, "/", k, v))


def _dark() -> Iterator[Case]:
    values: dict[str, Any] = {
        "above-the-horizon": 5.0,
        "below-the-nadir": -91.0,
        "nan": np.nan,
        "a-text": "night",
        "an-array": np.full(3, -20.0),
        "without-value": h5py.Empty("f8"),
    }
    for word, value in values.items():
        yield _refused(
            f"dark_below-{word}", lambda f, v=value: change.set_attribute(f, "source_elevation", "dark_below", v)
        )
    yield _refused("dark_below-missing", lambda file: file["source_elevation"].attrs.pop("dark_below"))


def _ground() -> Iterator[Case]:
    for name in GROUND:
        yield _refused(f"without-stated-{name}", lambda file, n=name: file.attrs.pop(n))
        for word, value in {"a-text": "warm", "nan": np.nan, "negative": -1.0}.items():
            yield _refused(f"{name}-{word}", lambda f, n=name, v=value: change.set_attribute(f, "/", n, v))


def _missing() -> Iterator[Case]:
    for name in (*OUTSIDE.keys() - {"end_rise", *ARRAYS["atmosphere"]}, *AXES):  # only bent paths need end_rise
        yield _refused(f"without-{name}", lambda file, n=name: file.pop(n))


def _values() -> Iterator[Case]:
    for name, outside in OUTSIDE.items():
        for value in (np.nan, -np.inf, *outside):
            yield _refused(f"{name}-of-{value:g}", lambda f, n=name, v=value: change.set_middle(f, n, v))
    for word, factor in (("heavy", 1.01), ("zero", 0.0)):
        yield _refused(
            f"weights-{word}", lambda f, by=factor: f["channel_weight"].write_direct(f["channel_weight"][()] * by)
        )


def _axes() -> Iterator[Case]:
    nodes: dict[str, Callable[[np.ndarray], Any]] = {
        "descending": lambda n: n[::-1],
        "empty": lambda n: n[:0],
        "in-two-dimensions": lambda n: n[np.newaxis],
    }
    for name in AXES:
        yield _refused(f"{name}-short", lambda f, a=name: change.replace(f, a, f[a][()][:1]))
        yield _refused(f"{name}-long", lambda f, a=name: change.replace(f, a, np.append(f[a][()], f[a][()][-1:] + 1)))
    for name in (*SHARED_AXES["atmosphere"], *AXES):
        for word, of in nodes.items():
            yield _refused(f"{name}-{word}", lambda f, a=name, of=of: change.replace(f, a, of(f[a][()])))
    for name, value in (("share", "exact"), ("channel", "linear"), ("direction", "cubic"), ("absorber", 3)):
        yield _refused(
            f"{name}-ruled-{value}", lambda f, a=name, v=value: change.set_attribute(f, a, "interpolation", v)
        )
    yield _refused("share-periodic", lambda f: change.set_attribute(f, "share", "period", 1.0))
    yield _refused("channels-from-zero", lambda f: change.replace(f, "channel", f["channel"][()] - 1))
    for name in ("harmonic", "zonal_harmonic"):
        for word, step in (("of-others", 3), ("doubled", 0)):
            yield _refused(f"{name}-{word}", lambda f, a=name, s=step: _other_codes(f, a, s))


def _other_codes(file: h5py.File, name: str, step: int) -> None:
    codes = file[name][()]
    codes[-1] = codes[-2] + step
    change.replace(file, name, codes)


def _arrays() -> Iterator[Case]:
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
            yield _refused(f"{name}-{word}", lambda f, a=name, of=of: change.replace(f, a, of(f[a][()])))
        yield _refused(f"{name}-without-scales", lambda f, a=name: f[a].attrs.pop("DIMENSION_LIST"))
    swapped = ["share", "absorber", "height_root", "direction"]
    yield _refused("scales-swapped", lambda f: _rescaled(f, "log_mean_extinction", swapped))
    yield _refused("factors-of-another-axis", lambda f: _rescaled(f, "absorber_factor", ["channel", "source_part"]))
    yield _refused("own-absorbers", _own_absorbers)


def _rescaled(file: h5py.File, name: str, scales: list[str]) -> None:
    change.replace(file, name, file[name][()], scales=scales)


def _own_absorbers(file: h5py.File) -> None:
    """The factors have more absorbers than there are, on an axis named after them."""
    codes = np.arange(1, 41, dtype=np.int32)
    file["absorber_factor_absorber"] = codes
    for key in ("interpolation", "out_of_range", "units", "long_name"):
        file["absorber_factor_absorber"].attrs[key] = file["absorber"].attrs[key]
    file["absorber_factor_absorber"].make_scale("absorber_factor_absorber")
    values = np.ones((file["channel"].size, codes.size), np.float32)
    change.replace(file, "absorber_factor", values, scales=["channel", "absorber_factor_absorber"])
