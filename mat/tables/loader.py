"""Loading a database and reading it as a runtime does: linear in every axis.

Arrays are read from their file when they are first asked for (a flat export stays on disk, memory-mapped).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from skyshine.mat.quantities.formulas import BETA_FACTOR
from skyshine.mat.radiometry.scattering_angle import scattering_angle
from skyshine.mat.surface.surroundings import WALL_EMISSIVITY, Surroundings
from skyshine.mat.tables import response
from skyshine.mat.tables.ambient import ambient_radiance, stated_ground
from skyshine.mat.tables.axes import POLICIES, AxisRule
from skyshine.mat.tables.files import BAND, FILE_TYPES, HTT, THERMAL_ATMQ
from skyshine.mat.tables.frame import part_of
from skyshine.mat.tables.gridded import ANGLE, AXES
from skyshine.mat.tables.interpolation import interpolate
from skyshine.mat.tables.laws import broken_rules_of_axes
from skyshine.mat.tables.limits import refuse_values
from skyshine.mat.tables.named_materials import AXIS, COORDINATES, NAMES
from skyshine.mat.tables.raw import ENDING, read_raw
from skyshine.mat.tables.shade import absorbed_change
from skyshine.mat.tables.stored_layout import refuse_layout
from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.hdf5 import Group, check_version, open_database, read_file
from skyshine.schemas.paths import StrPath

if TYPE_CHECKING:
    import xarray

Policy = str | Mapping[str, str] | None  # 'error' or 'clamp', or one of them by axis name; None: what the file states
_TURNED = ("elevation", "source_elevation", AXES[-1])  # give the scattering angle


@dataclass(frozen=True, repr=False)
class Table:
    """An open database; safe to share between threads, for nothing in it changes once it is read.

    Attributes
    ----------
    path : Path
    filetype : str
    root : Group
    attributes : dict
        The root attributes.
    fixed_axes : dict of str to float
        Of a part of a table: axes that are gone, with the value that they were read at.
    """

    path: Path
    filetype: str
    root: Group
    attributes: dict[str, Any]
    fixed_axes: dict[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Type, file, axes and quantities, in a few lines."""
        axes = [f"{name} {np.size(axis.values)}" for name, axis in self.root.axes.items()]
        axes += [f"{name} = {value:g}" for name, value in self.fixed_axes.items()]
        quantities = [f"{name} [{self.root.variables[name].units}]" for name in self.quantities]
        return (
            f"<{type(self).__name__} {self.filetype} {self.attributes.get('format_version')} '{self.path}'\n"
            f"  axes: {', '.join(axes)}\n  quantities: {', '.join(quantities)}>"
        )

    @property
    def quantities(self) -> list[str]:
        """Names of the quantities that can be interpolated."""
        return [name for name, variable in self.root.variables.items() if variable.kind == "f"]

    def rules(self, quantity: str, out_of_range: Policy = None) -> list[AxisRule]:
        """Axes of a quantity, without its name where they are its own; `out_of_range` ('error' or 'clamp', or one of
        them by axis name)
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

    def value(self, quantity: str, *, out_of_range: Policy = None, **where: Any) -> npt.NDArray[np.float64]:
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

    def part(self, *, out_of_range: Policy = None, **where: Any) -> Self:
        """The part of the table that one frame reads; reading it gives what the whole table gives, with fewer values.

        Parameters
        ----------
        out_of_range
            As in `value`.
        **where
            For an axis, a number: its quantities are read there, and the axis is gone; or a pair, the least and the
            most that will be asked for: the nodes around them stay. Other axes stay whole.

        Returns
        -------
        Table
            Of the same type, in memory.

        Raises
        ------
        InputError
            An unknown axis, a value outside its axis, or a pair on an axis that repeats.
        """
        if "material" in where:
            where["material"] = self.material_codes(where["material"])
        rules: dict[str, list[AxisRule]] = {}
        places: dict[str, dict[str, Any]] = {}
        for quantity in self.quantities:
            rules[quantity] = self.rules(quantity)
            places[quantity] = self._coordinates(quantity, where)
        known = {rule.name for axis_rules in rules.values() for rule in axis_rules}
        known |= {AXES[-1]} if ANGLE in known else set()
        for name in where:
            if name not in known:
                raise InputError(f"found the axis '{name}'; {nearest(name, sorted(known))}", file=self.path)
        if out_of_range is not None:
            for quantity, axis_rules in rules.items():
                names = [rule.name for rule in axis_rules]
                chosen = out_of_range if isinstance(out_of_range, Mapping) else dict.fromkeys(names, out_of_range)
                rules[quantity] = self.rules(
                    quantity, {name: policy for name, policy in chosen.items() if name in names}
                )
        fixed = {name: float(value) for name, value in where.items() if np.ndim(value) == 0}
        return replace(self, root=part_of(self.root, rules, places), fixed_axes=self.fixed_axes | fixed)

    def _coordinates(self, quantity: str, where: dict[str, Any]) -> dict[str, Any]:
        """What `part` reads or cuts of a quantity's own axes."""
        return where

    def stored_bytes(self, quantity: str) -> int:
        """What a quantity takes in the file, packed; of a flat export as it stands."""
        if self.path.name.endswith(ENDING):
            return int(self.root.variables[quantity].data.nbytes)
        with open_database(self.path) as file:
            return int(file[quantity].id.get_storage_size())

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

    def to_xarray(self) -> xarray.Dataset:
        """The table as an xarray Dataset, in memory: axes as coordinates, materials by name.

        A material axis has the names as its index and the codes as the coordinate ``material_code``, so that
        ``.sel(material="asphalt_road")`` picks one. The stated errors are not in it; see `error`.

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
        arrays: dict[str, Any] = {
            name: (
                variable.dims,
                variable.data,
                {"units": variable.units, "long_name": variable.long_name, **variable.attributes},
            )
            for name, variable in self.root.variables.items()
        }
        if NAMES in arrays:
            arrays = {name: (dims, data, _without(about, COORDINATES)) for name, (dims, data, about) in arrays.items()}
            coordinates[f"{AXIS}_code"] = coordinates[AXIS]
            coordinates[AXIS] = arrays.pop(NAMES)
        return xarray.Dataset(arrays, coordinates, self.attributes | self.fixed_axes)

    @property
    def materials(self) -> dict[str, int]:
        """Material names with their codes, where the file has a material axis."""
        if "material_name" not in self.root.variables:
            return {}
        names = self.root.variables["material_name"].data
        return dict(zip(names.tolist(), (int(code) for code in self.root.axes["material"].values), strict=True))

    def material_codes(self, given: Any) -> npt.NDArray[Any]:
        """Codes of materials given by code or by name."""
        array = np.asarray(given)
        if array.dtype.kind not in "UO":
            return array
        known = self.materials
        for name in array.ravel():
            if name not in known:
                raise InputError(f"found the material '{name}'; {nearest(name, known)}", file=self.path)
        return np.array([known[name] for name in array.ravel()], dtype=int).reshape(array.shape)


def _without(mapping: dict[str, Any], key: str) -> dict[str, Any]:
    return {name: value for name, value in mapping.items() if name != key}


class TemperatureTable(Table):
    """A ``.htt`` database."""

    def temperature(
        self,
        *,
        material: Any,
        altitude: npt.ArrayLike = 0.0,
        azimuth: npt.ArrayLike = 0.0,
        slope: npt.ArrayLike = 0.0,
        time: npt.ArrayLike = 0.0,
        absorbed_change: npt.ArrayLike | None = None,
        out_of_range: Policy = None,
    ) -> npt.NDArray[np.float64]:
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
        absorbed_change : (..., n) array_like, optional
            Heat that the surface absorbs beside that of the table [W m^-2], less where negative: means over n equal
            steps of the day, each centred on its time, the first on midnight; taken as every day's. The axes before
            the last are broadcast against the other arguments.

        Raises
        ------
        InputError
            A value is outside its axis, or there is a change and the file holds no response to it.
        """
        column = {"material": material, "altitude": altitude, "azimuth": azimuth, "slope": slope}
        sunlit = self.value("temperature", **column, time=time, out_of_range=out_of_range)
        if absorbed_change is None:
            return sunlit
        history = partial(self.value, "temperature", out_of_range=out_of_range)
        codes = column | {"material": self.material_codes(material)}
        change = response.temperature_change(self.root, history, codes, time, np.asarray(absorbed_change, float))
        highest = self.value(response.HIGHEST, material=material)
        return np.asarray(np.where(change == 0, sunlit, np.minimum(sunlit + change, np.maximum(highest, sunlit))))

    def absorbed_change(
        self,
        *,
        material: Any,
        altitude: npt.ArrayLike = 0.0,
        azimuth: npt.ArrayLike = 0.0,
        slope: npt.ArrayLike = 0.0,
        shade: Sequence[tuple[float, float]] = (),
        sky_view: float = 1.0,
        facing: float | None = None,
        facing_emissivity: float = WALL_EMISSIVITY,
    ) -> npt.NDArray[np.float64]:
        """Change of the heat that surfaces absorb, by a shadow and a wall that hides part of the sky [W m^-2].

        Parameters
        ----------
        material, altitude, azimuth, slope
            As in `temperature`.
        shade : sequence of (first, last)
            Clock hours in which no light comes from the direction of the Sun; over midnight where the first is later.
        sky_view : float
            Open share of the sky above the surface, 0 to 1; the rest is a wall, which reflects no sunlight.
        facing : float, optional
            Temperature of that wall [K]; by default that of the air.
        facing_emissivity : float

        Returns
        -------
        (..., 288) ndarray
            Of the broadcast shape of the arguments, for `temperature`.
        """
        around = Surroundings(tuple((float(a), float(b)) for a, b in shade), sky_view, facing, facing_emissivity)
        places = [np.asarray(values, float) for values in (altitude, azimuth, slope)]
        return absorbed_change(self.root, around, self.material_codes(material), *places)

    def sunlit_temperature(self, *, material: Any, **where: Any) -> npt.NDArray[np.float64]:
        """Temperature in kelvin of surfaces on which the Sun shines all day; `where` as in `temperature`."""
        return self.temperature(material=material, **where)

    def shaded_temperature(
        self,
        *,
        material: Any,
        sky_view: float = 1.0,
        facing: float | None = None,
        facing_emissivity: float = WALL_EMISSIVITY,
        **where: Any,
    ) -> npt.NDArray[np.float64]:
        """Temperature in kelvin of surfaces that are in the shade all day.

        Parameters
        ----------
        material, **where
            As in `temperature`.
        sky_view, facing, facing_emissivity
            As in `absorbed_change`.
        """
        column = {name: where[name] for name in ("altitude", "azimuth", "slope") if name in where}
        change = self.absorbed_change(
            material=material,
            **column,
            shade=[(0.0, 24.0)],
            sky_view=sky_view,
            facing=facing,
            facing_emissivity=facing_emissivity,
        )
        return self.temperature(material=material, **where, absorbed_change=change)


class BandTable(Table):
    """A ``.band`` database."""

    def blackbody_radiance(self, temperature: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Band radiance of a black body, equation (7), W m^-2 sr^-1, at `temperature` in kelvin."""
        return self.value("blackbody_radiance", temperature=temperature)

    def normalisation(
        self, *, material: Any, angle: npt.ArrayLike, out_of_range: Policy = None
    ) -> npt.NDArray[np.float64]:
        """N_s of (43) at angles of incidence in degree.

        From ``normalisation_fine`` (0 to 90 degree) where the job asked for it, else from ``normalisation_by_angle`` (0
        to 75 degree).
        """
        fine = "normalisation_fine" in self.root.variables
        name, axis = ("normalisation_fine", "incidence_angle") if fine else ("normalisation_by_angle", "source_angle")
        return self.value(name, material=material, out_of_range=out_of_range, **{axis: angle})


class AtmosphereTable(Table):
    """An ``.atmq`` or ``.lunar_atmq`` database."""

    def value(self, quantity: str, *, out_of_range: Policy = None, **where: Any) -> npt.NDArray[np.float64]:
        """As `Table.value`; a table by scattering angle is read by source azimuth too."""
        azimuth = AXES[-1]
        if self._by_angle(quantity) and ANGLE not in where and azimuth in self.fixed_axes | where:
            place = self.fixed_axes | where
            if missing := [name for name in _TURNED if name not in place]:
                raise InputError(f"the axis '{missing[0]}' is missing; give a value for it")
            where[ANGLE] = scattering_angle(*(place[name] for name in _TURNED))
            where.pop(azimuth, None)
            if isinstance(out_of_range, Mapping):
                out_of_range = {name: policy for name, policy in out_of_range.items() if name != azimuth}
        return super().value(quantity, out_of_range=out_of_range, **where)

    def _by_angle(self, quantity: str) -> bool:
        variable = self.root.variables.get(quantity)
        return variable is not None and any(dim.endswith(ANGLE) for dim in variable.dims)

    def _coordinates(self, quantity: str, where: dict[str, Any]) -> dict[str, Any]:
        if not self._by_angle(quantity):
            return where
        place = self.fixed_axes | where
        coordinates = _without(where, AXES[-1])
        if ANGLE not in coordinates and all(np.ndim(place.get(name, ())) == 0 for name in _TURNED):
            coordinates[ANGLE] = scattering_angle(*(place[name] for name in _TURNED))
        return coordinates

    def ambient_radiance(
        self,
        *,
        slope: npt.ArrayLike,
        azimuth: npt.ArrayLike = 0.0,
        ground_temperature: npt.ArrayLike | None = None,
        band: BandTable | None = None,
        out_of_range: Policy = None,
        **where: Any,
    ) -> npt.NDArray[np.float64]:
        """Ambient radiance of faces of any direction in W m^-2 sr^-1, in place of L_ambient in equation (19).

        Parameters
        ----------
        slope : degree
            0 faces up, 180 down.
        azimuth : degree
            Of the face relative to the azimuth of the source.
        ground_temperature : K, optional
            Of the ground around, as from the method `ground_temperature`; by default the one that the file states.
        band : BandTable, optional
            Of the same band; needed with `ground_temperature`.
        out_of_range
            As in `value`.
        **where
            range, altitude, elevation and source_elevation, as for the quantity ``ambient_radiance``.

        Raises
        ------
        InputError
            As `value`; or the file has no harmonics and a face is not level.
        """
        if ground_temperature is not None and band is None:
            raise InputError("found ground_temperature without band; give the .band table of the same band too")
        glow = None if band is None else band.blackbody_radiance
        return ambient_radiance(self, slope, azimuth, ground_temperature, glow, out_of_range, where)

    def ground_temperature(self, surface: TemperatureTable, *, time: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Temperature of the ground around faces, K.

        That of level ground of the file's ``ground_material`` at local clock times in h; where the file names none, the
        one temperature that it states.
        """
        name = self.attributes.get("ground_material")
        if name is None:
            return np.full(np.shape(time), stated_ground(self.path, self.attributes).temperature)
        lowest = float(surface.root.axes["altitude"].values[0])
        return surface.temperature(material=str(name), altitude=lowest, time=time)

    def transmittance(self, *, range: npt.ArrayLike, beta_star: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Transmittance over a range in km for a given beta*, equation (9)."""
        depth = BETA_FACTOR * np.asarray(range, float) / np.asarray(beta_star, float)
        return np.asarray(np.exp(-depth))


class ThermalTable(AtmosphereTable):
    """A ``.thermal_atmq`` database."""

    def beta_star(
        self,
        *,
        material: Any,
        temperature: npt.ArrayLike,
        range: npt.ArrayLike,
        altitude: npt.ArrayLike,
        elevation: npt.ArrayLike,
        out_of_range: Policy = None,
    ) -> npt.NDArray[np.float64]:
        """beta* in km of the light that materials emit, in place of beta* in equation (6).

        Parameters
        ----------
        material : int, str or array
            Code or name.
        temperature : K
            Of the surface.
        range, altitude : km
        elevation : degree
        out_of_range
            As in `value`.
        """
        return self.value(
            "beta_star_thermal",
            material=material,
            planck_temperature=temperature,
            range=range,
            altitude=altitude,
            elevation=elevation,
            out_of_range=out_of_range,
        )

    def value(self, quantity: str, *, out_of_range: Policy = None, **where: Any) -> npt.NDArray[np.float64]:
        """As `Table.value`; for a material in place of its class too."""
        if quantity == "beta_star_thermal" and "material" in where and "material_class" not in where:
            number = super().value("class_of_material", material=where.pop("material"))
            where["material_class"] = number.astype(int)
        return super().value(quantity, out_of_range=out_of_range, **where)


def open_table(path: StrPath) -> Table:
    """Open any database of the table builder, or the header of its flat export.

    Raises
    ------
    InputError
        The file is missing, damaged, of another type, or its layout is not that of the format or of another major
        version. Values outside their limits are refused when their array is first read.
    """
    path = Path(path)
    if path.name.endswith(ENDING):
        root, attributes = read_raw(path)
    else:
        root, attributes = read_file(path, lazy=True, check_layout=refuse_layout, check_values=refuse_values)
    filetype, version = (str(attributes.get(name)) for name in ("filetype", "format_version"))
    if filetype not in FILE_TYPES:
        raise InputError(f"holds '{filetype}'; {nearest(filetype, FILE_TYPES)}; name another file", file=path)
    check_version(path, filetype, version, FILE_TYPES[filetype].major)
    for line in broken_rules_of_axes(root):
        raise InputError(f"{line}; build the file again", file=path)
    kinds = {HTT.name: TemperatureTable, BAND.name: BandTable, THERMAL_ATMQ.name: ThermalTable}
    return kinds.get(filetype, AtmosphereTable)(path, filetype, root, attributes)
