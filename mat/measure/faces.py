"""Random faces at the ends of random lines of sight, in the open and beside walls, on which harmonics are measured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.line_of_sight import lines_of_sight
from skyshine.mat.atmosphere.transfer.scene_lines import SceneLines
from skyshine.mat.measure.probes import NIGHT_DEG
from skyshine.mat.measure.sampling import random_coordinates
from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.facet_light import Facets, Walls, light_among_walls
from skyshine.mat.quantities.formulas import mean_transmittance
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.surface_light import radiance_weight
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.radiometry.spherical_harmonics import ambient_of_faces
from skyshine.mat.runtime.walls import beside_walls
from skyshine.mat.surface.surroundings import WALL_EMISSIVITY
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.atmq import AMBIENT_HARMONICS, GROUND_HARMONICS
from skyshine.mat.tables.gridded import AXES
from skyshine.schemas.arrays import Booleans, Floats

LINES, FEWEST_LINES, FACES = 16, 6, 24  # lines of sight in the full scope and at least, faces at the end of each
GROUND_K = (250.0, 340.0)  # temperatures of the ground, at random between
WALLED = 0.5  # share of the faces beside a wall
SKY_VIEWS = (0.3, 0.9)  # open share of the sky above them, at random between
WALL_EXCESS_K = (-5.0, 20.0)  # excess of the wall's temperature over that of the air, at random between


@dataclass(frozen=True, eq=False)
class FaceProbes:
    """n lines of sight that end above the ground, and F faces at the end of each.

    Attributes
    ----------
    coordinates : dict of str to (n,) array
        Coordinates by the first four of `gridded.AXES`.
    normal : (n, F, 3) array
    sky_view : (n, F) array
        Open share of the sky above each face, 1 in the open.
    ground_temperature, ground_radiance : (n,) arrays
        K; emitted by the ground in the band, W m^-2 sr^-1.
    wall, even : (n, F) and (n, 1) arrays
        Emitted in the band by black bodies at the temperatures of walls and air, W m^-2 sr^-1.
    transmittance : (n,) array
        Transmittance of the path.
    truth : (n, F) array
        Ambient radiance, W m^-2 sr^-1.
    """

    coordinates: dict[str, Floats]
    normal: Floats
    sky_view: Floats
    ground_temperature: Floats
    ground_radiance: Floats
    wall: Floats
    even: Floats
    transmittance: Floats
    truth: Floats

    @classmethod
    def drawn(
        cls, atmosphere: BandAtmosphere, base: PathGrid, irradiance: Floats, generator: np.random.Generator
    ) -> FaceProbes:
        """Draw lines between the ends of the job's own axes and compute the light on faces at their ends, of those that
        end on the ground there.
        """
        air, band = atmosphere.air, atmosphere.band
        count = atmosphere.scope.lines(LINES, FEWEST_LINES)
        scene_lines = SceneLines.drawn(air.shells, base, count, generator)
        altitude, elevation, steps = scene_lines.altitude_km, scene_lines.elevation_deg, scene_lines.range_km.shape[1]
        step = np.where(scene_lines.on_ground, steps - 1, generator.permutation(count) % steps)
        distance = scene_lines.range_km[np.arange(count), step]
        source = random_coordinates(base.source_elevation_deg, count, generator)
        normal = generator.normal(size=(count, FACES, 3))
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        kelvin = generator.uniform(*GROUND_K, count)
        walled = generator.random((count, FACES)) < WALLED
        sky_view = np.where(walled, generator.uniform(*SKY_VIEWS, (count, FACES)), 1.0)
        facing = air.state.surface_temperature + generator.uniform(*WALL_EXCESS_K, (count, FACES))
        paths = list(lines_of_sight(air, distance[:, None] * 1e3, altitude * 1e3, np.radians(elevation)))
        rows = np.flatnonzero([bool(path.valid[0]) for path in paths])
        paths = [paths[row] for row in rows]
        end = np.array([min(path.surface_altitude[0], air.shells.top) for path in paths])

        def of_faces(values: Floats) -> Floats:
            """Values (n,) of lines for each of their faces, (n F,)."""
            return np.repeat(values, FACES)

        walls = Walls(sky_view[rows].ravel(), facing[rows].ravel(), np.full(rows.size * FACES, WALL_EMISSIVITY))
        faces = Facets(normal[rows].reshape(-1, 3), of_faces(kelvin[rows]), walls=walls)
        light = light_among_walls(air, of_faces(end), of_faces(np.radians(source[rows])), irradiance, faces)
        weight = np.array([radiance_weight(band, path)[0] for path in paths]).reshape(-1, band.weight.size)
        through = np.array(
            [np.exp(mean_transmittance(path.depth, band.weight, band.weight.sum())[0][0]) for path in paths]
        )

        def glow(temperature: Floats) -> Floats:
            """Emitted in the band by black bodies, W m^-2 sr^-1."""
            radiance: Floats = planck_wavenumber(band.wavenumber, temperature[..., None]) @ band.radiance_weight
            return radiance

        emissivity = 1 - air.state.mean_albedo
        coordinates = dict(
            zip(AXES, (values[rows] for values in (distance, altitude, elevation, source)), strict=False)
        )
        return cls(
            coordinates,
            normal[rows],
            sky_view[rows],
            kelvin[rows],
            emissivity * glow(kelvin[rows]),
            glow(facing[rows]),
            np.full((rows.size, 1), glow(np.array(air.state.surface_temperature))),
            through,
            np.einsum("nfp,np->nf", light.reshape(rows.size, FACES, band.weight.size), weight),
        )

    def regions(self) -> dict[str, Booleans]:
        """Which of the errors (n, F) are of faces in the open and beside walls, by day, in twilight and by night."""
        source = np.broadcast_to(self.coordinates["source_elevation"][:, None], self.truth.shape)
        walled = self.sky_view < 1
        return {
            "day": source > 0,
            "twilight": (source <= 0) & (source > NIGHT_DEG),
            "night": source <= NIGHT_DEG,
            "open": ~walled,
            "wall": walled,
        }

    def read(self, table: AtmosphereTable) -> Floats:
        """Ambient radiance (n, F) of the faces, read from a table [W m^-2 sr^-1]."""
        at = {name: values[:, None] for name, values in self.coordinates.items()}
        path = {name: at[name] for name in AXES[:3]} | {"ground_temperature": self.ground_temperature[:, None]}
        codes, axial = (table.root.axes[name].values for name in ("harmonic", "zonal_harmonic"))
        table = table.clamped()
        light = table.value(AMBIENT_HARMONICS, **at, harmonic=codes)
        ground = table.value(GROUND_HARMONICS, **path, zonal_harmonic=axial)
        flat = table.value("ambient_radiance", **at)
        in_the_open = ambient_of_faces(
            flat, light[:, None], ground[:, None], self.ground_radiance[:, None], self.normal
        )
        upward = self.normal[..., 2]
        return np.maximum(beside_walls(in_the_open, flat, self.wall, self.even, self.sky_view, upward), 0.0)

    def errors(self, read: Floats, scale: Scale | None) -> Floats:
        """Errors (n, F) of what was read, in the scale's unit; without a scale in W m^-2 sr^-1."""
        if scale is None:
            return read - self.truth
        distance = self.coordinates["range"][:, None]
        return scale.error("ambient_radiance", read, self.truth, self.transmittance[:, None], distance)
