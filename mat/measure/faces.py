"""Random faces at the ends of random lines of sight, on which ambient light from harmonics is measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.line_of_sight import lines_of_sight
from skyshine.mat.measure.probes import lines_in_cells
from skyshine.mat.measure.sampling import random_places
from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.facet_light import facet_irradiance
from skyshine.mat.quantities.formulas import mean_transmittance
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.surface_light import radiance_weight
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.radiometry.spherical_harmonics import ambient_of_faces
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.atmq import AMBIENT_HARMONICS, GROUND_HARMONICS
from skyshine.mat.tables.gridded import AXES
from skyshine.schemas.arrays import Floats

LINES, FEWEST_LINES, FACES = 16, 6, 24
GROUND_K = (250.0, 340.0)  # temperatures of the ground, at random between


@dataclass(frozen=True, eq=False)
class FaceProbes:
    """n lines of sight that end above the ground, and F faces at the end of each.

    Attributes
    ----------
    places : dict of str to (n,) array
        By the first four of `gridded.AXES`.
    normal : (n, F, 3) array
    ground_temperature, ground_radiance : (n,) arrays
        K; emitted by the ground in the band, W m^-2 sr^-1.
    transmittance : (n,) array
        Of the path.
    truth : (n, F) array
        Ambient radiance, W m^-2 sr^-1.
    """

    places: dict[str, Floats]
    normal: Floats
    ground_temperature: Floats
    ground_radiance: Floats
    transmittance: Floats
    truth: Floats

    @classmethod
    def drawn(
        cls, atmosphere: BandAtmosphere, base: PathGrid, irradiance: Floats, generator: np.random.Generator
    ) -> FaceProbes:
        """Draw lines on the job's own axes and compute the light on faces at their ends."""
        count = atmosphere.scope.lines(LINES, FEWEST_LINES)
        altitude, elevation, ranges = lines_in_cells(base, count, generator)
        distance = ranges[np.arange(count), generator.permutation(count) % ranges.shape[1]]
        source = random_places(base.source_elevation_deg, count, generator)
        normal = generator.normal(size=(count, FACES, 3))
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        kelvin = generator.uniform(*GROUND_K, count)
        air, band = atmosphere.air, atmosphere.band
        paths = list(lines_of_sight(air, distance[:, None] * 1e3, altitude * 1e3, np.radians(elevation)))
        kept = np.array([bool(path.valid[0]) for path in paths])
        paths = [path for path, valid in zip(paths, kept, strict=True) if valid]
        end = np.array([min(path.surface_altitude[0], air.shells.top) for path in paths])
        light = facet_irradiance(air, end, np.radians(source[kept]), normal[kept], irradiance, kelvin[kept])
        weight = np.array([radiance_weight(band, path)[0] for path in paths]).reshape(-1, band.weight.size)
        through = np.array(
            [np.exp(mean_transmittance(path.depth, band.weight, band.weight.sum())[0][0]) for path in paths]
        )
        emissivity = 1 - air.state.mean_albedo
        glow = planck_wavenumber(band.wavenumber, kelvin[kept][:, None]) @ band.radiance_weight
        places = dict(zip(AXES, (values[kept] for values in (distance, altitude, elevation, source)), strict=False))
        truth = np.einsum("nfp,np->nf", light, weight) if paths else np.empty((0, FACES))
        return cls(places, normal[kept], kelvin[kept], emissivity * glow, through, truth)

    def errors(self, table: AtmosphereTable, scale: Scale | None) -> Floats:
        """Errors (n, F) of faces read from a table, in the scale's unit; without a scale in W m^-2 sr^-1."""
        at = {name: values[:, None] for name, values in self.places.items()}
        path = {name: at[name] for name in AXES[:3]} | {"ground_temperature": self.ground_temperature[:, None]}
        codes, axial = (table.root.axes[name].values for name in ("harmonic", "zonal_harmonic"))
        light = table.value(AMBIENT_HARMONICS, out_of_range="clamp", **at, harmonic=codes)
        ground = table.value(GROUND_HARMONICS, out_of_range="clamp", **path, zonal_harmonic=axial)
        flat = table.value("ambient_radiance", out_of_range="clamp", **at)
        return self._errors(flat, light, ground, scale)

    def _errors(self, flat: Floats, light: Floats, ground: Floats, scale: Scale | None) -> Floats:
        """Errors (n, F) of level light (n, 1) and coefficients (n, H) and (n, L)."""
        found = ambient_of_faces(flat, light[:, None], ground[:, None], self.ground_radiance[:, None], self.normal)
        if scale is None:
            return found - self.truth
        distance = self.places["range"][:, None]
        return scale.error("ambient_radiance", found, self.truth, self.transmittance[:, None], distance)
