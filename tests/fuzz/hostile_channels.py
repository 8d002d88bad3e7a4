"""Bad and unusual atmospheres in channels, of format 3."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import h5py
import hdf5_changes as change
import numpy as np
from good_databases import CHANNELS
from hostile_cases import EITHER, EQUAL, REFUSE, Case, edited, on_path

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
    "scattered_ratio": (-1.0,),
    "source_factor": (),
    "source_rise": (-91.0, 95.0),
    "direct_light": (),
    "thermal_sky_factor": (),
    "scattered_harmonics": (),
    "ground_emission": (-1.0,),
}
AXES = (
    *("share", "height_root", "direction", "channel", "absorber", "source_part", "source_elevation"),
    *("scattering_angle", "surface_height", "target_height", "sky_source_elevation", "elevation_above_rise"),
    *("direct_light_part", "scattered_harmonics_part", "harmonic", "zonal_harmonic", "ground_temperature"),
)
SHAPED = ("log_mean_extinction", "end_rise", "absorber_factor", "effective_radius", "ground_emission")


def cases() -> Iterator[Case]:
    """The cases of this subject; names are unique."""
    for part in (_attributes, _missing, _values, _axes, _arrays, _storage, _unusual):
        yield from part()


def _refused(name: str, edit: Callable[[h5py.File], object]) -> Case:
    return edited(CHANNELS, name, REFUSE, edit)


def _attributes() -> Iterator[Case]:
    no_number = {"a-text": "high", "nan": np.nan, "without-value": h5py.Empty("f8"), "three": [1.0, 2.0, 3.0]}
    values: dict[str, dict[str, Any]] = {
        "layout": {
            "classic": "classic",
            "a-number": 3,
            "empty": "",
            "long": "channels" * 5000,
            "two": ["channels"] * 2,
        },
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
    for version in ("2.3.0", "4.0.0", "30.0.0"):
        yield _refused(f"version-{version}", lambda f, v=version: change.set_attribute(f, "/", "format_version", v))
    for word, value in {"missing": None, "nan": np.nan, "a-text": "night", "above-the-horizon": 5.0}.items():
        yield _refused(f"dark_below-{word}", lambda f, v=value: _dark(f, v))
    for name in ("ground_emissivity", "ground_temperature", "ground_radiance"):
        yield _refused(f"without-stated-{name}", lambda file, n=name: file.attrs.pop(n))
    yield edited("atmosphere", "layout-of-channels", REFUSE, _claims_channels)


def _dark(file: h5py.File, value: Any) -> None:
    if value is None:
        del file["source_elevation"].attrs["dark_below"]
    else:
        change.set_attribute(file, "source_elevation", "dark_below", value)


def _claims_channels(file: h5py.File) -> None:
    """A file of format 2 with the attributes of format 3."""
    stated = {"layout": "channels", "ground_altitude_km": 0.0, "scale_height_km": 12.0}
    for key, value in (
        stated | {"range_km": [0.0, 20.0], "altitude_km": [0.0, 1.0], "format_version": "3.0.0"}
    ).items():
        change.set_attribute(file, "/", key, value)


def _missing() -> Iterator[Case]:
    for name in (*OUTSIDE.keys() - {"end_rise"}, *AXES):  # which only bent paths need
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
        "long": lambda n: np.append(n, n[-1:] + 1),
        "descending": lambda n: n[::-1],
        "empty": lambda n: n[:0],
        "in-two-dimensions": lambda n: n[np.newaxis],
    }
    for name in AXES:
        yield _refused(f"{name}-short", lambda f, a=name: change.replace(f, a, f[a][()][:1]))
    for name in ("direction", "channel", "absorber"):
        for word, of in nodes.items():
            yield _refused(f"{name}-{word}", lambda f, a=name, of=of: change.replace(f, a, of(f[a][()])))
    for name, value in (("share", "exact"), ("channel", "linear"), ("direction", "cubic"), ("absorber", 3)):
        yield _refused(
            f"{name}-ruled-{value}", lambda f, a=name, v=value: change.set_attribute(f, a, "interpolation", v)
        )
    yield _refused("share-periodic", lambda f: change.set_attribute(f, "share", "period", 1.0))
    yield _refused("channels-from-zero", lambda f: change.replace(f, "channel", f["channel"][()] - 1))
    yield _refused("harmonics-of-others", lambda f: change.replace(f, "harmonic", f["harmonic"][()] + 1))


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


def _storage() -> Iterator[Case]:
    name = "log_mean_extinction"
    yield _refused("virtual", lambda f: change.as_virtual(f, name, own=False))
    yield _refused("external-values", lambda f: change.as_external(f, name))
    yield _refused("link-into-another-file", lambda f: change.as_external_link(f, name))
    yield _refused("group-for-an-array", lambda f: (f.pop(name), f.create_group(name)))
    yield _refused("chunk-damaged", lambda f: change.damaged_chunk(f, name))
    yield _refused("shape-huge", lambda f: change.replace(f, name, shape=(1 << 60,), dtype="f4", chunks=(1024,)))
    for share in (0.02, 0.4, 0.97):
        yield on_path(CHANNELS, f"truncated-{share}", REFUSE, lambda path, share=share: change.truncate(path, share))


def _unusual() -> Iterator[Case]:
    name = "log_mean_extinction"
    edits: dict[str, Callable[[h5py.File], object]] = {
        "big-endian-values": lambda f: change.replace(f, name, f[name][()].astype(">f4")),
        "big-endian-axis": lambda f: change.replace(f, "share", f["share"][()].astype(">f8")),
        "contiguous": lambda f: change.replace(f, name, f[name][()]),
        "more-attributes": lambda f: change.more_attributes(f, name),
        "newer-minor": lambda f: f.attrs.__setitem__("format_version", "3.9.3"),
        "policy-left-out": lambda f: f["share"].attrs.pop("out_of_range"),
        "codes-not-in-line": lambda f: change.replace(f, "channel", f["channel"][()] * 7),
    }
    for word, edit in edits.items():
        yield edited(CHANNELS, word, EQUAL, edit)
    yield edited(CHANNELS, "web-of-links", EITHER, change.linked_web)
    yield on_path(CHANNELS, "behind-a-user-block", EQUAL, change.with_user_block)
    yield on_path(CHANNELS, "in-the-format-of-HDF5-1.6", EQUAL, change.in_old_format)
