"""What the air does to the radiance of pixels, as functions of the line of sight, from the library in double precision.

Equation (1) is linear in few functions of range, altitude and elevation once source and materials are named: the share
of black-body radiance that a material emits and the path lets through, the path radiance, and light on surfaces that
materials reflect and the path lets through. All are in W m^-2 sr^-1 but the first, which is a share.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from skyshine.mat.quantities.formulas import BETA_FACTOR
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.radiometry.spherical_harmonics import zonal
from skyshine.mat.tables.ambient import stated_ground
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.atmq import AMBIENT_HARMONICS, GROUND_HARMONICS
from skyshine.mat.tables.axes import AxisRule
from skyshine.mat.tables.band import BandTable
from skyshine.mat.tables.gridded import ANGLE
from skyshine.mat.tables.kernel_tables import kernel_tables
from skyshine.mat.tables.night import CIVIL_TWILIGHT, SOURCE_ELEVATION
from skyshine.schemas.arrays import Booleans, Floats

_PATH = "path_radiance_ratio"
_BELOW = 1e-3  # degree, below the first node of a table whose light ends there
_SKY, _RISE = "sky_source_elevation", "elevation_above_rise"
WARM_K = 300.0  # at which thermal radiance is weighed against the other terms


@dataclass(frozen=True, eq=False)
class AirFields:
    """The fields of an atmospheric table for the materials of a band.

    Attributes
    ----------
    ground_temperature : float, optional
        Temperature of the ground around faces [K]; by default that of the file. NaN leaves the ground out of `sky`.
    """

    air: AtmosphereTable
    band: BandTable
    ground_temperature: float | None = None

    def __post_init__(self) -> None:
        kernel_tables(band=self.band, air=self.air)  # refuses those of two bands

    @cached_property
    def codes(self) -> Any:
        """Codes of the M materials."""
        return np.asarray(self.band.root.axes["material"].values)

    @cached_property
    def temperatures(self) -> Floats:
        """Temperatures [K] at which emission is given."""
        return np.asarray(self.band.root.axes["planck_temperature"].values, float)

    @cached_property
    def harmonics(self) -> Any:
        """Codes of the harmonics; none in a file without them."""
        if AMBIENT_HARMONICS not in self.air.quantities:
            return np.zeros(0, np.int32)
        return np.asarray(self.air.root.axes["harmonic"].values)

    @cached_property
    def angles(self) -> Floats:
        """Nodes of the angle [degree] between line of sight and source."""
        return np.asarray(self.air.root.axes[ANGLE].values, float)

    @cached_property
    def source(self) -> AxisRule:
        """Rule of the source elevation."""
        return AxisRule.of(SOURCE_ELEVATION, self.air.root.axes[SOURCE_ELEVATION])

    @cached_property
    def dark(self) -> float:
        """A source elevation [degree] at which the air emits its light alone."""
        return min(self.source.dark_below, float(self.source.nodes[0]) - _BELOW)

    @cached_property
    def ground_nodes(self) -> Floats:
        """Temperatures [K] between which the spectrum of the ground's emission is linear."""
        return np.asarray(self.air.root.axes["ground_temperature"].values, float)

    @property
    def ground_kelvin(self) -> float:
        """Temperature of the ground around faces [K]."""
        if self.ground_temperature is not None:
            return self.ground_temperature
        return stated_ground(self.air.attributes).temperature

    @property
    def fades(self) -> bool:
        """Whether elevations between that one and the first node are read."""
        return float(self.source.nodes[0]) <= CIVIL_TWILIGHT

    def source_nodes(self, term: str) -> Floats:
        """Source elevations [degree] between which a term, ``path``, ``sky`` or ``direct``, is linear or nearly so."""
        axes, nodes = self.air.root.axes, np.asarray(self.source.nodes, float)
        lowest, highest = nodes[[0, -1]]
        if term == "sky":
            nodes = np.asarray(axes[_SKY].values, float)
        elif term == "direct":
            rise = float(np.asarray(self.air.root.variables["source_rise"].data, float)[0])
            nodes = np.concatenate([nodes, np.asarray(axes[_RISE].values, float) + rise, [rise - _BELOW]])
        nodes = np.unique(nodes)
        return np.concatenate([[self.dark], nodes[(nodes >= lowest) & (nodes <= highest)]])

    def transmittance(self, lines: LinesOfSight) -> Floats:
        """In-band transmittance (...), equation (9)."""
        return _transmittance(self, lines)

    def emission(self, lines: LinesOfSight) -> Floats:
        """Share of the black body's radiance that materials send through paths, (..., M, T)."""
        through = np.exp(-self.air.value_by_wavelength("optical_depth", **lines.path))
        spectra = self.band.spectra(material=self.codes[:, None], temperature=self.temperatures)
        return np.asarray(np.einsum("...b,mtb->...mt", through, (1 - spectra.reflectance) * spectra.emission))

    def path(self, lines: LinesOfSight, elevation: float, angles: Floats) -> Floats:
        """Path radiance (..., A) for source angles."""
        where = {name: values[..., None] for name, values in lines.path.items()}
        coordinates: dict[str, Any] = {**where, SOURCE_ELEVATION: np.asarray(elevation), ANGLE: angles}
        ratio = self.air.value(_PATH, **coordinates)
        return np.asarray(ratio * (1 - self.transmittance(lines))[..., None])

    def met(self, lines: LinesOfSight, elevation: float, angles: Floats) -> Floats:
        """Source angles (..., A), moved to those that a line can be at from a source of an elevation."""
        smallest, largest = self._span(lines, elevation)
        return np.clip(angles, smallest[..., None], largest[..., None])

    def reachable(self, lines: LinesOfSight, elevation: float) -> Booleans:
        """Whether lines (n,) can be within a cell of each of the nodes `angles` from the source, (n, A)."""
        smallest, largest = self._span(lines, elevation)
        padded = np.pad(self.angles, 1, mode="edge")
        return np.asarray((smallest[:, None] <= padded[2:]) & (largest[:, None] >= padded[:-2]))

    def _span(self, lines: LinesOfSight, elevation: float) -> tuple[Floats, Floats]:
        """Least and largest angle between lines and a source of an elevation."""
        return np.abs(lines.elevation - elevation), 180.0 - np.abs(lines.elevation + elevation)

    def thermal_path(self, lines: LinesOfSight) -> Floats:
        """Path radiance (...) without the source."""
        return self.path(lines, self.dark, self.angles[:1])[..., 0]

    def sky(self, lines: LinesOfSight, elevation: float) -> Floats:
        """Reflected ambient light (..., M, 1 + H): of level faces, then by the coefficients of the harmonics."""
        coordinates = lines.path | {SOURCE_ELEVATION: np.asarray(elevation)}
        terms = [self.reflected("ambient_radiance", lines, coordinates)]
        if self.harmonics.size:
            ground = {} if np.isnan(self.ground_kelvin) else _ground_light(self, lines)
            wide = {name: np.asarray(values)[..., None] for name, values in coordinates.items()}
            light = self.reflected(AMBIENT_HARMONICS, lines, wide | {"harmonic": self.harmonics})
            terms += [light[..., at, :] + ground.get(int(code), 0.0) for at, code in enumerate(self.harmonics)]
        return np.stack(terms, axis=-1)

    def ground(self, lines: LinesOfSight, kelvin: float) -> Floats:
        """What materials reflect of ground at a temperature [K], over its emission in the band (..., M, Z)."""
        return np.stack([_of_ground(self, lines, code, kelvin) for code in zonal(self.harmonics.size)], axis=-1)

    def direct(self, lines: LinesOfSight, elevation: float) -> Floats:
        """Reflected direct light (..., M) of faces normal to it."""
        return self.reflected("direct_radiance", lines, lines.path | {SOURCE_ELEVATION: np.asarray(elevation)})

    def reflected(self, quantity: str, lines: LinesOfSight, coordinates: dict[str, Any]) -> Floats:
        """Light of a quantity at a place (..., M) that materials reflect and the path lets through."""
        light = self.air.value_by_wavelength(quantity, **coordinates)
        through = self.transmittance(lines)
        light *= through.reshape(through.shape + (1,) * (light.ndim - through.ndim))
        spectra = self.band.spectra(material=self.codes, temperature=WARM_K)
        return np.asarray(light @ spectra.reflectance.T)


# Source elevations share what does not depend on them: lines are kept by identity.
@lru_cache(maxsize=8)
def _transmittance(fields: AirFields, lines: LinesOfSight) -> Floats:
    beta = fields.air.value("beta_star", **lines.path)
    return np.asarray(np.exp(-BETA_FACTOR * lines.range / beta))


@lru_cache(maxsize=4)
def _ground_light(fields: AirFields, lines: LinesOfSight) -> dict[int, Floats]:
    """What the ground emits and materials reflect (..., M), by harmonic."""
    stated = stated_ground(fields.air.attributes)
    kelvin, radiance = fields.ground_kelvin, stated.radiance
    if fields.ground_temperature is not None:
        radiance = stated.emissivity * float(fields.band.blackbody_radiance(kelvin))
    return {code: radiance * _of_ground(fields, lines, code, kelvin) for code in zonal(fields.harmonics.size)}


def _of_ground(fields: AirFields, lines: LinesOfSight, code: int, kelvin: float) -> Floats:
    """Light of one harmonic of the ground's emission that materials reflect (..., M), over the emission in the band."""
    coordinates = {"ground_temperature": np.asarray(kelvin), "zonal_harmonic": np.asarray(code)}
    return fields.reflected(GROUND_HARMONICS, lines, lines.path | coordinates)
