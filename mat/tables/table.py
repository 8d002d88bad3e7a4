"""A database that is open: its quantities, read linearly in every axis."""

from __future__ import annotations

import importlib
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

from skyshine.mat.quantities.formulas import BETA_FACTOR
from skyshine.mat.tables.axes import CLOCK_UNIT, AxisRule
from skyshine.mat.tables.interpolation import interpolate
from skyshine.mat.tables.named_materials import AXIS, COORDINATES, NAMES
from skyshine.mat.tables.out_of_range import AS_STATED, OutOfRange
from skyshine.mat.tables.result import Chart, Result
from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.hdf5 import Group

if TYPE_CHECKING:
    import xarray

_DERIVED = {
    "transmittance": f"ask for beta_star [km]: transmittance = exp(-{BETA_FACTOR:g} range / beta_star)",
    "path_radiance": "ask for path_radiance_ratio and beta_star: path radiance = path_radiance_ratio"
    f" (1 - exp(-{BETA_FACTOR:g} range / beta_star))",
}


@dataclass(frozen=True, repr=False)
class Table(Result):
    """An open database; safe to share between threads, for nothing in it changes once it is read.

    Attributes
    ----------
    path : Path
    filetype : str
    root : Group
    attributes : dict
        The root attributes.
    out_of_range : OutOfRange
        What is done with values outside the axes.
    """

    filetypes: ClassVar[tuple[str, ...]] = ()  # those whose files are of this class

    path: Path
    filetype: str
    root: Group
    attributes: dict[str, Any]
    out_of_range: OutOfRange = AS_STATED

    def __repr__(self) -> str:
        """Type, file, axes and quantities, in a few lines."""
        axes = [f"{name} {np.size(axis.values)}" for name, axis in self.root.axes.items()]
        quantities = [f"{name} [{self.units(name)}]" for name in self.quantities]
        return (
            f"<{type(self).__name__} {self.filetype} {self.attributes.get('format_version')} '{self.path}'\n"
            f"  axes: {', '.join(axes)}\n  quantities: {', '.join(quantities)}>"
        )

    @property
    def quantities(self) -> list[str]:
        """Names of the quantities that can be interpolated."""
        return [name for name, variable in self.root.variables.items() if variable.dtype.kind == "f"]

    def units(self, quantity: str) -> str:
        """Units of a quantity."""
        return self.root.variables[quantity].units

    def clamped(self, *axes: str) -> Self:
        """The same table, in which a value outside an axis reads its nearest node.

        Parameters
        ----------
        *axes : str
            Names of the axes on which it does; by default all.

        Raises
        ------
        InputError
            An axis that the table lacks.
        """
        return replace(self, out_of_range=OutOfRange.clamping(axes, self._axis_names()))

    def _axis_names(self) -> set[str]:
        """Names of the axes of all quantities, as arguments."""
        return {rule.name for quantity in self.quantities for rule in self.rules(quantity)}

    def rules(self, quantity: str) -> list[AxisRule]:
        """Axes of a quantity, by their names without that of the quantity."""
        if quantity not in self.root.variables:
            raise unknown_quantity(quantity, self.quantities, self.path)
        dims = self.root.variables[quantity].dims
        if not set(dims) <= set(self.root.axes):
            raise InputError(f"'{quantity}' has an axis that the file lacks; build it again", file=self.path)
        return [self.out_of_range.rule(dim.removeprefix(f"{quantity}_"), self.root.axes[dim]) for dim in dims]

    def value(self, quantity: str, **where: Any) -> npt.NDArray[np.float64]:
        """Interpolated values of a quantity.

        Parameters
        ----------
        quantity : str
            One of `quantities`.
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
        rules = self.rules(quantity)
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

    def plot(self) -> Chart:
        """The picture that a build draws of the database, as `Result.plot`."""
        pictures = importlib.import_module("skyshine.mat.tables.pictures")  # which reads tables of every type
        return Chart(pictures.figure_of(self))

    def to_xarray(self) -> xarray.Dataset:
        """The table as an xarray Dataset, in memory: axes as coordinates, materials by name.

        A material axis has the names as its index and the codes as the coordinate ``material_code``, so that
        ``.sel(material="asphalt_road")`` picks one. The day is the coordinate ``date``, along which files of a year
        are joined. The stated errors are not in it; see `error`.

        Raises
        ------
        ModuleNotFoundError
            xarray is not installed.
        """
        import xarray

        coordinates: dict[str, Any] = {
            name: (name, axis.values, {"units": axis.units, "long_name": axis.long_name, **axis.attributes})
            for name, axis in self.root.axes.items()
        }
        if "time" in coordinates:  # a day, whose date is a coordinate of its own; files count from its midnight
            coordinates["time"][2]["units"] = CLOCK_UNIT
            coordinates["time"][2].pop("standard_name", None)
        arrays: dict[str, Any] = {
            name: (
                variable.dims,
                variable.data,
                {"units": variable.units, "long_name": variable.long_name, **variable.attributes},
            )
            for name, variable in self.root.variables.items()
        }
        if NAMES in arrays:
            for _, _, attributes in arrays.values():
                attributes.pop(COORDINATES, None)
            coordinates[f"{AXIS}_code"] = coordinates[AXIS]
            coordinates[AXIS] = arrays.pop(NAMES)
        if "date" in self.attributes:
            coordinates["date"] = ((), np.datetime64(str(self.attributes["date"]), "ns"), {"long_name": "local day"})
        return xarray.Dataset(arrays, coordinates, self.attributes)

    @property
    def materials(self) -> dict[str, int]:
        """Material names with their codes, where the file has a material axis."""
        if "material_name" not in self.root.variables:
            return {}
        names = self.root.variables["material_name"].data
        return dict(zip(names.tolist(), (int(code) for code in self.root.axes["material"].values), strict=True))

    def material_codes(self, materials: Any) -> npt.NDArray[Any]:
        """Codes of materials given by code or by name."""
        array = np.asarray(materials)
        if array.dtype.kind not in "UO":
            return array
        codes = self.materials
        for name in array.ravel():
            if name not in codes:
                raise InputError(f"found the material '{name}'; {nearest(name, codes)}", file=self.path)
        return np.array([codes[name] for name in array.ravel()], dtype=int).reshape(array.shape)


def unknown_quantity(name: str, quantities: Iterable[str], file: Path) -> InputError:
    """The error of a quantity that a file lacks; of what follows from two others it says how."""
    names = list(quantities)
    words = _DERIVED[name] if name in _DERIVED and "beta_star" in names else nearest(name, names)
    return InputError(f"found the quantity '{name}'; {words}", file=file)
