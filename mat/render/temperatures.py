"""Temperatures of the materials that are seen, under the shade of the day before each hour."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.render.alike import alike
from skyshine.mat.render.exposure import SeenExposure
from skyshine.mat.render.seen import SeenSurface
from skyshine.mat.render.walls import WallKinds, Walls
from skyshine.mat.surface.forcing import sun_cosine
from skyshine.mat.surface.surroundings import Exposure
from skyshine.mat.tables.axes import PERIODIC, AxisRule
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.mat.tables.open_air import OpenAir
from skyshine.mat.tables.response import DAY_H, forcing_hours
from skyshine.mat.tables.shade import ABSORPTANCE
from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.progress import Progress, silent

Exposed = Callable[[SeenSurface], SeenExposure]
_BLOCK = 1024  # columns computed together
_NEAR = 1.0  # degree beyond the slopes of a table at which its last one is taken
_DIGITS = 6  # digits of altitude [km], slope and azimuth [degree], to which places count as one


@dataclass(frozen=True, eq=False)
class SeenTemperatures:
    """Temperatures of the M materials of n points at H clock hours.

    Attributes
    ----------
    present : (n, M) bool array
        Materials with a share.
    column : (u,) int array
        Column of each material that is present, in the order of `present`.
    kelvin : (P, H) array
        Temperatures of the columns [K].
    """

    present: Booleans
    column: Integers
    kelvin: Floats

    @classmethod
    def of(
        cls,
        surface: TemperatureTable,
        points: SeenSurface,
        exposure: SeenExposure,
        codes: Integers,
        shaded_sky: Floats,
        hours: Floats,
        walls: Walls | None = None,
        progress: Progress = silent,
    ) -> SeenTemperatures:
        """Read the temperatures; columns that are alike in all that counts are computed once.

        Parameters
        ----------
        exposure : SeenExposure
            Exposure at the 288 steps of the day.
        codes : (K,) int array
            Codes of the materials by their number in `points`.
        shaded_sky : (K,) array
            Open share of the sky in the shade, as `SurfaceMaterials.shaded_sky`.
        hours : (H,) array
        walls : Walls, optional
            Walls of `exposure.walls`; by default all that hides the sky has the temperature of the air.

        Raises
        ------
        InputError
            A place outside the table, or one in the shade and the table has no response to it.
        """
        present = points.materials.share > 0
        row, part = np.nonzero(present)
        number = points.materials.number[row, part]
        material, in_shade = codes[number], np.isfinite(shaded_sky[number])
        view = np.fmin(exposure.sky_view[row], shaded_sky[number])
        coordinates: Floats = np.stack([points.altitude[row], points.azimuth[row], points.slope[row], view], axis=-1)
        rounded = np.asarray(np.round(coordinates, _DIGITS), np.float64) + 0.0
        shaded = exposure.shaded[row] | in_shade[:, None]
        shares = np.zeros((row.size, 0))
        if walls is not None:
            # What hides the sky beside the faces of the scene is not known.
            hidden = np.divide(1 - exposure.sky_view[row], 1 - view, out=np.zeros(row.size), where=view < 1)
            shares = exposure.walls[row] * hidden[:, None]
        representative, column = alike(material, rounded, np.packbits(shaded, axis=1), shares)
        kelvin = np.empty((representative.size, hours.size))
        with progress(representative.size, "surface temperatures") as advance:
            for start in range(0, representative.size, _BLOCK):
                chosen = representative[start : start + _BLOCK]
                before = None if walls is None else (walls, shares[chosen])
                kelvin[start : start + _BLOCK] = _columns(
                    surface, material[chosen], rounded[chosen], shaded[chosen], hours, before
                )
                advance(chosen.size)
        return cls(present, column, kelvin)

    def at(self, hour: int) -> Floats:
        """Temperatures (n, M) [K] at an hour by its number; unused materials have that of the first used one."""
        kelvin = np.zeros(self.present.shape)
        kelvin[self.present] = self.kelvin[self.column, hour]
        default = np.take_along_axis(kelvin, self.present.argmax(axis=1)[:, None], axis=1)
        return np.where(self.present, kelvin, default)


def _columns(
    surface: TemperatureTable,
    material: Integers,
    coordinates: Floats,
    shaded: Booleans,
    hours: Floats,
    before: tuple[Walls, Floats] | None,
) -> Floats:
    """Temperatures (P, H) [K] of P columns at places (P, 4): altitude, azimuth, slope and sky view; before walls by the
    shares (P, K) that they hide.
    """
    where = {"material": material} | dict(zip(("altitude", "azimuth", "slope"), coordinates.T[:3], strict=True))
    kelvin = surface.temperature(**{name: values[:, None] for name, values in where.items()}, time=hours[None, :])
    rows = np.flatnonzero(shaded.any(axis=1) | (coordinates[:, 3] < 1))
    if rows.size:
        exposure = Exposure(shaded[rows].astype(float), coordinates[rows, 3:])
        if before is not None:
            walls, shares = before
            air = OpenAir.of(surface.root).air_temperature(coordinates[rows, 0])
            facing, light = walls.before(shares[rows], air)
            exposure = replace(exposure, facing=facing, wall_light=light)
        change = surface.exposed_change(exposure, **{name: values[rows] for name, values in where.items()})
        kelvin[rows] = surface.temperature(
            **{name: values[rows, None] for name, values in where.items()},
            time=hours[None, :],
            absorbed_change=change[:, None, :],
        )
    return kelvin


def walls_of_day(
    surface: TemperatureTable, kinds: WallKinds, exposed: Exposed, codes: Integers, shaded_sky: Floats
) -> Walls:
    """Walls by the heat balance of some of their faces, whose own walls are as warm as the air.

    Parameters
    ----------
    exposed : callable
        Shade of the day and open sky of points.
    codes, shaded_sky : (K,) array
        Codes and open shares, as for `SeenTemperatures.of`.
    """
    points, wall = kinds.faces()
    exposure, hours = exposed(points), forcing_hours()
    time = AxisRule.of("time", surface.root.axes["time"])
    inside = np.ones(hours.size, bool)
    if time.interpolation != PERIODIC:
        inside = np.mod(hours - time.nodes[0], DAY_H) <= time.nodes[-1] - time.nodes[0]
    nearest = np.where(inside, hours, surface.root.axes["time"].values[0])
    sky = OpenAir.of(surface.root)
    # Faces that no pixel sees may lie beyond the axes: those of other slopes are as warm as the air.
    kelvin = SeenTemperatures.of(surface.clamped(), points, exposure, codes, shaded_sky, nearest)
    slopes = np.asarray(surface.root.axes["slope"].values, float)
    tabulated = inside & ((points.slope >= slopes[0] - _NEAR) & (points.slope <= slopes[-1] + _NEAR))[:, None]
    of_face = np.where(tabulated, kelvin.kelvin[kelvin.column], sky.air_temperature(points.altitude))
    without_walls = Exposure(exposure.shaded.astype(float), exposure.sky_view[:, None])
    position = points.altitude, points.azimuth, points.slope
    light = sky.sunlight(without_walls, *position, float(surface.attributes.get("ground_albedo", 0.0)))
    code = codes[points.materials.number[:, 0]]
    absorptance = surface.value(ABSORPTANCE, material=code)
    cosine = sun_cosine(points.slope[:, None], points.azimuth[:, None], sky.elevation, sky.azimuth)
    beam = cosine * ~exposure.shaded * (sky.elevation > 0)
    number = np.arange(len(kinds))
    means = (wall == number[:, None]) / np.maximum(np.bincount(wall, minlength=number.size), 1)[:, None]
    representative = np.argmax(wall == number[:, None], axis=1)
    return Walls(
        code[representative],
        (means @ of_face**4) ** 0.25,
        means @ ((1 - absorptance)[:, None] * light),
        means @ beam,
    )
