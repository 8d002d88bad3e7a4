"""The horizon around a place, and how much of sky, walls and ground a plane sees under it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.schemas.arrays import Booleans, Floats
from skyshine.schemas.errors import InputError

ASPECTS = np.arange(0.0, 360.0, 45.0)  # degree: directions that walls face; walls between two are shared by them
# Azimuths over which view factors are summed: 1e-6 of the view that integrals in closed form have.
_AZIMUTHS = 1440


@dataclass(frozen=True)
class Horizon:
    """Elevation of the horizon by azimuth, linear between the nodes and periodic.

    Attributes
    ----------
    azimuth : tuple of float
        Azimuths from north eastward, increasing, 0 to below 360 [degree].
    elevation : tuple of float
        0 (level) to 90 (no sky there) [degree].

    Raises
    ------
    InputError
        An azimuth or elevation is outside its limits.
    """

    azimuth: tuple[float, ...] = (0.0,)
    elevation: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        azimuth, elevation = np.asarray(self.azimuth, float), np.asarray(self.elevation, float)
        if azimuth.size == 0 or azimuth.shape != elevation.shape:
            raise InputError(f"found {azimuth.size} azimuths and {elevation.size} elevations; allowed: as many of both")
        if not (np.all(np.diff(azimuth) > 0) and azimuth[0] >= 0 and azimuth[-1] < 360):
            raise InputError(f"found azimuths {list(self.azimuth)}; allowed: 0 to below 360 degree, ascending")
        if not np.all((elevation >= 0) & (elevation <= 90)):
            raise InputError(f"found elevations {list(self.elevation)}; allowed: 0 to 90 degree")

    @property
    def level(self) -> bool:
        """Whether nothing is above the level horizon."""
        return not any(self.elevation)

    def at(self, azimuth: Floats) -> Floats:
        """Elevation [degree] at azimuths [degree]."""
        elevation: Floats = np.interp(azimuth, self.azimuth, self.elevation, period=360.0)
        return elevation

    def hides(self, elevation: Floats, azimuth: Floats) -> Booleans:
        """Whether a source at an elevation and azimuth [degree] is behind the horizon.

        A level horizon hides nothing: what is below it shines on no surface anyway.
        """
        top = self.at(azimuth)
        hidden: Booleans = (top > 0) & (elevation <= top)
        return hidden


LEVEL = Horizon()


@dataclass(frozen=True, eq=False)
class ViewFactors:
    """View factors of P planes; sky, walls and ground sum to 1.

    Attributes
    ----------
    sky : (P,) ndarray
        View factor of the open sky.
    walls : (P, 8) ndarray
        View factors of walls that face each of `ASPECTS`: those in the opposite direction.
    ground : (P,) ndarray
        View factor of everything below the level horizon.
    """

    sky: Floats
    walls: Floats
    ground: Floats

    def received(self, radiosity: Floats) -> Floats:
        """Irradiance (A, P, N) of the planes by what leaves the ground and walls of each aspect, (A, 9, N), per area of
        theirs.
        """
        irradiance: Floats = np.column_stack([self.ground, self.walls]) @ radiosity
        return irradiance

    @classmethod
    def of(cls, horizon: Horizon, sky_view: float, slope: Floats, azimuth: Floats) -> ViewFactors:
        """What planes see.

        Parameters
        ----------
        horizon : Horizon
            Walls reach from the level up to it.
        sky_view : float
            Open share of the sky above the horizon, 0 to 1; walls hide the rest in all directions alike.
        slope, azimuth : (P,) ndarray
            [degree]

        Notes
        -----
        A lune of azimuth A and width dA has, between two elevations in front of the plane, the view factor dA / pi
        times the difference of (k sin^2 e + c (e + sin(2e) / 2)) / 2 at both, k = cos(slope),
        c = sin(slope) cos(A - azimuth): the cosine of incidence times the solid angle, integrated over elevation. Sums
        over azimuth are scaled to the (1 + cos(slope)) / 2 of the whole sky.
        """
        bearings = (np.arange(float(_AZIMUTHS)) + 0.5) * (360.0 / _AZIMUTHS)
        above = 0.5 * (1 + np.cos(np.radians(slope)))
        top = np.radians(horizon.at(bearings))
        across = np.sin(np.radians(slope))[:, None] * np.cos(np.radians(bearings - np.asarray(azimuth)[:, None]))
        up = np.cos(np.radians(slope))[:, None]
        lowest, highest = _front(up, across)
        lowest = np.maximum(lowest, 0.0)
        highest = np.maximum(highest, lowest)
        edge = np.clip(top, lowest, highest)
        below, upper, bottom = (_antiderivative(up, across, at) for at in (edge, highest, lowest))
        sky, hidden = upper - below, below - bottom
        total = (sky + hidden).sum(axis=1)
        scale = np.divide(above, total, out=np.zeros_like(above), where=total > 0)[:, None]
        walls = scale * (hidden + (1 - sky_view) * sky) @ _shares(bearings + 180.0)
        return cls(sky_view * (scale * sky).sum(axis=1), walls, 1 - above)


def _front(up: Floats, across: Floats) -> tuple[Floats, Floats]:
    """Elevations [rad] between which directions are in front of planes: up sin e + across cos e > 0."""
    crossing = np.arctan2(across, up)
    lowest = np.where(up >= 0, -crossing, -0.5 * np.pi)
    highest = np.where(up >= 0, 0.5 * np.pi, np.pi - np.abs(crossing))
    highest = np.where((up < 0) & (across < 0), -highest, highest)
    return lowest, highest


def _antiderivative(up: Floats, across: Floats, elevation: Floats) -> Floats:
    """Antiderivative of (up sin e + across cos e) cos e by e."""
    integral: Floats = 0.5 * (up * np.sin(elevation) ** 2 + across * (elevation + 0.5 * np.sin(2 * elevation)))
    return integral


def _shares(azimuth: Floats) -> Floats:
    """Shares of `ASPECTS` in directions [degree], linear between the aspects: (n, 8)."""
    position = (azimuth % 360.0) / (ASPECTS[1] - ASPECTS[0])
    before = np.floor(position).astype(int)
    weight = position - before
    shares = np.zeros((azimuth.size, ASPECTS.size))
    rows = np.arange(azimuth.size)
    shares[rows, before % ASPECTS.size] += 1 - weight
    shares[rows, (before + 1) % ASPECTS.size] += weight
    return shares
