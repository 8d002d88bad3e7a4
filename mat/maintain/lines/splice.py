"""Replacing intervals of an absorption table by those of another: only changed intervals have to be built again."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.gases.absorption import FILETYPE, NEGLIGIBLE, NO_DATA, OFFSET, STEP
from skyshine.mat.spectroscopy.table import DATA_VERSION
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, write_file
from skyshine.schemas.hdf5_digest import as_text, attributes_of

PathLike = str | os.PathLike[str]
Arrays = dict[str, npt.NDArray[Any]]
INTERVALS, POINTS = "intervals", "points"
# Variables of a gas by what they are given along: the intervals, or the points of the intervals where it is present.
BY_INTERVAL, BY_POINT = ("source", "rms_error"), ("log_cross_section", "log_moist_ratio")


@dataclass(frozen=True)
class _Table:
    """An absorption table in memory, packed as it is stored."""

    file: h5py.File
    low: npt.NDArray[Any]
    count: npt.NDArray[Any]

    @classmethod
    def of(cls, file: h5py.File) -> _Table:
        return cls(file, file[f"{INTERVALS}/low"][...], file[f"{INTERVALS}/count"][...])

    def gas(self, name: str) -> h5py.Group | None:
        """The group of a gas, or None."""
        return self.file["gases"].get(name)


def splice(table: PathLike, part: PathLike, out: PathLike) -> str:
    """Write a table whose intervals are those of `part` where it has them and those of `table` elsewhere, bit for bit.

    Returns
    -------
    str
        Hash of the new table's content.

    Raises
    ------
    InputError
        A file cannot be read, is no absorption table, or `part` has an interval that `table` has not.
    """
    with _open(table) as base_file, _open(part) as part_file:
        base, new = _Table.of(base_file), _Table.of(part_file)
        if not np.all(np.isin(new.low, base.low)):
            raise InputError(f"has intervals that {table} lacks; give a table built over part of its range", file=part)
        # Origin of each interval: whether it is taken from the part, and its row there or in the table.
        from_part = np.isin(base.low, new.low)
        row = np.where(from_part, np.searchsorted(new.low, base.low), np.arange(base.low.size))
        order = _Order(from_part, row)
        groups = {INTERVALS: _by_interval(base, new, order), POINTS: _points(base, new, order)}
        names = [*base.file["gases"], *(name for name in new.file["gases"] if name not in base.file["gases"])]
        groups["gases"] = Group(
            groups={name: _gas(name, base, new, order, groups[INTERVALS]) for name in sorted(names)}
        )
        texts = ("citation", "notice", "data_name", "water_continuum", "description")
        about = {name: base_file.attrs[name] for name in texts if name in base_file.attrs}
        header = Header(FILETYPE, DATA_VERSION, str(part_file.attrs["job"]), title=str(base_file.attrs["title"]))
        return write_file(Path(out), Group(groups=groups, attributes=about), header)


@dataclass(frozen=True)
class _Order:
    """For each interval of the new table: whether it comes from the part, and its row in its table."""

    from_part: npt.NDArray[np.bool_]
    row: npt.NDArray[Any]

    def pick(self, base: npt.NDArray[Any], new: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Values by interval."""
        values = base.copy()
        values[self.from_part] = new[self.row[self.from_part]]
        return values

    def join(
        self,
        base: tuple[npt.NDArray[Any], npt.NDArray[Any]],
        new: tuple[npt.NDArray[Any], npt.NDArray[Any]],
    ) -> npt.NDArray[Any]:
        """Values by point, each table given as (values, number of points of each interval)."""
        starts = [np.concatenate([[0], np.cumsum(count)]) for _, count in (base, new)]
        pieces = [
            (base, new)[int(from_part)][0][starts[int(from_part)][row] : starts[int(from_part)][row + 1]]
            for from_part, row in zip(self.from_part, self.row, strict=True)
        ]
        return np.concatenate(pieces)


def _open(path: PathLike) -> h5py.File:
    try:
        file = h5py.File(path)
    except OSError as error:
        raise InputError(f"cannot be read: {error}; give an absorption table", file=path) from None
    if file.attrs.get("filetype") != FILETYPE:
        file.close()
        raise InputError("is no absorption table; give a file of `mat lines build`", file=path)
    return file


def _axis(group: h5py.Group, name: str, values: npt.NDArray[Any] | None = None) -> Axis:
    dataset = group[name]
    text = dataset.asstr()[...] if dataset.dtype.kind == "O" else dataset[...]
    return Axis(
        text if values is None else values, as_text(dataset.attrs["units"]), as_text(dataset.attrs["long_name"])
    )


def _variable(group: h5py.Group, name: str, dims: tuple[str, ...], values: npt.NDArray[Any]) -> Variable:
    about = attributes_of(group[name])
    packed = {key: float(about[key]) for key in (STEP, OFFSET) if key in about}
    chunks = (128, *values.shape[1:]) if packed else None
    return Variable(dims, values, as_text(about["units"]), as_text(about["long_name"]), packed, chunks=chunks)


def _by_interval(base: _Table, new: _Table, order: _Order) -> Group:
    base_group, new_group = base.file[INTERVALS], new.file[INTERVALS]
    dims = {"error": ("interval", "statistic")}
    return Group(
        axes={"interval": _axis(base_group, "interval"), "statistic": _axis(base_group, "statistic")},
        variables={
            name: _variable(
                base_group, name, dims.get(name, ("interval",)), order.pick(base_group[name][...], new_group[name][...])
            )
            for name in ("low", "high", "count", "error")
        },
    )


def _points(base: _Table, new: _Table, order: _Order) -> Group:
    base_group, new_group = base.file[POINTS], new.file[POINTS]

    def joined(name: str) -> npt.NDArray[Any]:
        return order.join((base_group[name][...], base.count), (new_group[name][...], new.count))

    names = ("weight", "self_continuum", "foreign_continuum", "self_exponent")
    return Group(
        axes={"point": _axis(base_group, "point", joined("point"))},
        variables={name: _variable(base_group, name, ("point",), joined(name)) for name in names},
        attributes={"notice": base_group.attrs["notice"]},
    )


def _gas(name: str, base: _Table, new: _Table, order: _Order, intervals: Group) -> Group:
    base_group, new_group = base.gas(name), new.gas(name)
    either = base_group if base_group is not None else new_group
    assert either is not None
    texts: dict[str, str] = {}
    codes, errors, counts = [], [], []
    for table, group in ((base, base_group), (new, new_group)):
        source_codes = group["source"][...] if group is not None else np.full(table.low.size, NO_DATA, np.int8)
        here = [] if group is None else list(zip(group.attrs["sources"], group.attrs["terms"], strict=True))
        texts.update({str(text): str(terms) for text, terms in here})
        indices = [list(texts).index(str(text)) for text, _ in here]
        changed = source_codes.copy()
        for number, entry in enumerate(indices):
            changed[source_codes == NEGLIGIBLE + 1 + number] = NEGLIGIBLE + 1 + entry
        codes.append(changed)
        errors.append(group["rms_error"][...] if group is not None else np.zeros(table.low.size, np.float32))
        counts.append(np.where(source_codes > NEGLIGIBLE, table.count, 0))
    variables = {
        "source": _variable(either, "source", ("interval",), order.pick(*codes)),
        "rms_error": _variable(either, "rms_error", ("interval",), order.pick(*errors)),
    }
    axes = {"interval": intervals.axes["interval"]}

    def joined(dataset: str) -> npt.NDArray[Any]:
        parts = [
            either[dataset][:0] if group is None or dataset not in group else group[dataset][...]
            for group in (base_group, new_group)
        ]
        return order.join((parts[0], counts[0]), (parts[1], counts[1]))

    axes["point"] = _axis(either, "point", joined("point"))
    for dataset, dims in (
        ("log_cross_section", ("pressure", "temperature")),
        ("log_moist_ratio", ("h2o_fraction", "humid_pressure", "temperature")),
    ):
        if dataset in either:
            axes |= {dim: _axis(either, dim) for dim in dims}
            variables[dataset] = _variable(either, dataset, ("point", *dims), joined(dataset))
    return Group(axes=axes, variables=variables, attributes={"sources": list(texts), "terms": list(texts.values())})
