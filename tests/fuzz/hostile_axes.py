"""Files whose axes, rules of interpolation or dimension scales are not those of the format."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import h5py
import hdf5_changes as change
import numpy as np
from hostile_cases import AXES, INNER, REFUSE, Case, edited


def cases() -> Iterator[Case]:
    """The cases of this subject; names are unique."""
    for part in (_axes, _rules, _scales):
        yield from part()


def _axes() -> Iterator[Case]:
    for kind, axes in AXES.items():
        for name in axes:
            for word, nodes in (("short", lambda n: n[:1]), ("long", lambda n: np.append(n, n[-1:] + 1))):
                yield edited(kind, f"{name}-{word}", REFUSE, lambda f, a=name, of=nodes: _renode(f, a, of(f[a][()])))
        name = INNER[kind]
        changed: dict[str, Callable[[np.ndarray], Any]] = {
            "descending": lambda n: n[::-1],
            "duplicate-nodes": lambda n: np.concatenate([n[:1], n[:-1]]),
            "unordered-nodes": lambda n: np.concatenate([n[:1], n[2:3], n[1:2], n[3:]]),
            "nan-node": lambda n: np.concatenate([n[:1], [np.nan], n[2:]]),
            "inf-node": lambda n: np.concatenate([n[:-1], [np.inf]]),
            "no-nodes": lambda n: n[:0],
            "two-nodes": lambda n: n[:2],
            "in-two-dimensions": lambda n: n[np.newaxis],
            "a-scalar": lambda n: n[0],
            "of-text": lambda n: np.array([str(node) for node in n], object),
            "of-short-integers": lambda n: np.arange(n.size, dtype=np.int8),
            "without-space": lambda n: h5py.Empty("f8"),
        }
        for word, nodes in changed.items():
            yield edited(kind, f"axis-{word}", REFUSE, lambda f, a=name, of=nodes: _renode(f, a, of(f[a][()])))
    codes = {
        "negative": np.array([-5, 7], np.int32),
        "zero": np.array([0, 7], np.int32),
        "huge": np.array([7, 2**31 - 1], np.int32),
        "in-64-bits": np.array([7, 2**40], np.int64),
        "fractional": np.array([7.5, 8.5]),
        "unsorted": np.array([9, 8], np.int32),
        "duplicate": np.array([9, 9], np.int32),
    }
    for kind in ("surface", "band"):
        for word, nodes in codes.items():
            yield edited(kind, f"codes-{word}", REFUSE, lambda file, nodes=nodes: _renode(file, "material", nodes))
    yield edited("surface", "nodes-beyond-the-period", REFUSE, lambda f: _renode(f, "azimuth", np.arange(4) * 180.0))
    yield edited("surface", "nodes-close-the-period", REFUSE, lambda f: _renode(f, "azimuth", np.arange(4) * 120.0))


def _renode(file: h5py.File, name: str, nodes: Any) -> None:
    if isinstance(nodes, np.ndarray) and nodes.dtype == object:
        change.replace(file, name, nodes, dtype=h5py.string_dtype())
    else:
        change.replace(file, name, nodes)


def _rules() -> Iterator[Case]:
    words: dict[str, Any] = {
        "unknown": "cubic",
        "a-number": 3,
        "an-array": ["linear"] * 200,
        "empty": "",
        "null": h5py.Empty(h5py.string_dtype()),
        "long": "linear" + "r" * 30_000,
    }
    for kind, name in INNER.items():
        for word, value in words.items():
            yield _attribute(kind, f"interpolation-{word}", name, "interpolation", value)
        yield edited(kind, "interpolation-missing", REFUSE, lambda f, a=name: f[a].attrs.pop("interpolation"))
        yield _attribute(kind, "out_of_range-unknown", name, "out_of_range", "extrapolate")
    yield _attribute("surface", "out_of_range-a-number", "time", "out_of_range", 1)
    yield _attribute("surface", "out_of_range-an-array", "time", "out_of_range", ["clamp"] * 500)
    periods: dict[str, Any] = {
        "zero": 0.0,
        "negative": -360.0,
        "nan": np.nan,
        "inf": np.inf,
        "too-short": 90.0,
        "of-another-angle": 720.0,
        "a-text": "360",
        "an-array-of-3": np.full(3, 360.0),
        "an-array-of-5000": np.full(5000, 360.0),
        "without-value": h5py.Empty("f8"),
    }
    for word, value in periods.items():
        yield _attribute("surface", f"period-{word}", "azimuth", "period", value)
    yield edited("surface", "period-missing", REFUSE, lambda f: f["azimuth"].attrs.pop("period"))
    for count in (0, 300):
        yield edited(
            "atmosphere",
            f"interpolation-not-UTF-8-{count}",
            REFUSE,
            lambda f, n=count: change.set_fixed_text(f, "share", "interpolation", change.UNREADABLE_TEXT, n),
        )
    yield _attribute("surface", "codes-interpolated", "material", "interpolation", "linear")
    yield _attribute("band", "codes-interpolated", "material", "interpolation", "linear")
    yield edited("surface", "altitude-periodic", REFUSE, lambda f: _periodic(f, "altitude"))


def _attribute(kind: str, word: str, name: str, key: str, value: Any) -> Case:
    return edited(kind, f"{name}-{word}", REFUSE, lambda file: change.set_attribute(file, name, key, value))


def _periodic(file: h5py.File, name: str) -> None:
    file[name].attrs["interpolation"], file[name].attrs["period"] = "linear_periodic", 2.0


def _scales() -> Iterator[Case]:
    temperature = list(AXES["surface"])
    swapped = ["material", "slope", "azimuth", "altitude", "time"]
    lines = ["share", "height_root", "direction"]
    yield edited("surface", "scales-swapped", REFUSE, lambda f: _rescale(f, "temperature", swapped))
    yield edited("atmosphere", "scales-reversed", REFUSE, lambda f: _rescale(f, "thermal_ratio", lines[::-1]))
    yield edited("atmosphere", "scale-repeated", REFUSE, lambda f: _rescale(f, "thermal_ratio", ["share"] * 3))
    yield edited("surface", "scale-lacking", REFUSE, lambda f: _rescale(f, "temperature", [*temperature[:4], ""]))
    yield edited("band", "scales-lacking", REFUSE, lambda f: f["reflectance"].attrs.pop("DIMENSION_LIST"))
    values = {"of-numbers": np.arange(9), "a-number": 5.0, "a-text": "share", "null": h5py.Empty("i4")}
    for word, value in values.items():
        yield edited(
            "atmosphere",
            f"scales-{word}",
            REFUSE,
            lambda f, value=value: change.flatten_dimension_list(f, "thermal_ratio", value),
        )
    yield edited("atmosphere", "scales-of-another-array", REFUSE, _fewer_scales)
    yield edited("surface", "scale-gone", REFUSE, _dangling_scale)


def _rescale(file: h5py.File, name: str, scales: list[str]) -> None:
    change.replace(file, name, file[name][()], scales=scales)


def _fewer_scales(file: h5py.File) -> None:
    """Three lists of references for an array of four axes."""
    few = file["thermal_ratio"].attrs["DIMENSION_LIST"]
    kind = file["thermal_ratio"].attrs.get_id("DIMENSION_LIST").dtype
    attributes = file["log_mean_extinction"].attrs
    del attributes["DIMENSION_LIST"]
    attributes.create("DIMENSION_LIST", few, dtype=kind)


def _dangling_scale(file: h5py.File) -> None:
    """The array refers to an axis that is gone; another has its name."""
    nodes, attributes = file["slope"][()], dict(file["slope"].attrs)
    del file["slope"]
    file["slope"] = nodes
    for key in ("interpolation", "out_of_range", "units", "long_name"):
        file["slope"].attrs[key] = attributes[key]
    file["slope"].make_scale("slope")
