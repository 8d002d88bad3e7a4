"""Temperatures of the materials that are seen, under the shade of the day before each hour."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.render.alike import alike
from skyshine.mat.render.exposure import SeenExposure
from skyshine.mat.render.seen import SeenSurface
from skyshine.mat.surface.surroundings import Exposure
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.progress import Progress, silent

_BLOCK = 1024  # columns computed together
_DIGITS = 6  # of altitude [km], slope and azimuth [degree], to which places count as one


@dataclass(frozen=True, eq=False)
class SeenTemperatures:
    """Temperatures of the M materials of n points at H clock hours.

    Attributes
    ----------
    used : (n, M) bool array
        Materials with a share.
    column : (u,) int array
        Which column each of the used materials has, in the order of `used`.
    kelvin : (P, H) array
        Of the columns [K].
    """

    used: Booleans
    column: Integers
    kelvin: Floats

    @classmethod
    def of(
        cls,
        surface: TemperatureTable,
        seen: SeenSurface,
        exposure: SeenExposure,
        codes: Integers,
        shaded_sky: Floats,
        hours: Floats,
        progress: Progress = silent,
    ) -> SeenTemperatures:
        """Read the temperatures; columns that are alike in all that counts are computed once.

        Parameters
        ----------
        surface : TemperatureTable
        seen : SeenSurface
        exposure : SeenExposure
            At the 288 steps of the day.
        codes : (K,) int array
            Of the materials by their number in `seen`.
        shaded_sky : (K,) array
            As `SurfaceMaterials.shaded_sky`.
        hours : (H,) array
        progress : callable, optional

        Raises
        ------
        InputError
            A place outside the table, or one in the shade and the table holds no response to it.
        """
        used = seen.materials.share > 0
        row, part = np.nonzero(used)
        number = seen.materials.number[row, part]
        material, under = codes[number], np.isfinite(shaded_sky[number])
        view = np.fmin(exposure.sky_view[row], shaded_sky[number])
        places: Floats = np.stack([seen.altitude[row], seen.azimuth[row], seen.slope[row], view], axis=-1)
        place = np.asarray(np.round(places, _DIGITS), np.float64) + 0.0
        shaded = exposure.shaded[row] | under[:, None]
        first, column = alike(material, place, np.packbits(shaded, axis=1))
        kelvin = np.empty((first.size, hours.size))
        with progress(first.size, "surface temperatures") as advance:
            for start in range(0, first.size, _BLOCK):
                chosen = first[start : start + _BLOCK]
                kelvin[start : start + _BLOCK] = _columns(
                    surface, material[chosen], place[chosen], shaded[chosen], hours
                )
                advance(chosen.size)
        return cls(used, column, kelvin)

    def at(self, hour: int) -> Floats:
        """Temperatures (n, M) [K] at an hour by its number; unused materials have that of the first used one."""
        kelvin = np.zeros(self.used.shape)
        kelvin[self.used] = self.kelvin[self.column, hour]
        first = np.take_along_axis(kelvin, self.used.argmax(axis=1)[:, None], axis=1)
        return np.where(self.used, kelvin, first)


def _columns(surface: TemperatureTable, material: Integers, place: Floats, shaded: Booleans, hours: Floats) -> Floats:
    """Temperatures (P, H) [K] of P columns at places (P, 4): altitude, azimuth, slope and sky view."""
    where = {"material": material} | dict(zip(("altitude", "azimuth", "slope"), place.T[:3], strict=True))
    kelvin = surface.temperature(**{name: values[:, None] for name, values in where.items()}, time=hours[None, :])
    rows = np.flatnonzero(shaded.any(axis=1) | (place[:, 3] < 1))
    if rows.size:
        exposure = Exposure(shaded[rows].astype(float), place[rows, 3:])
        change = surface.exposed_change(exposure, **{name: values[rows] for name, values in where.items()})
        kelvin[rows] = surface.temperature(
            **{name: values[rows, None] for name, values in where.items()},
            time=hours[None, :],
            absorbed_change=change[:, None, :],
        )
    return kelvin
