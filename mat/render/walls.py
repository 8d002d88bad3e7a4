"""What hides the sky of the points that are seen: how warm it is, and how much sunlight it reflects, by the hour.

All faces of one material that look to nearly the same side count as one wall, with the mean of a few of its faces.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from skyshine.mat.quantities.lines_of_sight import slope_and_azimuth
from skyshine.mat.render.databases import BandTables
from skyshine.mat.render.rays import start_height
from skyshine.mat.render.seen import SeenSurface
from skyshine.mat.render.surface import Mixtures, SurfaceMaterials
from skyshine.mat.render.surface_mesh import SurfaceMesh
from skyshine.mat.runtime.walls import wall_as_it_shines
from skyshine.mat.surface.surroundings import WALL_EMISSIVITY
from skyshine.mat.tables.response import DAY_H, FORCING_STEPS
from skyshine.schemas.arrays import Floats, Integers

if TYPE_CHECKING:
    from skyshine.mat.quantities.lines_of_sight import LinesOfSight

_SLOPE_STEP, _AZIMUTH_STEP = (
    30.0,
    45.0,
)  # degree between the directions of walls, chosen: eight aspects, as horizons have
FACES = 4  # faces of a wall whose heat balance is read; chosen


class WallKinds:
    """Numbers the walls of a surface as rays meet them."""

    def __init__(self, surface: SurfaceMesh, materials: SurfaceMaterials) -> None:
        self._surface, self._materials = surface, materials
        sides = 2 * len(surface.triangles)
        self._kind, self._met = np.full(sides, -2), np.zeros(sides, int)
        self._numbers: dict[tuple[int, int, int], int] = {}

    def __len__(self) -> int:
        return len(self._numbers)

    def of(self, face: Integers, ahead: Floats) -> Integers:
        """Number of the wall that each ray (n,) in directions (n, 3) meets; -1 where its material is not known."""
        back = np.sum(self._surface.normal[face] * ahead, axis=-1) > 0
        side = 2 * face + back
        new = np.unique(side[self._kind[side] == -2])
        if new.size:
            slope, azimuth = slope_and_azimuth(self._normal(new))
            tilt = np.round(slope / _SLOPE_STEP).astype(int)
            turn = np.round(azimuth / _AZIMUTH_STEP).astype(int) % round(360 / _AZIMUTH_STEP)
            turn[(tilt == 0) | (tilt == round(180 / _SLOPE_STEP))] = 0
            material = self._materials.of_faces(new // 2)
            for index, key in zip(new, zip(material.tolist(), tilt.tolist(), turn.tolist(), strict=True), strict=True):
                self._kind[index] = -1 if key[0] < 0 else self._numbers.setdefault(key, len(self._numbers))
        np.add.at(self._met, side, 1)
        kind: Integers = self._kind[side]
        return kind

    def _normal(self, side: Integers) -> Floats:
        normal: Floats = self._surface.normal[side // 2] * np.where(side % 2, -1.0, 1.0)[:, None]
        return normal

    def faces(self) -> tuple[SeenSurface, Integers]:
        """Centres of those faces of each wall that most rays met, at most `FACES`, and the wall of each (R,)."""
        chosen = [
            sides[np.argsort(-self._met[sides], kind="stable")[:FACES]]
            for sides in (np.flatnonzero(self._kind == kind) for kind in range(len(self)))
        ]
        side = np.concatenate([np.zeros(0, int), *chosen])
        surface, normal = self._surface, self._normal(side)
        point = surface.triangles[side // 2].mean(axis=1)
        slope, azimuth = slope_and_azimuth(normal)
        number = self._materials.of_faces(side // 2)[:, None]
        points = SeenSurface(
            np.arange(side.size),
            side // 2,
            np.full((side.size, 3), 1 / 3),
            point,
            normal,
            point + normal * start_height(surface),
            np.ones(side.size),
            slope,
            azimuth,
            surface.altitude + point[:, 2] * 1e-3,
            Mixtures(self._materials.names, number, np.ones(number.shape)),
        )
        return points, self._kind[side]


@dataclass(frozen=True, eq=False)
class Walls:
    """K walls at the 288 steps of the day.

    Attributes
    ----------
    code : (K,) int array
        Codes of the walls' materials.
    temperature, light, beam : (K, 288) array
        Temperatures of the walls [K]; reflected sunlight [W m^-2]; share of the direct light on a surface across
        it that falls on them.
    """

    code: Integers
    temperature: Floats
    light: Floats
    beam: Floats

    def before(self, shares: Floats, air: Floats) -> tuple[Floats, Floats]:
        """Temperature of all that hides the sky of surfaces, and sunlight that it reflects, (P, 288) each.

        Parameters
        ----------
        shares : (P, K) array
            Shares of the hidden sky; the rest has the temperature of the air.
        air : (P, 288) array
            [K]
        """
        remainder = 1 - shares.sum(axis=1, keepdims=True)
        kelvin: Floats = (shares @ self.temperature**4 + remainder * air**4) ** 0.25
        return kelvin, shares @ self.light

    def in_band(
        self,
        tables: BandTables,
        shares: Floats,
        hour: float,
        lines: LinesOfSight,
        air: float,
        ground: float,
        *,
        sun: bool,
    ) -> Floats:
        """Temperature (n,) [K] of a wall of `WALL_EMISSIVITY` that shines in a band as all that hides the sky of faces.

        Parameters
        ----------
        shares : (n, K) array
            Shares of the hidden sky, as in `before`.
        hour : float
            Local clock.
        lines : LinesOfSight
            One, to where the light is read.
        air, ground : float
            Temperatures [K].
        sun : bool
            Whether the direct light is that of the Sun.
        """
        band = tables.band
        step = hour / DAY_H * FORCING_STEPS
        before, weight = int(step) % FORCING_STEPS, step - int(step)
        kelvin, beam = (
            (1 - weight) * values[:, before] + weight * values[:, (before + 1) % FORCING_STEPS]
            for values in (self.temperature, self.beam)
        )
        level, direct = (
            float(tables.air.value(name, **lines.lit)[0]) for name in ("ambient_radiance", "direct_radiance")
        )
        black = band.blackbody_radiance(np.array([ground, air, *kelvin]))
        emissivity = 1 - band.clamped().value("reflectance_planck", material=self.code, planck_temperature=kelvin)
        reflectance, remainder = band.value("reflectance", material=self.code), 1 - shares.sum(axis=1)
        return wall_as_it_shines(
            band,
            shares @ (emissivity * black[2:]) + remainder * WALL_EMISSIVITY * black[1],
            shares @ (1 - emissivity) + remainder * (1 - WALL_EMISSIVITY),
            0.5 * (level + black[0]),
            shares @ (reflectance * beam) * direct * sun,
        )
