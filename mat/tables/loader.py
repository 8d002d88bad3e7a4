"""Loading a database and reading it as a runtime does: linear in every axis.

Arrays are read from their file when they are first asked for (a flat export stays on disk, memory-mapped).
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from skyshine.mat.scattering import scattering_angle
from skyshine.mat.tables.axes import POLICIES, AxisRule
from skyshine.mat.tables.files import BAND, FILE_TYPES, HTT
from skyshine.mat.tables.gridded import ANGLE, AXES
from skyshine.mat.tables.interpolation import interpolate
from skyshine.mat.tables.raw import ENDING, read_raw
from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.hdf5 import Group, check_version, read_file


@dataclass(frozen=True)
class Table:
    """An open database; safe to share between threads, for nothing in it changes once it is read.

    Attributes
    ----------
    path : Path
    filetype : str
    root : Group
    attributes : dict
        The root attributes.
    """

    path: Path
    filetype: str
    root: Group
    attributes: dict

    @property
    def quantities(self) -> list[str]:
        """Names of the quantities that can be interpolated."""
        return [name for name, variable in self.root.variables.items() if variable.kind == "f"]

    def rules(self, quantity: str, out_of_range: str | Mapping[str, str] | None = None) -> list[AxisRule]:
        """Axes of a quantity, without its name where they are its own; `out_of_range` ('error' or 'clamp', or one of them by axis name)
        overrides what the file states."""
        if quantity not in self.root.variables:
            raise InputError(f"found the quantity '{quantity}'; {nearest(quantity, self.quantities)}", file=self.path)
        dims = self.root.variables[quantity].dims
        if not set(dims) <= set(self.root.axes):
            raise InputError(f"'{quantity}' has an axis that the file lacks; build it again", file=self.path)
        rules = [AxisRule.of(dim.removeprefix(f"{quantity}_"), self.root.axes[dim]) for dim in dims]
        if out_of_range is None:
            return rules
        names = [rule.name for rule in rules]
        chosen = out_of_range if isinstance(out_of_range, Mapping) else dict.fromkeys(names, out_of_range)
        for name, policy in chosen.items():
            if policy not in POLICIES:
                raise InputError(f"found out_of_range {policy!r}; allowed: 'error', 'clamp', or one of them by axis")
            if name not in names:
                raise InputError(f"found the axis '{name}' in out_of_range; {nearest(name, names)}")
        return [replace(rule, out_of_range=chosen.get(rule.name, rule.out_of_range)) for rule in rules]

    def value(self, quantity: str, *, out_of_range: str | Mapping[str, str] | None = None, **where) -> np.ndarray:
        """Interpolated values of a quantity.

        Parameters
        ----------
        quantity : str
            One of `quantities`.
        out_of_range : {'error', 'clamp'} or mapping of axis name to one of them, optional
            Overrides what the file states for its axes.
        **where
            A number or an array for each axis, broadcast against each other; a material may be named.

        Returns
        -------
        ndarray
            In the quantity's units, of the broadcast shape.

        Raises
        ------
        InputError
            Unknown quantity, axis or material, missing axis, or a value outside its axis.
        """
        rules = self.rules(quantity, out_of_range)
        if "material" in where:
            where["material"] = self.material_codes(where["material"])
        data = self.root.variables[quantity].data
        if data.shape != tuple(rule.nodes.size for rule in rules) or data.dtype.kind not in "iuf":
            raise InputError(f"'{quantity}' does not fit its axes; build the file again", file=self.path)
        return interpolate(data, rules, where)

    def error(self, quantity: str) -> dict[str, float]:
        """The interpolation error that the file states for a quantity.

        Returns
        -------
        dict of str to float
            maximum, p95, rms in the quantity's units; the same with ``_kelvin`` as equivalent temperature; the number
            of points measured. Empty where the file states none.
        """
        group = self.root.groups.get("accuracy")
        if group is None or quantity not in list(group.axes["quantity"].values):
            return {}
        at = list(group.axes["quantity"].values).index(quantity)
        return {name: float(v.data[at]) for name, v in group.variables.items() if v.dims == ("quantity",)}

    @property
    def materials(self) -> dict[str, int]:
        """Material names with their codes, where the file has a material axis."""
        if "material_name" not in self.root.variables:
            return {}
        names = self.root.variables["material_name"].data
        return dict(zip(names.tolist(), (int(code) for code in self.root.axes["material"].values)))

    def material_codes(self, given) -> np.ndarray:
        """Codes of materials given by code or by name."""
        array = np.asarray(given)
        if array.dtype.kind not in "UO":
            return array
        known = self.materials
        for name in array.ravel():
            if name not in known:
                raise InputError(f"found the material '{name}'; {nearest(name, known)}", file=self.path)
        return np.array([known[name] for name in array.ravel()], dtype=int).reshape(array.shape)


class TemperatureTable(Table):
    """A ``.htt`` database."""

    def temperature(self, *, material, altitude=0.0, azimuth=0.0, slope=0.0, time=0.0, out_of_range=None):
        """Surface temperature in kelvin.

        Parameters
        ----------
        material : int, str or array
            Code or name.
        altitude : km
        azimuth, slope : degree
            The face looks towards `azimuth`, from north eastward.
        time : h
            Local clock.
        """
        return self.value(
            "temperature", material=material, altitude=altitude, azimuth=azimuth, slope=slope, time=time,
            out_of_range=out_of_range,
        )  # fmt: skip


class BandTable(Table):
    """A ``.band`` database."""

    def blackbody_radiance(self, temperature):
        """Band radiance of a black body, equation (7), W m^-2 sr^-1, at `temperature` in kelvin."""
        return self.value("blackbody_radiance", temperature=temperature)


class AtmosphereTable(Table):
    """An ``.atmq`` or ``.lunar_atmq`` database."""

    def value(self, quantity, *, out_of_range=None, **where):
        """As `Table.value`; a table by scattering angle is read by source azimuth too."""
        variable, azimuth = self.root.variables.get(quantity), AXES[-1]
        if variable is not None and ANGLE in variable.dims and azimuth in where:
            if missing := [name for name in ("elevation", "source_elevation") if name not in where]:
                raise InputError(f"the axis '{missing[0]}' is missing; give a value for it")
            where[ANGLE] = scattering_angle(where["elevation"], where["source_elevation"], where.pop(azimuth))
            if isinstance(out_of_range, Mapping):
                out_of_range = {name: policy for name, policy in out_of_range.items() if name != azimuth}
        return super().value(quantity, out_of_range=out_of_range, **where)

    def transmittance(self, *, range, beta_star):  # noqa: A002 - the axis has this name
        """Transmittance over a range in km for a given beta*, equation (9)."""
        return np.exp(-5.5 * np.asarray(range, float) / np.asarray(beta_star, float))


def open_table(path: str | os.PathLike) -> Table:
    """Open any database of the table builder, or the header of its flat export.

    Raises
    ------
    InputError
        The file is missing, damaged, of another type, or its layout has another major version.
    """
    path = Path(path)
    root, attributes = read_raw(path) if path.name.endswith(ENDING) else read_file(path, lazy=True)
    filetype, version = (str(attributes.get(name)) for name in ("filetype", "format_version"))
    if filetype not in FILE_TYPES:
        raise InputError(f"holds '{filetype}'; {nearest(filetype, FILE_TYPES)}; name another file", file=path)
    check_version(path, filetype, version, FILE_TYPES[filetype].major)
    kinds = {HTT.name: TemperatureTable, BAND.name: BandTable}
    return kinds.get(filetype, AtmosphereTable)(path, filetype, root, attributes)
