"""Bad and unusual textures."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import h5py
import hdf5_changes as change
import numpy as np
from hostile_cases import EITHER, EQUAL, HUGE, REFUSE, Case, edited, on_path


def cases() -> Iterator[Case]:
    """The cases of this subject; names are unique."""
    code, weight, confidence = "levels/0/code", "levels/0/mix_weight", "levels/0/confidence"
    for name in ("materials", "materials/name", "levels", "levels/0", code, weight, confidence):
        yield edited("texture", f"without-{name.replace('/', '-')}", REFUSE, lambda f, n=name: f.pop(n))
    edits: dict[str, Callable[[h5py.File], object]] = {
        "without-filetype": lambda f: f.attrs.pop("filetype"),
        "of-the-next-major": lambda f: f.attrs.__setitem__("format_version", "2.0.0"),
        "nan-confidence": lambda f: change.set_middle(f, confidence, np.nan),
        "code-of-no-material": lambda f: change.set_middle(f, code, 65535),
        "codes-as-floats": lambda f: _retype(f, code, np.float32),
        "codes-of-another-shape": lambda f: _retype(f, code, np.uint16, slice(0, 3)),
        "weights-that-do-not-sum": lambda f: change.set_middle(f, weight, 65534),
        "names-fewer-than-codes": lambda f: _retype(f, "materials/name", object, slice(0, 1)),
        "group-for-an-array": lambda f: (f.pop(code), f.create_group(code)),
        "shape-huge": lambda f: (f.pop(code), f.create_dataset(code, (HUGE,), "u2", chunks=(1024,))),
        "code-in-another-file": lambda f: (f.pop(code), f.__setitem__(code, h5py.ExternalLink("o.h5", "/code"))),
    }
    shade, coarse = "levels/0/shade", "levels/1/shade"  # pixels ask for both levels
    edits |= {
        "shade-as-floats": lambda f: _reshaded(f, shade, lambda values: values.astype(np.float32)),
        "shade-of-16-bits": lambda f: _reshaded(f, shade, lambda values: values.astype(np.uint16)),
        "shade-signed": lambda f: _reshaded(f, shade, lambda values: (values // 2).astype(np.int8)),
        "shade-of-fewer-rows": lambda f: _reshaded(f, shade, lambda values: values[1:]),
        "shade-of-three-axes": lambda f: _reshaded(f, shade, lambda values: values[..., None]),
        "shade-of-another-total": lambda f: f[shade].attrs.__setitem__("total", 100),
        "shade-of-a-total-in-words": lambda f: f[shade].attrs.__setitem__("total", "all"),
        "shade-without-total": lambda f: f[shade].attrs.pop("total"),
        "shade-a-group": lambda f: (f.pop(shade), f.create_group(shade)),
        "shade-huge": lambda f: (f.pop(shade), f.create_dataset(shade, (HUGE, 1), "u1", chunks=(1024, 1))),
        "shade-in-another-file": lambda f: (f.pop(shade), f.__setitem__(shade, h5py.ExternalLink("o.h5", "/shade"))),
        "shade-missing-on-a-level": lambda f: f.pop(coarse),
        "shade-of-fewer-columns-on-a-level": lambda f: _reshaded(f, coarse, lambda values: values[:, 1:]),
    }
    for name, edit in edits.items():
        yield edited("texture", name, REFUSE, edit)
    yield on_path("texture", "truncated", REFUSE, lambda path: change.truncate(path, 0.6))
    yield edited("texture", "web-of-links", EITHER, change.linked_web)
    yield edited("texture", "more-attributes", EQUAL, lambda f: change.more_attributes(f, code))
    yield on_path("texture", "behind-a-user-block", EQUAL, change.with_user_block)


def _reshaded(file: h5py.File, name: str, change_of: Callable[[Any], Any]) -> None:
    values = change_of(file[name][()])
    del file[name]
    file.create_dataset(name, data=values).attrs["total"] = 255


def _retype(file: h5py.File, name: str, kind: Any, rows: slice = slice(None)) -> None:
    values = file[name][()][rows]
    del file[name]
    file.create_dataset(name, data=values, dtype=h5py.string_dtype() if kind is object else kind)
