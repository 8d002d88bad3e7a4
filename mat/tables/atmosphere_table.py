"""Databases of the atmosphere: monochromatic channels, read as the quantities of a line of sight."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.quantities.channels.coordinates import TOP_KM, RayCoordinates
from skyshine.mat.quantities.formulas import BETA_FACTOR
from skyshine.mat.tables.ambient import stated_ground
from skyshine.mat.tables.atmq import AMBIENT_HARMONICS, GROUND_HARMONICS, RADIANCE, VALID
from skyshine.mat.tables.axes import FOLDED, AxisRule
from skyshine.mat.tables.band import BandTable
from skyshine.mat.tables.files import ATMQ, LUNAR_ATMQ
from skyshine.mat.tables.gridded import ANGLE, AXES
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.mat.tables.kernel_tables import kernel_tables, messages
from skyshine.mat.tables.table import Table, unknown_quantity
from skyshine.schemas.errors import InputError, nearest

_PATH = AXES[:3]
DEPTH = "optical_depth"
# Axes that each quantity is read by; path radiance takes a scattering angle in place of the azimuth too.
_READ_BY = {
    VALID: _PATH,
    DEPTH: _PATH,
    "beta_star": _PATH,
    "path_radiance_ratio": AXES,
    "ambient_radiance": AXES[:4],
    "direct_radiance": AXES[:4],
    AMBIENT_HARMONICS: (*AXES[:4], "harmonic"),
    GROUND_HARMONICS: (*_PATH, "ground_temperature", "zonal_harmonic"),
}
_OF_THE_BAND = ("beta_star", "path_radiance_ratio")  # not parted by wavelength
# Km, first node of range above 0, and number of nodes, of `nodes_of`: equal steps of the logarithm.
_NEAREST_KM, _SHOWN = 1e-3, 40
_FARTHEST_KM = 100_000.0  # range of observers in space
_SHOWN_ELEVATIONS = (-90, -60, -40, -20, -10, -5, -3, -2, -1, 0, 1, 2, 3, 5, 10, 20, 40, 60, 90)
_STORED = {AMBIENT_HARMONICS: "scattered_harmonics", GROUND_HARMONICS: "ground_harmonics"}


@dataclass(frozen=True, repr=False)
class AtmosphereTable(Table):
    """An ``.atmq`` or ``.lunar_atmq`` database.

    Its quantities are computed from the channels when they are read.
    """

    filetypes = (ATMQ.name, LUNAR_ATMQ.name)

    @property
    def quantities(self) -> list[str]:
        """Names of the quantities that can be read."""
        named = [name for name in _READ_BY if name not in (VALID, DEPTH)]
        return [name for name in named if _STORED.get(name, name) in self.root.variables or name not in _STORED]

    def units(self, quantity: str) -> str:
        """Units of a quantity."""
        return {"beta_star": "km", GROUND_HARMONICS: "1"}.get(quantity, RADIANCE)

    @property
    def rays(self) -> RayCoordinates:
        """Coordinates in which the arrays of lines of sight are smooth."""
        nodes = np.asarray(self.root.axes["height_root"].values, float)
        radius = np.asarray(self.root.variables["effective_radius"].data, float)
        ground, scale = (float(self.attributes[name]) for name in ("ground_altitude_km", "scale_height_km"))
        return RayCoordinates(ground, nodes, radius, scale)

    def _axis_names(self) -> set[str]:
        return super()._axis_names() | {ANGLE}

    def rules(self, quantity: str) -> list[AxisRule]:
        """Axes by which a quantity is read, with the ends of what the file is for as nodes."""
        if quantity not in (*self.quantities, VALID, DEPTH):
            raise unknown_quantity(quantity, self.quantities, self.path)
        return [self.out_of_range.applied(self._rule(name)) for name in _READ_BY[quantity]]

    def _rule(self, name: str) -> AxisRule:
        ends = {
            "range": np.asarray(self.attributes["range_km"], float),
            "altitude": _with_space(np.asarray(self.attributes["altitude_km"], float)),
            "elevation": np.array([-90.0, 90.0]),
        }
        if name in ends:
            return AxisRule(name, np.unique(ends[name]))
        if name == AXES[-1]:
            return AxisRule(name, np.array([0.0, 180.0]), FOLDED, 360.0)
        return AxisRule.of(name, self.root.axes[name])

    def value(self, quantity: str, **where: Any) -> npt.NDArray[np.float64]:
        """As `Table.value`.

        Below the lowest source elevation the light of the source falls as in `night`, down to what the air emits.
        """
        if quantity == DEPTH:
            raise InputError("'optical_depth' is read by wavelength alone; call value_by_wavelength", file=self.path)
        return self._read(quantity, where, by_wavelength=False)

    def _read(self, quantity: str, where: dict[str, Any], *, by_wavelength: bool) -> npt.NDArray[np.float64]:
        rules = [rule.name for rule in self.rules(quantity)]
        angle = where.pop(ANGLE, None) if AXES[-1] in rules else None
        self._refuse_axes(quantity, where, besides=() if angle is None else (AXES[-1],))
        names = [*(name for name in rules if name in where), *(() if angle is None else (ANGLE,))]
        coordinates = np.broadcast_arrays(*(np.asarray(where.get(name, angle), float) for name in names))
        shape, read = coordinates[0].shape, f"{quantity}_by_angle" if angle is not None else quantity
        with messages():
            flat = [values.ravel() for values in coordinates]
            values = kernel_tables(air=self).quantity(read, flat, by_wavelength=by_wavelength)
        return values.reshape((*shape, *values.shape[1:]))

    def _refuse_axes(self, quantity: str, where: Mapping[str, Any], besides: Collection[str] = ()) -> None:
        """Refuse axes that a quantity does not have, or lacks."""
        allowed = {rule.name for rule in self.rules(quantity)} - set(besides)
        for name in where:
            if name not in allowed:
                raise InputError(f"found the axis '{name}'; {nearest(name, sorted(allowed))}", file=self.path)
        if missing := sorted(allowed - set(where)):
            raise InputError(f"the axis '{missing[0]}' is missing; give a value for it", file=self.path)

    def value_by_wavelength(self, quantity: str, **where: Any) -> npt.NDArray[np.float64]:
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
        **where
            As in `value`.

        Raises
        ------
        InputError
            As `value`; or the file cannot part its light.
        """
        spectral = [DEPTH, *(name for name in self.quantities if name not in _OF_THE_BAND)]
        if quantity not in spectral:
            raise unknown_quantity(quantity, spectral, self.path)
        return self._read(quantity, where, by_wavelength=True)

    def nodes_of(self, axis: str) -> npt.NDArray[np.float64]:
        """Values of an axis of the quantities at which the table is well looked at."""
        if axis == "range":
            nearest_km, farthest = (float(value) for value in self.attributes["range_km"])
            if farthest <= _NEAREST_KM:
                return np.unique([nearest_km, farthest])
            return np.unique([nearest_km, *np.geomspace(max(nearest_km, _NEAREST_KM), farthest, _SHOWN)])
        if axis == "altitude":
            ground = float(self.attributes["ground_altitude_km"])
            heights = np.asarray(self.root.axes["height_root"].values, float) ** 3
            # The cube of a root rounds beyond the height.
            lowest_km, highest_km = (float(value) for value in self.attributes["altitude_km"])
            return np.clip(ground + heights, lowest_km, highest_km)
        if axis == "elevation":
            return np.array(_SHOWN_ELEVATIONS, float)
        if axis == AXES[-1]:
            return np.linspace(0.0, 180.0, 13)
        return np.asarray(self.root.axes[axis].values, float)

    def ambient_radiance(
        self,
        *,
        slope: npt.ArrayLike,
        azimuth: npt.ArrayLike = 0.0,
        ground_temperature: npt.ArrayLike | None = None,
        band: BandTable | None = None,
        by_wavelength: bool = False,
        **where: Any,
    ) -> npt.NDArray[np.float64]:
        """Ambient radiance of faces of any direction in W m^-2 sr^-1, in place of L_ambient in equation (19).

        Parameters
        ----------
        slope : degree
            0 faces up, 180 down.
        azimuth : degree
            Azimuth of the face relative to the azimuth of the source.
        ground_temperature : K, optional
            Temperature of the surrounding ground, as from the method `ground_temperature`; by default the one that the
            file states.
        band : BandTable, optional
            Table of the same band; required with `ground_temperature`.
        by_wavelength : bool
            Parted by wavelength along a last axis, as `value_by_wavelength`.
        **where
            range, altitude, elevation and source_elevation, as for the quantity ``ambient_radiance``.

        Raises
        ------
        InputError
            As `value`; or the file has no harmonics and a face is not level.
        """
        if ground_temperature is not None and band is None:
            raise InputError("found ground_temperature without band; give the .band table of the same band too")
        if AMBIENT_HARMONICS not in self.quantities and np.any(np.asarray(slope) != 0):
            raise InputError(
                f"has no {AMBIENT_HARMONICS}; allowed: slope 0; build the file from a job whose surface_grid.slope_deg"
                " has tilted faces",
                file=self.path,
            )
        self._refuse_axes("ambient_radiance", where)
        arguments = [*(where[name] for name in AXES[:4]), slope, azimuth]
        arguments += [] if ground_temperature is None else [ground_temperature]
        coordinates = np.broadcast_arrays(*(np.asarray(values, float) for values in arguments))
        flat, shape = [values.ravel() for values in coordinates], coordinates[0].shape
        ground = flat[6] if ground_temperature is not None else None
        with messages():
            light = kernel_tables(band=band, air=self).ambient(
                flat[:4], flat[4], flat[5], ground, by_wavelength=by_wavelength
            )
        return light.reshape((*shape, *light.shape[1:]))

    def ground_temperature(self, surface: TemperatureTable, *, time: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Temperature of the ground around faces, K.

        That of level ground of the file's ``ground_material`` at local clock times in h; where the file names none, the
        one temperature that it states.
        """
        name = self.attributes.get("ground_material")
        if name is None:
            return np.full(np.shape(time), stated_ground(self.attributes).temperature)
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
                limit = "0 km or more" if name == "range" else "above 0 km"
                raise InputError(f"{name}: found {np.ravel(values)[np.argmax(wrong)]:g}; allowed: {limit}")
        depth = BETA_FACTOR * length / beta
        return np.asarray(np.exp(-depth))


def _with_space(altitudes: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Least and most altitude of observers: those of a file that reaches the top of the air may be in space."""
    return np.array([altitudes[0], _FARTHEST_KM]) if altitudes[1] >= TOP_KM else altitudes
