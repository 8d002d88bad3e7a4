"""The kinds of databases, what a runtime computes from each, and how one is opened.

Arrays are read from their file when they are first asked for (a flat export stays on disk, memory-mapped).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from skyshine.mat.quantities.formulas import BETA_FACTOR
from skyshine.mat.radiometry.scattering_angle import scattering_angle
from skyshine.mat.surface.surroundings import WALL_EMISSIVITY, Surroundings
from skyshine.mat.tables import response
from skyshine.mat.tables.ambient import ambient_radiance, stated_ground
from skyshine.mat.tables.axes import Policy
from skyshine.mat.tables.files import BAND, FILE_TYPES, HTT, THERMAL_ATMQ
from skyshine.mat.tables.gridded import ANGLE, AXES
from skyshine.mat.tables.laws import broken_rules_of_axes
from skyshine.mat.tables.limits import refuse_values
from skyshine.mat.tables.night import SOURCE_ELEVATION, WITHOUT_SOURCE, Night
from skyshine.mat.tables.raw import ENDING, read_raw
from skyshine.mat.tables.shade import absorbed_change
from skyshine.mat.tables.stored_layout import refuse_layout
from skyshine.mat.tables.table import Table
from skyshine.mat.tables.tracks import SourceTrack, source_track
from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.hdf5 import check_version, read_file
from skyshine.schemas.paths import StrPath

_TURNED = ("elevation", "source_elevation", AXES[-1])  # give the scattering angle


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

    def source_track(self, source: str, *, time: npt.ArrayLike) -> SourceTrack:
        """Where the Sun or the Moon stands on the file's date and in the night after it.

        Parameters
        ----------
        source : {'sun', 'moon'}
        time : h
            Local clock, 0 to 36.

        Raises
        ------
        InputError
            Another source, a time beyond the track, or a file without tracks.
        """
        return source_track(self.root, source, time)


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
        """As `Table.value`; a table by scattering angle is read by source azimuth too.

        Below the lowest source elevation there is the light that the air emits, by the rule of `night`.
        """
        azimuth = AXES[-1]
        if self._by_angle(quantity) and ANGLE not in where and azimuth in self.fixed_axes | where:
            where = self._with_angle(where)
            if isinstance(out_of_range, Mapping):
                out_of_range = {name: policy for name, policy in out_of_range.items() if name != azimuth}
        night, height = Night.of(self.root, quantity), where.get(SOURCE_ELEVATION)
        if night is None or height is None or not night.begins(height):
            return super().value(quantity, out_of_range=out_of_range, **where)
        share = night.share(height, out_of_range)
        where[SOURCE_ELEVATION] = night.within(height)
        light = share * super().value(quantity, out_of_range=out_of_range, **where)
        if night.thermal is None:
            return light
        names = {rule.name for rule in self.rules(night.thermal)}
        if isinstance(out_of_range, Mapping):
            out_of_range = {name: policy for name, policy in out_of_range.items() if name in names}
        place = {name: values for name, values in where.items() if name in names}
        return light + (1.0 - share) * super().value(night.thermal, out_of_range=out_of_range, **place)

    def part(self, *, out_of_range: Policy = None, **where: Any) -> Self:
        """As `Table.part`, at night too."""
        part, height = super().part(out_of_range=out_of_range, **where), where.get(SOURCE_ELEVATION)
        if height is None or np.ndim(height) > 0:
            return part
        variables = dict(part.root.variables)
        for quantity in WITHOUT_SOURCE:
            night = Night.of(self.root, quantity)
            if night is None or not night.begins(height):
                continue
            light, share = variables[quantity], float(night.share(height, out_of_range))
            data = share * light.data
            if night.thermal is not None:
                emitted = variables[night.thermal].data
                by_source = np.ndim(data) > np.ndim(emitted)
                data = data + (1.0 - share) * (emitted[..., None] if by_source else emitted)
            variables[quantity] = replace(light, data=data)
        return replace(part, root=replace(part.root, variables=variables))

    def _by_angle(self, quantity: str) -> bool:
        variable = self.root.variables.get(quantity)
        return variable is not None and any(dim.endswith(ANGLE) for dim in variable.dims)

    def _with_angle(self, where: dict[str, Any]) -> dict[str, Any]:
        """The coordinates with the scattering angle in place of the azimuth of the source."""
        place = self.fixed_axes | where
        if missing := [name for name in _TURNED if name not in place]:
            raise InputError(f"the axis '{missing[0]}' is missing; give a value for it")
        angle = scattering_angle(*(place[name] for name in _TURNED))
        return {name: values for name, values in where.items() if name != AXES[-1]} | {ANGLE: angle}

    def _coordinates(self, quantity: str, where: dict[str, Any]) -> dict[str, Any]:
        if self._by_angle(quantity):
            place = self.fixed_axes | where
            if ANGLE not in where and all(np.ndim(place.get(name, ())) == 0 for name in _TURNED):
                where = self._with_angle(where)
            where = {name: values for name, values in where.items() if name != AXES[-1]}
        night, height = Night.of(self.root, quantity), where.get(SOURCE_ELEVATION)
        if night is None or height is None or not night.begins(height):
            return where
        return where | {SOURCE_ELEVATION: night.within(height)}

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
