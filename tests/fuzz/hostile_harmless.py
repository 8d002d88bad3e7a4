"""Unusual files that a reader must read as the original."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import h5py
import hdf5_changes as change
import numpy as np
from hostile_cases import EITHER, EQUAL, INNER, MAIN, Case, edited, on_path

from skyshine.schemas.hdf5_digest import as_text

LATER = "later"  # names of arrays and groups that a later format might add


def cases() -> Iterator[Case]:
    """The cases of this subject; names are unique."""
    for kind, name in MAIN.items():
        axis = INNER[kind]
        edits: dict[str, Callable[[h5py.File], object]] = {
            "big-endian-values": lambda f, a=name: change.replace(f, a, f[a][()].astype(">f4")),
            "big-endian-axis": lambda f, a=axis: change.replace(f, a, f[a][()].astype(">f8")),
            "contiguous": lambda f, a=name: change.replace(f, a, f[a][()]),
            "small-chunks": lambda f, a=name: change.replace(f, a, f[a][()], chunks=(1,) * (f[a].ndim - 1) + (2,)),
            "best-compression": lambda f, a=name: change.replace(f, a, f[a][()], compression=9, chunks=True),
            "extensible": lambda f, a=name: change.replace(f, a, f[a][()], maxshape=(None,) * f[a].ndim, chunks=True),
            "more-attributes": lambda f, a=name: change.more_attributes(f, a),
            "more-arrays": _more_arrays,
            "fixed-length-rule": lambda f, a=axis: _fixed_rules(f, a),
            "policy-left-out": lambda f, a=axis: f[a].attrs.pop("out_of_range"),
            "newer-minor": lambda f: f.attrs.__setitem__("format_version", f.attrs["format_version"][:2] + "9"),
        }
        for word, edit in edits.items():
            yield edited(kind, word, EQUAL, edit)
        yield edited(kind, "more-arrays-without-axes", EITHER, _arrays_without_axes)
        yield on_path(kind, "behind-a-user-block", EQUAL, change.with_user_block)
        yield on_path(kind, "in-the-format-of-HDF5-1.6", EQUAL, change.in_old_format)
    yield edited("surface", "period-an-integer", EQUAL, lambda f: change.set_attribute(f, "azimuth", "period", 360))
    yield edited(
        "band", "big-endian-codes", EQUAL, lambda f: change.replace(f, "material", f["material"][()].astype(">i4"))
    )


def _more_arrays(file: h5py.File) -> None:
    for place, shape in ((f"{LATER}/values", (3, 4)), (f"{LATER}_version", (5,))):
        array = file.create_dataset(place, data=np.full(shape, np.nan))
        for k, count in enumerate(shape):
            axis = array.parent.create_dataset(f"{LATER}_axis_{k}", data=np.arange(float(count)))
            axis.make_scale(f"{LATER}_axis_{k}")
            array.dims[k].attach_scale(axis)


def _arrays_without_axes(file: h5py.File) -> None:
    file.create_dataset(f"{LATER}/values", data=np.full((3, 4), np.nan))
    file.create_dataset(f"{LATER}_version", data=np.arange(5))


def _fixed_rules(file: h5py.File, axis: str) -> None:
    for key in ("interpolation", "out_of_range"):
        change.set_fixed_text(file, axis, key, as_text(file[axis].attrs[key]).encode())
