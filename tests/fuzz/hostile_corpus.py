"""Bad and unusual database files, each with a name and with what a loader must do with it.

Usage: python tests/fuzz/hostile_corpus.py FOLDER

writes them all, in folders named by what a loader must do: ``refuse``; ``equal``, read as the original; ``either``, for
faults in parts that a runtime need not read, one of the two; ``unjudged``, anything, where HDF5 itself reads beyond its
memory (up to 2.0.0; mended by pull request 6184 of HDFGroup/hdf5). Every case is a function of a good file, so that the
corpus is the same each time.
"""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import hdf5_changes as change
import hostile_parts
from good_databases import write_all

REFUSE, EQUAL, EITHER, UNJUDGED = VERDICTS = "refuse", "equal", "either", "unjudged"
AXES = {
    "surface": ("material", "altitude", "azimuth", "slope", "time"),
    "band": ("material", "temperature"),
    "atmosphere": ("range", "altitude", "elevation", "source_elevation", "source_azimuth"),
}
PROPERTIES = ("reflectance", "specular_fraction", "shininess", "normalisation")
ARRAYS = {
    "surface": ("temperature",),
    "band": ("blackbody_radiance", *PROPERTIES),
    "atmosphere": ("beta_star", "path_radiance_ratio", "ambient_radiance", "direct_radiance"),
}
MAIN = {"surface": "temperature", "band": "blackbody_radiance", "atmosphere": "path_radiance_ratio"}
PERIODIC = {"surface": "azimuth", "atmosphere": "source_azimuth"}
INNER = {"surface": "time", "band": "temperature", "atmosphere": "elevation"}  # an axis of three nodes or more
HUGE = 1 << 60
# Faults in parts of a texture that no pixel asks for.
NOT_OF_PIXELS = {
    "texture-without-materials-name",
    "texture-without-levels-0-confidence",
    "texture-nan-confidence",
    "texture-names-fewer-than-codes",
}


@dataclass(frozen=True)
class Case:
    """One file of the corpus.

    Attributes
    ----------
    name : str
    kind : str
        Of the good file: surface, band, atmosphere or texture.
    verdict : str
        One of `VERDICTS`.
    mutate : callable
        Changes a copy of the good file.
    """

    name: str
    kind: str
    verdict: str
    mutate: Callable[[Path], object]

    def is_met_by(self, found: str, whole: bool = True) -> bool:
        """Whether a loader did what it must, by what `runtime_loaders.judge` says; `whole` if it reads all of the
        file.
        """
        met = {REFUSE: ("refused",), EQUAL: ("equal",), EITHER: ("refused", "equal")}
        verdict = self.verdict if whole or self.name not in NOT_OF_PIXELS else EITHER
        return verdict == UNJUDGED or found in met[verdict]

    def write(self, good: dict[str, Path], folder: Path) -> Path:
        """Write the file; good files are given by kind."""
        path = folder / f"{self.name}{''.join(good[self.kind].suffixes)}"
        shutil.copyfile(good[self.kind], path)
        self.mutate(path)
        return path


def cases() -> list[Case]:
    """The whole corpus; names are unique."""
    parts = (_bytes, _headers, _missing, _values, _axes, _rules, _arrays, _scales, _names, _storage, _links, _harmless)
    optional = [_case(kind, name, REFUSE, edit) for kind, name, edit in hostile_parts.refused()]
    return [case for part in parts for case in part()] + optional + list(_textures())


def _case(kind: str, name: str, verdict: str, edit: Callable[[h5py.File], object]) -> Case:
    def mutate(path: Path) -> None:
        with h5py.File(path, "r+") as file:
            edit(file)

    return Case(f"{kind}-{name}", kind, verdict, mutate)


def _on_path(kind: str, name: str, verdict: str, mutate: Callable[[Path], object]) -> Case:
    return Case(f"{kind}-{name}", kind, verdict, mutate)


def _bytes() -> Iterator[Case]:
    for kind in ARRAYS:
        for share in (0.02, 0.4, 0.97):
            yield _on_path(kind, f"truncated-{share}", REFUSE, lambda path, share=share: change.truncate(path, share))
    yield _on_path("surface", "empty-file", REFUSE, lambda path: path.write_bytes(b""))
    yield _on_path("surface", "text-file", REFUSE, lambda path: path.write_text("filetype: htt\n"))
    yield _on_path("surface", "signature-alone", REFUSE, lambda path: path.write_bytes(path.read_bytes()[:8]))
    yield _on_path("band", "folder", REFUSE, lambda path: (path.unlink(), path.mkdir()))
    yield _on_path("band", "absent", REFUSE, lambda path: path.unlink())
    yield _on_path("band", "pipe", REFUSE, lambda path: (path.unlink(), os.mkfifo(path)))
    yield _on_path("atmosphere", "zeros", REFUSE, lambda path: path.write_bytes(bytes(path.stat().st_size)))


def _headers() -> Iterator[Case]:
    for kind in ARRAYS:
        for key in ("filetype", "format_version"):
            yield _case(kind, f"without-{key}", REFUSE, lambda file, key=key: file.attrs.pop(key))
    for name, value in {
        "of-the-next-major": "3.0.0",
        "of-a-far-major": "20.0.0",
        "empty": "",
        "a-number": 2,
        "an-array-of-texts": ["2.0.0"] * 300,
        "without-value": h5py.Empty("S5"),
        "long": "2.0.0" + "0" * 40_000,
    }.items():
        verdict = EITHER if name == "long" else REFUSE
        yield _case(
            "atmosphere",
            f"version-{name}",
            verdict,
            lambda file, value=value: change.set_attribute(file, "/", "format_version", value),
        )
    for name, value in {
        "of-another": "band",
        "an-array-of-texts": ["htt"] * 400,
        "numbers": np.arange(500.0),
        "long": "h" * 50_000,
        "without-value": h5py.Empty("S3"),
        "null": h5py.Empty(h5py.string_dtype()),
    }.items():
        yield _case(
            "surface",
            f"filetype-{name}",
            REFUSE,
            lambda file, value=value: change.set_attribute(file, "/", "filetype", value),
        )
    for count, name in ((400, "an-array-of-fixed-texts"), (0, "not-UTF-8")):
        text = b"band" if count else change.UNREADABLE_TEXT
        yield _case(
            "band",
            f"filetype-{name}",
            REFUSE,
            lambda file, text=text, count=count: change.set_fixed_text(file, "/", "filetype", text, count),
        )


def _missing() -> Iterator[Case]:
    for kind, arrays in ARRAYS.items():
        for name in (*arrays, *AXES[kind], *(["material_name"] if kind == "band" else [])):
            yield _case(kind, f"without-{name}", REFUSE, lambda file, name=name: file.pop(name))


def _values() -> Iterator[Case]:
    for kind, arrays in ARRAYS.items():
        for name in arrays:
            for word, value in (("nan", np.nan), ("inf", np.inf), ("negative", -1.0)):
                if word != "inf" or name == MAIN[kind]:
                    yield _case(kind, f"{word}-in-{name}", REFUSE, lambda file, n=name, v=value: _set(file, n, v))
    yield _case("surface", "absolute-zero", REFUSE, lambda file: _set(file, "temperature", 0.0))
    yield _case("atmosphere", "zero-beta_star", REFUSE, lambda file: _set(file, "beta_star", 0.0))
    for name in PROPERTIES[:2]:
        yield _case("band", f"{name}-above-1", REFUSE, lambda file, name=name: _set(file, name, 1.5))
    for kind, name in (("surface", "temperature"), ("atmosphere", "beta_star")):
        yield _case(kind, f"{name}-unwritten", REFUSE, lambda file, name=name: _unwritten(file, name))


def _set(file: h5py.File, name: str, value: float) -> None:
    """One value of an array, in the midst of it."""
    values = file[name][()]
    values.flat[values.size // 2] = value
    file[name][...] = values


def _unwritten(file: h5py.File, name: str) -> None:
    values = file[name]
    change.replace(file, name, shape=values.shape, dtype=values.dtype, chunks=values.shape)


def _axes() -> Iterator[Case]:
    for kind, axes in AXES.items():
        for name in axes:
            for word, nodes in (("short", lambda n: n[:1]), ("long", lambda n: np.append(n, n[-1:] + 1))):
                yield _case(kind, f"{name}-{word}", REFUSE, lambda f, a=name, of=nodes: _renode(f, a, of(f[a][()])))
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
            yield _case(kind, f"axis-{word}", REFUSE, lambda f, a=name, of=nodes: _renode(f, a, of(f[a][()])))
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
            yield _case(kind, f"codes-{word}", REFUSE, lambda file, nodes=nodes: _renode(file, "material", nodes))
    yield _case("surface", "nodes-beyond-the-period", REFUSE, lambda f: _renode(f, "azimuth", np.arange(4) * 180.0))
    yield _case("surface", "nodes-close-the-period", REFUSE, lambda f: _renode(f, "azimuth", np.arange(4) * 120.0))
    yield _case(
        "atmosphere", "nodes-beyond-the-fold", REFUSE, lambda f: _renode(f, "source_azimuth", np.arange(3) * 120.0)
    )
    yield _case(
        "atmosphere", "nodes-below-the-fold", REFUSE, lambda f: _renode(f, "source_azimuth", np.arange(3) * 90.0 - 90)
    )


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
        yield _case(kind, "interpolation-missing", REFUSE, lambda f, a=name: f[a].attrs.pop("interpolation"))
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
    for kind, name in PERIODIC.items():
        for word, value in periods.items():
            yield _attribute(kind, f"period-{word}", name, "period", value)
        yield _case(kind, "period-missing", REFUSE, lambda f, a=name: f[a].attrs.pop("period"))
    for count in (0, 300):
        yield _case(
            "atmosphere",
            f"interpolation-not-UTF-8-{count}",
            REFUSE,
            lambda f, n=count: change.set_fixed_text(f, "range", "interpolation", change.UNREADABLE_TEXT, n),
        )
    yield _attribute("surface", "codes-interpolated", "material", "interpolation", "linear")
    yield _attribute("band", "codes-interpolated", "material", "interpolation", "linear")
    yield _case("surface", "altitude-periodic", REFUSE, lambda f: _periodic(f, "altitude"))


def _attribute(kind: str, word: str, name: str, key: str, value: Any) -> Case:
    return _case(kind, f"{name}-{word}", REFUSE, lambda file: change.set_attribute(file, name, key, value))


def _periodic(file: h5py.File, name: str) -> None:
    file[name].attrs["interpolation"], file[name].attrs["period"] = "linear_periodic", 2.0


def _arrays() -> Iterator[Case]:
    pair = np.dtype([("a", "f4"), ("b", "f4")])
    kinds: dict[str, Callable[[np.ndarray], Any]] = {
        "as-integers": lambda v: v.astype(np.int32),
        "as-doubles": lambda v: v.astype(np.float64),
        "as-halves": lambda v: v.astype(np.float16),
        "as-truths": lambda v: v > 0,
        "as-pairs": lambda v: np.zeros(v.shape, pair),
        "as-complex-numbers": lambda v: v.astype(np.complex64),
        "flat": lambda v: v.ravel() if v.ndim > 1 else v.reshape(v.size // 37, 37),
        "transposed": lambda v: v.T if v.ndim > 1 else v[np.newaxis],
        "with-an-axis-more": lambda v: v[..., np.newaxis],
        "a-scalar": lambda v: np.float32(280),
        "empty": lambda v: v[..., :0],
        "without-space": lambda v: h5py.Empty("f4"),
        "in-32-dimensions": lambda v: np.full((1,) * 32, 280, np.float32),
    }
    for kind, name in MAIN.items():
        for word, of in kinds.items():
            if word == "transposed" and kind == "atmosphere":
                continue  # all its axes are of one length: nothing shows
            yield _case(kind, f"array-{word}", REFUSE, lambda f, a=name, of=of: change.replace(f, a, of(f[a][()])))
        yield _case(kind, "array-of-text", REFUSE, lambda f, a=name: _as_text(f, a))
    for name in ("reflectance", "shininess"):
        yield _case("band", f"{name}-long", REFUSE, lambda f, a=name: change.replace(f, a, np.zeros(40, np.float32)))


def _as_text(file: h5py.File, name: str) -> None:
    values = np.full(file[name].shape, "280", object)
    change.replace(file, name, values, dtype=h5py.string_dtype())


def _scales() -> Iterator[Case]:
    temperature = list(AXES["surface"])
    swapped = ["material", "slope", "azimuth", "altitude", "time"]
    path = list(AXES["atmosphere"])
    yield _case("surface", "scales-swapped", REFUSE, lambda f: _rescale(f, "temperature", swapped))
    yield _case("atmosphere", "scales-reversed", REFUSE, lambda f: _rescale(f, "path_radiance_ratio", path[::-1]))
    yield _case("atmosphere", "scale-repeated", REFUSE, lambda f: _rescale(f, "beta_star", ["range"] * 3))
    yield _case("surface", "scale-lacking", REFUSE, lambda f: _rescale(f, "temperature", [*temperature[:4], ""]))
    yield _case("band", "scales-lacking", REFUSE, lambda f: f["reflectance"].attrs.pop("DIMENSION_LIST"))
    values = {"of-numbers": np.arange(9), "a-number": 5.0, "a-text": "range", "null": h5py.Empty("i4")}
    for word, value in values.items():
        yield _case(
            "atmosphere",
            f"scales-{word}",
            REFUSE,
            lambda f, value=value: change.flatten_dimension_list(f, "beta_star", value),
        )
    yield _case("atmosphere", "scales-of-another-array", REFUSE, _fewer_scales)
    yield _case("surface", "scale-gone", REFUSE, _dangling_scale)


def _rescale(file: h5py.File, name: str, scales: list[str]) -> None:
    change.replace(file, name, file[name][()], scales=scales)


def _fewer_scales(file: h5py.File) -> None:
    """Three lists of references for an array of five axes."""
    few = file["beta_star"].attrs["DIMENSION_LIST"]
    kind = file["beta_star"].attrs.get_id("DIMENSION_LIST").dtype
    attributes = file["path_radiance_ratio"].attrs
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


def _names() -> Iterator[Case]:
    text = h5py.string_dtype()
    lists: dict[str, Any] = {
        "more-than-codes": [*(f"other_{k}" for k in range(500)), "asphalt_road", "grass_green"],
        "fewer-than-codes": ["asphalt_road"],
        "none": np.array([], object),
    }
    for word, value in lists.items():
        yield _case(
            "band", f"names-{word}", REFUSE, lambda f, v=value: change.replace(f, "material_name", v, dtype=text)
        )
    yield _case("band", "names-of-numbers", REFUSE, lambda f: change.replace(f, "material_name", np.arange(2.0)))
    yield _case("band", "names-not-UTF-8", REFUSE, lambda f: _raw_names(f, [change.UNREADABLE_TEXT] * 2))
    yield _case("band", "names-null", REFUSE, lambda f: change.replace(f, "material_name", shape=(2,), dtype=text))
    yield _case("band", "names-twice-the-same", REFUSE, lambda f: _raw_names(f, [b"grass_green"] * 2))
    yield _case("band", "name-of-a-megabyte", EITHER, lambda f: _raw_names(f, [b"asphalt_road", b"g" * 1_000_000]))
    yield _case("band", "names-without-space", REFUSE, lambda f: change.replace(f, "material_name", h5py.Empty(text)))


def _raw_names(file: h5py.File, names: list[bytes]) -> None:
    change.replace(file, "material_name", np.array(names, object), dtype=h5py.string_dtype())


def _storage() -> Iterator[Case]:
    for kind, name in MAIN.items():
        yield _case(kind, "virtual", REFUSE, lambda f, a=name: change.as_virtual(f, a, own=False))
        yield _case(kind, "virtual-of-itself", REFUSE, lambda f, a=name: change.as_virtual(f, a, own=True))
        yield _case(kind, "external-values", REFUSE, lambda f, a=name: change.as_external(f, a))
        yield _case(kind, "filter-unknown", REFUSE, lambda f, a=name: change.with_filter(f, a, claimed=True))
        yield _case(kind, "filter-skipped", EITHER, lambda f, a=name: change.with_filter(f, a, claimed=False))
        yield _case(kind, "chunk-damaged", REFUSE, lambda f, a=name: change.damaged_chunk(f, a))
        yield _case(kind, "chunk-short", UNJUDGED, lambda f, a=name: change.short_chunk(f, a))
        yield _case(kind, "shape-huge", REFUSE, lambda f, a=name: _huge(f, a, (HUGE,)))
        yield _case(kind, "shape-overflowing", REFUSE, lambda f, a=name: _huge(f, a, (1 << 32, 1 << 31)))
        yield _case(kind, "axis-huge", REFUSE, lambda f, a=INNER[kind]: _huge(f, a, (1 << 40,)))
    yield _case("band", "both-huge", REFUSE, _huge_pair)
    yield _case("band", "names-huge", REFUSE, lambda f: _huge(f, "material_name", (1 << 33,)))
    yield _case("atmosphere", "external-axis", REFUSE, lambda f: change.as_external(f, "range"))
    yield _case("atmosphere", "virtual-axis", REFUSE, lambda f: change.as_virtual(f, "range", own=True))


def _huge(file: h5py.File, name: str, shape: tuple[int, ...]) -> None:
    kind, chunk = file[name].dtype, (1,) * (len(shape) - 1) + (1024,)
    change.replace(file, name, shape=shape, dtype=kind, chunks=chunk)


def _huge_pair(file: h5py.File) -> None:
    """An axis and its array that agree, of 32 GiB together, never written."""
    for name in ("temperature", "blackbody_radiance"):
        change.replace(file, name, shape=(1 << 32,), dtype=file[name].dtype, chunks=(1 << 16,))


def _links() -> Iterator[Case]:
    for kind, name in MAIN.items():
        yield _case(kind, "link-into-another-file", REFUSE, lambda f, a=name: change.as_external_link(f, a))
        yield _case(kind, "link-to-nothing", REFUSE, lambda f, a=name: _soft(f, a, "/nothing"))
        yield _case(kind, "link-to-itself", REFUSE, lambda f, a=name: _soft(f, a, f"/{a}"))
        yield _case(kind, "group-for-an-array", REFUSE, lambda f, a=name: (f.pop(a), f.create_group(a)))
        yield _case(kind, "type-for-an-array", REFUSE, lambda f, a=name: (f.pop(a), f.__setitem__(a, np.dtype("f4"))))
        yield _case(kind, "cycle-of-links", EITHER, lambda f: f.create_group("loop").__setitem__("root", f["/"]))
        yield _case(kind, "web-of-links", EITHER, change.linked_web)
        yield _case(kind, "groups-without-end", EITHER, change.deep_groups)
    yield _case("band", "array-for-another", REFUSE, lambda f: _soft(f, "reflectance", "/blackbody_radiance"))
    yield _case("atmosphere", "own-axis-short", EITHER, lambda f: _own_axis(f, [0.001, 20.0]))
    yield _case("atmosphere", "own-axis-unused", EITHER, lambda f: _own_axis(f, [0.001, 9.0, 20.0]))
    yield _case("atmosphere", "angle-unused", EITHER, lambda f: f.copy("source_azimuth", "scattering_angle"))


def _soft(file: h5py.File, name: str, target: str) -> None:
    del file[name]
    file[name] = h5py.SoftLink(target)


def _own_axis(file: h5py.File, nodes: list[float]) -> None:
    """An axis named after a quantity that is not attached to it."""
    file["direct_radiance_range"] = np.array(nodes)
    for key in ("interpolation", "out_of_range", "units", "long_name"):
        file["direct_radiance_range"].attrs[key] = file["range"].attrs[key]
    file["direct_radiance_range"].make_scale("direct_radiance_range")


def _harmless() -> Iterator[Case]:
    for kind, name in MAIN.items():
        axis = INNER[kind]
        edits: dict[str, Callable[[h5py.File], object]] = {
            "big-endian-values": lambda f, a=name: change.replace(f, a, f[a][()].astype(">f4")),
            "big-endian-axis": lambda f, a=axis: change.replace(f, a, f[a][()].astype(">f8")),
            "contiguous": lambda f, a=name: change.replace(f, a, f[a][()]),
            "small-chunks": lambda f, a=name: change.replace(f, a, f[a][()], chunks=(1,) * (f[a].ndim - 1) + (2,)),
            "best-compression": lambda f, a=name: change.replace(f, a, f[a][()], compression=9, chunks=True),
            "extensible": lambda f, a=name: change.replace(f, a, f[a][()], maxshape=(None,) * f[a].ndim, chunks=True),
            "more-attributes": lambda f, a=name: _more_attributes(f, a),
            "more-arrays": _more_arrays,
            "fixed-length-rule": lambda f, a=axis: _fixed_rules(f, a),
            "policy-left-out": lambda f, a=axis: f[a].attrs.pop("out_of_range"),
            "newer-minor": lambda f: f.attrs.__setitem__("format_version", f.attrs["format_version"][:2] + "9.3"),
        }
        for word, edit in edits.items():
            yield _case(kind, word, EQUAL, edit)
        yield _case(kind, "more-arrays-without-axes", EITHER, _arrays_without_axes)
        yield _on_path(kind, "behind-a-user-block", EQUAL, change.with_user_block)
        yield _on_path(kind, "in-the-format-of-HDF5-1.6", EQUAL, change.in_old_format)
    yield _case("surface", "period-an-integer", EQUAL, lambda f: change.set_attribute(f, "azimuth", "period", 360))
    yield _case(
        "band", "big-endian-codes", EQUAL, lambda f: change.replace(f, "material", f["material"][()].astype(">i4"))
    )


def _more_attributes(file: h5py.File, name: str) -> None:
    for k in range(40):
        file.attrs[f"note_{k}"] = file[name].attrs[f"note_{k}"] = np.arange(k + 1)


def _more_arrays(file: h5py.File) -> None:
    for place, shape in (("later/values", (3, 4)), ("later_version", (5,))):
        array = file.create_dataset(place, data=np.full(shape, np.nan))
        for k, count in enumerate(shape):
            axis = array.parent.create_dataset(f"later_axis_{k}", data=np.arange(float(count)))
            axis.make_scale(f"later_axis_{k}")
            array.dims[k].attach_scale(axis)


def _arrays_without_axes(file: h5py.File) -> None:
    file.create_dataset("later/values", data=np.full((3, 4), np.nan))
    file.create_dataset("later_version", data=np.arange(5))


def _fixed_rules(file: h5py.File, axis: str) -> None:
    for key in ("interpolation", "out_of_range"):
        change.set_fixed_text(file, axis, key, file[axis].attrs[key].encode())


def _textures() -> Iterator[Case]:
    code, weight, confidence = "levels/0/code", "levels/0/mix_weight", "levels/0/confidence"
    for name in ("materials", "materials/name", "levels", "levels/0", code, weight, confidence):
        yield _case("texture", f"without-{name.replace('/', '-')}", REFUSE, lambda f, n=name: f.pop(n))
    edits: dict[str, Callable[[h5py.File], object]] = {
        "without-filetype": lambda f: f.attrs.pop("filetype"),
        "of-the-next-major": lambda f: f.attrs.__setitem__("format_version", "2.0.0"),
        "nan-confidence": lambda f: _set(f, confidence, np.nan),
        "code-of-no-material": lambda f: _set(f, code, 65535),
        "codes-as-floats": lambda f: _retype(f, code, np.float32),
        "codes-of-another-shape": lambda f: _retype(f, code, np.uint16, slice(0, 3)),
        "weights-that-do-not-sum": lambda f: _set(f, weight, 65534),
        "names-fewer-than-codes": lambda f: _retype(f, "materials/name", object, slice(0, 1)),
        "group-for-an-array": lambda f: (f.pop(code), f.create_group(code)),
        "shape-huge": lambda f: (f.pop(code), f.create_dataset(code, (HUGE,), "u2", chunks=(1024,))),
        "code-in-another-file": lambda f: (f.pop(code), f.__setitem__(code, h5py.ExternalLink("o.h5", "/code"))),
    }
    for name, edit in edits.items():
        yield _case("texture", name, REFUSE, edit)
    yield _on_path("texture", "truncated", REFUSE, lambda path: change.truncate(path, 0.6))
    yield _case("texture", "web-of-links", EITHER, change.linked_web)
    yield _case("texture", "more-attributes", EQUAL, lambda f: _more_attributes(f, code))
    yield _on_path("texture", "behind-a-user-block", EQUAL, change.with_user_block)


def _retype(file: h5py.File, name: str, kind: Any, rows: slice = slice(None)) -> None:
    values = file[name][()][rows]
    del file[name]
    file.create_dataset(name, data=values, dtype=h5py.string_dtype() if kind is object else kind)


def main(folder: Path) -> None:
    good_folder = folder / "good"
    good_folder.mkdir(parents=True)
    good = write_all(good_folder)
    for case in cases():
        target = folder / case.verdict
        target.mkdir(exist_ok=True)
        case.write(good, target)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
