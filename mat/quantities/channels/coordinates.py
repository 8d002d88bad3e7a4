"""Coordinates of a line of sight in which mean extinction and mean source are smooth: share, height, direction.

A path is given by range, altitude and elevation of the observer. On a plane Earth the mean extinction of the air to a
range depends on the heights at both ends alone. So the coordinates are the height of the observer, a share of the way,
and a direction that says how the curved Earth bends the height profile in between:

- Into the ground, at a distance d: share = range / d, direction u = (d^2 - h^2) / (2 rho h), 0 straight down and 1 at
  the horizon, for then height falls as h (1 - share) (1 - c share) with c = d^2 / (2 rho h + h^2).
- To space: share = 1 - exp(-range / l), with l the way to a height H above the observer; u = 3 + (l0 - l) / (l0 - H)
  for upward lines, with l0 that way on the level line: 3 level, 4 straight up; u = 3 - sqrt(drop / h) for lines that
  pass a lowest point at a depth `drop` below the observer: 2 at the horizon.

rho is the radius of an Earth without refraction that has the horizon of the real one at that height.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS, Shells
from skyshine.schemas.arrays import Booleans, Floats

TOP_KM = 100.0  # altitude above which there is no air
SCALE_HEIGHT_KM = 12.0  # H; half of it errs twice as much in 8-12 um
HORIZON, LEVEL, ZENITH = 2.0, 3.0, 4.0  # directions of lines to space; those into the ground lie in 0 to 1
_CLEARANCE_KM = 1e-5  # above the ground, of the lowest line to space
_FAR = 60.0  # l at which a line to space counts as ended


@dataclass(frozen=True, eq=False)
class RayPlaces:
    """Coordinates of paths; all arrays of one shape.

    Attributes
    ----------
    share, height_root, direction : arrays
        Share of the way 0 to 1, cube root of the height above the ground [km^(1/3)], direction.
    length : array
        Factor that multiplies mean extinction to give optical depth [km]: the range, or l times the share.
    to_ground : bool array
        The line meets the ground.
    ground_distance : array
        km; infinite for lines to space.
    end_height : array
        Height of the end of the path above the ground [km] on an Earth of the radius rho, 0 at and behind the ground;
        on long paths through the air kilometres too low (`end_heights`).
    """

    share: Floats
    height_root: Floats
    direction: Floats
    length: Floats
    to_ground: Booleans
    ground_distance: Floats
    end_height: Floats


@dataclass(frozen=True, eq=False)
class Entry:
    """Where lines of sight from space enter the air; arrays of one shape.

    Attributes
    ----------
    range_km, altitude_km, elevation_deg : arrays
        The rest of the path, altitude and elevation at the entry. Lines that do not enter start at the top of the air,
        upwards, with a range of 0.
    turn : array
        Angle at the centre of the Earth between the observer and the entry [rad].
    end_altitude_km : array
        Altitude of the end of paths that end in space; not a number of others.
    """

    range_km: Floats
    altitude_km: Floats
    elevation_deg: Floats
    turn: Floats
    end_altitude_km: Floats

    @classmethod
    def of(cls, range_km: npt.ArrayLike, altitude_km: npt.ArrayLike, elevation_deg: npt.ArrayLike) -> Entry:
        """Entries of straight lines from observers above `TOP_KM`; observers in the air stay where they are."""
        reach, altitude, elevation = np.broadcast_arrays(
            np.asarray(range_km, float), np.asarray(altitude_km, float), np.radians(np.asarray(elevation_deg, float))
        )
        outside = altitude > TOP_KM
        radius, top = EARTH_RADIUS / 1e3 + altitude, EARTH_RADIUS / 1e3 + TOP_KM
        rise = radius * np.sin(elevation)
        inside = rise**2 - (radius**2 - top**2)
        enters = outside & (elevation < 0) & (inside >= 0)
        way = np.where(enters, -rise - np.sqrt(np.maximum(inside, 0.0)), 0.0)
        there = np.arcsin(np.clip((rise + way) / top, -1.0, 1.0))
        in_space = outside & ~(enters & (reach > way))
        end = np.sqrt(np.maximum(radius**2 + 2 * rise * reach + reach**2, 0.0)) - EARTH_RADIUS / 1e3
        return cls(
            np.where(outside, np.where(enters, np.maximum(reach - way, 0.0), 0.0), reach),
            np.where(outside, TOP_KM, altitude),
            np.degrees(np.where(enters, there, np.where(outside, np.pi / 2, elevation))),
            np.where(enters, there - elevation, 0.0),
            np.where(in_space, end, np.nan),
        )

    def source_elevation(self, elevation_deg: npt.ArrayLike, azimuth_deg: npt.ArrayLike) -> Floats:
        """Elevation of a source at the entry [degree], from its elevation at the observer and its azimuth from the line
        of sight [degree].
        """
        up, turn = np.radians(np.asarray(elevation_deg, float)), np.radians(np.asarray(azimuth_deg, float))
        sine = np.cos(self.turn) * np.sin(up) + np.sin(self.turn) * np.cos(up) * np.cos(turn)
        at_entry = np.degrees(np.arcsin(np.clip(sine, -1.0, 1.0)))
        # Where the line does not turn, no rounding takes an elevation beyond the end of an axis.
        entered: Floats = np.where(self.turn > 0, at_entry, np.asarray(elevation_deg, float))
        return entered


@dataclass(frozen=True, eq=False)
class RayCoordinates:
    """The coordinates over one ground.

    Attributes
    ----------
    ground_km : float
        Altitude of the ground.
    height_root : (Z,) array
        Nodes, cube roots of heights [km^(1/3)].
    effective_radius : (Z,) array
        rho at the nodes [km]; linear between them.
    scale_height_km : float
        H.
    """

    ground_km: float
    height_root: Floats
    effective_radius: Floats
    scale_height_km: float = SCALE_HEIGHT_KM

    @classmethod
    def of(cls, shells: Shells, height_root: Floats) -> RayCoordinates:
        """Over the ground of some shells of air, for nodes of height."""
        ground = float(shells.altitude[0])
        # At the ground itself rho has a limit, which a height of a metre gives.
        height = np.maximum(height_root**3 * 1e3, 1.0)
        log_index = np.interp(ground + height, shells.altitude, np.log(shells.index))
        # 1 - cos(dip) = (m - m0) / m with m = n r, from the logarithms so that small heights keep their digits.
        log_ratio = log_index - np.log(shells.index[0]) + np.log1p(height / (EARTH_RADIUS + ground))
        dip = -np.expm1(-log_ratio)
        return cls(ground / 1e3, height_root, height * (1 - dip) / dip / 1e3)

    def radius_at(self, height_root: npt.ArrayLike) -> Floats:
        """rho at heights given by their cube roots [km]."""
        radius: Floats = np.interp(np.asarray(height_root, float), self.height_root, self.effective_radius)
        return radius

    def locate(self, range_km: npt.ArrayLike, altitude_km: npt.ArrayLike, elevation_deg: npt.ArrayLike) -> RayPlaces:
        """Coordinates of paths; arguments are broadcast against each other.

        Examples
        --------
        >>> rays = RayCoordinates(0.0, np.array([0.0, 2.0]), np.array([6371.0, 6371.0]))
        >>> down = rays.locate(0.5, 1.0, -90.0)
        >>> float(down.share), float(down.direction), float(down.length)
        (0.5, 0.0, 0.5)
        """
        reach, altitude, elevation = np.broadcast_arrays(
            np.asarray(range_km, float), np.asarray(altitude_km, float), np.radians(np.asarray(elevation_deg, float))
        )
        height = np.maximum(altitude - self.ground_km, 0.0)
        root = np.cbrt(height)
        rho = self.radius_at(root)
        radius, scale = rho + height, self.scale_height_km
        rise, fall = radius * np.sin(elevation), height * (2 * rho + height)
        to_ground = (elevation < 0) & (rise**2 >= fall)
        below = np.where(to_ground, np.sqrt(np.maximum(rise**2 - fall, 0.0)) - rise, 1.0)
        distance = np.where(to_ground, fall, 0.0) / below
        across = 2 * rho * height
        curved = np.clip((distance**2 - height**2) / np.where(across > 0, across, 1.0), 0.0, 1.0)
        above = scale * (2 * radius + scale)
        way = above / (rise + np.sqrt(rise**2 + above))
        level = np.sqrt(above)
        drop = 2 * radius * np.sin(elevation / 2) ** 2
        passing = LEVEL - np.sqrt(np.clip(drop / np.where(height > 0, height, 1.0), 0.0, 1.0))
        upward = LEVEL + np.clip((level - way) / (level - scale), 0.0, 1.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            part = np.where(distance > 0, reach / distance, 1.0)
        part = np.minimum(part, 1.0)
        to_space = -np.expm1(-reach / way)
        walked = np.where(to_ground, np.minimum(reach, distance), reach)
        end = (walked**2 + 2 * rise * walked + fall) / (
            rho + np.sqrt(np.maximum(radius**2 + walked**2 + 2 * rise * walked, 0.0))
        )
        return RayPlaces(
            np.where(to_ground, part, to_space),
            root,
            np.where(to_ground, curved, np.where(elevation < 0, passing, upward)),
            np.where(to_ground, reach, way * to_space),
            to_ground,
            np.where(to_ground, distance, np.inf),
            np.where(to_ground & (reach >= distance), 0.0, np.maximum(end, 0.0)),
        )

    def straight_height(self, range_km: Floats, height_root: npt.ArrayLike, elevation_deg: npt.ArrayLike) -> Floats:
        """Height of the end of a straight line above the ground [km], below 0 inside the Earth; arguments are broadcast
        against each other.
        """
        height, ground = np.asarray(height_root, float) ** 3, EARTH_RADIUS / 1e3 + self.ground_km
        rise = (ground + height) * np.sin(np.radians(np.asarray(elevation_deg, float)))
        step = range_km**2 + 2 * rise * range_km
        end: Floats = (step + height * (2 * ground + height)) / (ground + np.sqrt((ground + height) ** 2 + step))
        return end

    def line(self, height_root: float, direction: float, share: Floats) -> tuple[float, Floats, Floats]:
        """The line of sight at nodes: elevation [degree], ranges [km] and lengths [km] of shares (X,)."""
        height, rho, scale = height_root**3, float(self.radius_at(height_root)), self.scale_height_km
        radius, fall, above = rho + height, height * (2 * rho + height), scale * (2 * rho + 2 * height + scale)
        if direction <= 1:
            distance = np.sqrt(height**2 + direction * 2 * rho * height)
            sine = (fall + distance**2) / (2 * distance * radius) if distance > 0 else 1.0
            ranges = share * distance
            return -float(np.degrees(np.arcsin(min(sine, 1.0)))), ranges, ranges
        if direction < LEVEL:
            drop = min((LEVEL - direction) ** 2 * height, max(height - _CLEARANCE_KM, 0.0))
            elevation = -2 * np.arcsin(np.sqrt(drop / (2 * radius)))
        else:
            way = np.sqrt(above) - (direction - LEVEL) * (np.sqrt(above) - scale)
            elevation = np.arcsin(min((above - way**2) / (2 * way * radius), 1.0))
        rise = radius * np.sin(elevation)
        way = above / (rise + np.sqrt(rise**2 + above))
        with np.errstate(divide="ignore"):
            ranges = np.minimum(-np.log1p(-share), _FAR) * way
        return float(np.degrees(elevation)), ranges, way * share
