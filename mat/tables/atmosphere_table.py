"""Databases of the atmosphere on axes of range, altitude and elevation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from skyshine.mat.quantities.formulas import BETA_FACTOR
from skyshine.mat.radiometry.scattering_angle import scattering_angle
from skyshine.mat.tables.ambient import ambient_radiance, stated_ground
from skyshine.mat.tables.axes import Policy
from skyshine.mat.tables.gridded import ANGLE, AXES
from skyshine.mat.tables.night import SOURCE_ELEVATION, WITHOUT_SOURCE, Night
from skyshine.mat.tables.surface_tables import BandTable, TemperatureTable
from skyshine.mat.tables.table import Table
from skyshine.schemas.errors import InputError

_TURNED = ("elevation", "source_elevation", AXES[-1])  # give the scattering angle


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

    def nodes_of(self, axis: str) -> npt.NDArray[np.float64]:
        """Values of an axis at which the table is well looked at: its nodes."""
        return np.asarray(self.root.axes[axis].values, float)

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

    @property
    def has_wavelengths(self) -> bool:
        """Whether `value_by_wavelength` can be read: tables in channels alone hold what it needs."""
        return False

    def value_by_wavelength(
        self, quantity: str, *, out_of_range: Policy = None, **where: Any
    ) -> npt.NDArray[np.float64]:
        """A quantity parted by wavelength, along a last axis of B: ``band_wavelength`` of the file.

        Light on surfaces sums to `value` over the wavelengths; the optical depth of emitted light, -ln tau_b, is one
        number for each (above 0 at a range of 0, as of 1e-12 km of air). With reflectance rho_b and the share s_b of a
        wavelength in the black body's radiance (`reflectance_spectrum` and `emission_share` of the .band file),
        surfaces emit sum_b (1 - rho_b) s_b tau_b L_bb and reflect tau sum_b rho_b L_b: the integrals (5), (18) and
        (26).

        Parameters
        ----------
        quantity : str
            ``optical_depth``, or one of light on surfaces: ``ambient_radiance``, ``direct_radiance`` or harmonics.
        out_of_range, **where
            As in `value`.

        Raises
        ------
        InputError
            As `value`; or the file cannot part its light.
        """
        raise InputError(
            "holds no light by wavelength; build it with atmosphere_grid: {layout: channels}", file=self.path
        )

    def ambient_radiance(
        self,
        *,
        slope: npt.ArrayLike,
        azimuth: npt.ArrayLike = 0.0,
        ground_temperature: npt.ArrayLike | None = None,
        band: BandTable | None = None,
        by_wavelength: bool = False,
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
        by_wavelength : bool
            Parted by wavelength along a last axis, as `value_by_wavelength`.
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
        read = self.value_by_wavelength if by_wavelength else self.value
        return ambient_radiance(
            self, read, slope, azimuth, ground_temperature, glow, out_of_range, where, by_wavelength=by_wavelength
        )

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
        """Transmittance over a range in km for a given beta*, equation (9).

        Raises
        ------
        InputError
            A range is below 0 or not finite, or a beta* is not above 0.
        """
        length, beta = np.asarray(range, float), np.asarray(beta_star, float)
        for name, values, wrong in (
            ("range", length, ~(np.isfinite(length) & (length >= 0))),
            ("beta_star", beta, ~(beta > 0)),
        ):
            if np.any(wrong):
                least = "0 km or more" if name == "range" else "above 0 km"
                raise InputError(f"{name}: found {np.ravel(values)[np.argmax(wrong)]:g}; allowed: {least}")
        depth = BETA_FACTOR * length / beta
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
