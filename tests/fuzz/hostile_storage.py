"""Files that are stored, linked or typed as no good file is."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from typing import Any

import h5py
import hdf5_changes as change
import numpy as np
from hostile_cases import ARRAYS, EITHER, HUGE, INNER, MAIN, REFUSE, UNJUDGED, Case, edited, on_path


def cases() -> Iterator[Case]:
    """The cases of this subject; names are unique."""
    for part in (_bytes, _arrays, _storage, _links):
        yield from part()


def _bytes() -> Iterator[Case]:
    for kind in ARRAYS:
        for share in (0.02, 0.4, 0.97):
            yield on_path(kind, f"truncated-{share}", REFUSE, lambda path, share=share: change.truncate(path, share))
    yield on_path("surface", "empty-file", REFUSE, lambda path: path.write_bytes(b""))
    yield on_path("surface", "text-file", REFUSE, lambda path: path.write_text("filetype: htt\n"))
    yield on_path("surface", "signature-alone", REFUSE, lambda path: path.write_bytes(path.read_bytes()[:8]))
    yield on_path("band", "folder", REFUSE, lambda path: (path.unlink(), path.mkdir()))
    yield on_path("band", "absent", REFUSE, lambda path: path.unlink())
    yield on_path("band", "pipe", REFUSE, lambda path: (path.unlink(), os.mkfifo(path)))
    yield on_path("atmosphere", "zeros", REFUSE, lambda path: path.write_bytes(bytes(path.stat().st_size)))


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
            yield edited(kind, f"array-{word}", REFUSE, lambda f, a=name, of=of: change.replace(f, a, of(f[a][()])))
        yield edited(kind, "array-of-text", REFUSE, lambda f, a=name: _as_text(f, a))
    for name in ("reflectance", "shininess"):
        yield edited("band", f"{name}-long", REFUSE, lambda f, a=name: change.replace(f, a, np.zeros(40, np.float32)))


def _as_text(file: h5py.File, name: str) -> None:
    values = np.full(file[name].shape, "280", object)
    change.replace(file, name, values, dtype=h5py.string_dtype())


def _storage() -> Iterator[Case]:
    for kind, name in MAIN.items():
        yield edited(kind, "virtual", REFUSE, lambda f, a=name: change.as_virtual(f, a, own=False))
        yield edited(kind, "virtual-of-itself", REFUSE, lambda f, a=name: change.as_virtual(f, a, own=True))
        yield edited(kind, "external-values", REFUSE, lambda f, a=name: change.as_external(f, a))
        yield edited(kind, "filter-unknown", REFUSE, lambda f, a=name: change.with_filter(f, a, claimed=True))
        yield edited(kind, "filter-skipped", EITHER, lambda f, a=name: change.with_filter(f, a, claimed=False))
        yield edited(kind, "chunk-damaged", REFUSE, lambda f, a=name: change.damaged_chunk(f, a))
        yield edited(kind, "chunk-short", UNJUDGED, lambda f, a=name: change.short_chunk(f, a))
        yield edited(kind, "shape-huge", REFUSE, lambda f, a=name: _huge(f, a, (HUGE,)))
        yield edited(kind, "shape-overflowing", REFUSE, lambda f, a=name: _huge(f, a, (1 << 32, 1 << 31)))
        yield edited(kind, "axis-huge", REFUSE, lambda f, a=INNER[kind]: _huge(f, a, (1 << 40,)))
    yield edited("band", "both-huge", REFUSE, _huge_pair)
    yield edited("band", "names-huge", REFUSE, lambda f: _huge(f, "material_name", (1 << 33,)))
    yield edited("atmosphere", "external-axis", REFUSE, lambda f: change.as_external(f, "share"))
    yield edited("atmosphere", "virtual-axis", REFUSE, lambda f: change.as_virtual(f, "share", own=True))


def _huge(file: h5py.File, name: str, shape: tuple[int, ...]) -> None:
    kind, chunk = file[name].dtype, (1,) * (len(shape) - 1) + (1024,)
    change.replace(file, name, shape=shape, dtype=kind, chunks=chunk)


def _huge_pair(file: h5py.File) -> None:
    """An axis and its array that agree, of 32 GiB together, never written."""
    for name in ("temperature", "blackbody_radiance"):
        change.replace(file, name, shape=(1 << 32,), dtype=file[name].dtype, chunks=(1 << 16,))


def _links() -> Iterator[Case]:
    for kind, name in MAIN.items():
        yield edited(kind, "link-into-another-file", REFUSE, lambda f, a=name: change.as_external_link(f, a))
        yield edited(kind, "link-to-nothing", REFUSE, lambda f, a=name: _soft(f, a, "/nothing"))
        yield edited(kind, "link-to-itself", REFUSE, lambda f, a=name: _soft(f, a, f"/{a}"))
        yield edited(kind, "group-for-an-array", REFUSE, lambda f, a=name: (f.pop(a), f.create_group(a)))
        yield edited(kind, "type-for-an-array", REFUSE, lambda f, a=name: (f.pop(a), f.__setitem__(a, np.dtype("f4"))))
        yield edited(kind, "cycle-of-links", EITHER, lambda f: f.create_group("loop").__setitem__("root", f["/"]))
        yield edited(kind, "web-of-links", EITHER, change.linked_web)
        yield edited(kind, "groups-without-end", EITHER, change.deep_groups)
    yield edited("band", "array-for-another", REFUSE, lambda f: _soft(f, "reflectance", "/blackbody_radiance"))


def _soft(file: h5py.File, name: str, target: str) -> None:
    del file[name]
    file[name] = h5py.SoftLink(target)
