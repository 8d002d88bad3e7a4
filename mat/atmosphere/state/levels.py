"""The altitudes at which a state is described, and interpolation between those of a profile."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.state.profiles import Profile
from skyshine.schemas.arrays import Floats

TOP = 100e3  # m
# Spacing of levels by height above the ground: (up to, step) in m. Water vapour halves in about 1.4 km; 250 m keeps the
# error of a property linear between levels below 0.4 %.
SPACING = ((3e3, 250.0), (12e3, 500.0), (26e3, 1e3), (50e3, 2.5e3), (TOP, 10e3))
# A level of the regular spacing gives way to one that is asked for, or of the profile, and this close, m.
_CLOSE = 40.0
# Levels of a profile are added until the air between levels follows it this closely.
_TEMPERATURE_TOLERANCE, _WATER_TOLERANCE, _MAX_ADDED = 0.5, 0.1, 30  # K, relative
# Optical depth at 0.55 um of a layer of particles at their edge, its share of the depth from there further inside, and
# least distance [m] between levels: light that is scattered changes most where particles begin.
_EDGE_DEPTH, _DEPTH_SHARE, _LEAST_STEP = 0.1, 0.7, 1.0
_STRUCTURE_TOP = 20e3  # m; above, water vapour and temperature change too little over a regular step to need more


def level_altitudes(surface_altitude: float, profile: Profile, edges: Sequence[float] = ()) -> Floats:
    """Altitudes of the levels, from the ground to the top.

    Fine near the ground, with those levels of the profile that the regular ones would miss: inversions, dry layers.

    Parameters
    ----------
    surface_altitude : float
        Above sea level, m.
    edges : sequence of float
        Altitudes that must be levels, m.

    Returns
    -------
    (N,) array
        m, increasing.
    """
    altitude = _with(_regular(surface_altitude), [z for z in edges if surface_altitude < z < TOP])
    inside = (profile.altitude > surface_altitude) & (profile.altitude < _STRUCTURE_TOP)
    inside &= np.all(np.abs(profile.altitude[:, None] - np.array([*edges, np.inf])) > 1.0, axis=1)
    candidates = profile.altitude[inside]
    if not candidates.size:
        return altitude
    water = np.maximum(profile.mole_fraction["H2O"], 1e-9)
    structure = ((profile.temperature, _TEMPERATURE_TOLERANCE), (np.log(water), _WATER_TOLERANCE))
    protected = list(edges)
    for _ in range(_MAX_ADDED):
        # How far the straight lines between the levels are from the profile at its own levels, in tolerances.
        deviation = np.zeros(candidates.size)
        for values, tolerance in structure:
            at_levels = linear(altitude, profile.altitude, values)
            difference = np.interp(candidates, altitude, at_levels) - linear(candidates, profile.altitude, values)
            deviation = np.maximum(deviation, np.abs(difference) / tolerance)
        if deviation.max() <= 1.0:
            break
        level = candidates[np.argmax(deviation)]
        altitude = _with(altitude, [level], keep=protected)
        protected.append(level)  # close levels of a profile are its structure: none gives way to another
    return altitude


def with_particles(altitude: Floats, extinction: Floats) -> Floats:
    """Levels with further ones where particles are dense, as scattered light needs them.

    Parameters
    ----------
    altitude : (N,) array
        m.
    extinction : (N,) array
        Extinction of one kind of particle at 0.55 um at the levels, m^-1; linear between.

    Returns
    -------
    (more,) array
        m, increasing.
    """
    layer = 0.5 * (extinction[1:] + extinction[:-1]) * np.diff(altitude)
    depth = np.append(0.0, np.cumsum(layer))
    total = depth[-1]
    inside = np.minimum(depth, total - depth)
    coarse = layer > np.maximum(_EDGE_DEPTH, _DEPTH_SHARE * np.minimum(inside[1:], inside[:-1]))
    if not np.any(coarse):
        return altitude
    steps = [0.0]
    while steps[-1] < 0.5 * total:
        steps.append(steps[-1] + max(_EDGE_DEPTH, _DEPTH_SHARE * steps[-1]))
    targets = np.unique(np.clip([*steps, *(total - np.array(steps))], 0.0, total))
    fine = np.linspace(0.0, 1.0, 65)[:-1]
    added: list[float] = []
    for k in np.flatnonzero(coarse):
        # Depth is a square of altitude inside a layer; a table of it is inverted.
        slope = 0.5 * (extinction[k + 1] - extinction[k]) * fine
        through = depth[k] + (extinction[k] + slope) * fine * (altitude[k + 1] - altitude[k])
        for level in np.interp(targets[(targets > depth[k]) & (targets < depth[k + 1])], through, fine):
            height = altitude[k] + level * (altitude[k + 1] - altitude[k])
            if np.min(np.abs(np.append(altitude, added) - height)) >= _LEAST_STEP:
                added.append(float(height))
    return np.sort(np.append(altitude, added))


def linear(points: npt.ArrayLike, nodes: Floats, values: Floats) -> Floats:
    """Linear interpolation; below the first node the lowest layer is continued."""
    points = np.asarray(points, dtype=float)
    slope = (values[1] - values[0]) / (nodes[1] - nodes[0])
    below = values[0] + slope * (points - nodes[0])
    result: Floats = np.where(points < nodes[0], below, np.interp(points, nodes, values))
    return result


def exponential(points: npt.ArrayLike, nodes: Floats, values: Floats) -> Floats:
    """Interpolation linear in the logarithm, in which a 0 stays 0."""
    tiny = np.finfo(float).tiny
    result = np.exp(linear(points, nodes, np.log(np.maximum(values, tiny))))
    return np.where(result <= 2 * tiny, 0.0, result)


def _regular(surface_altitude: float) -> Floats:
    pieces, start = [], surface_altitude
    for end, step in SPACING:
        # Above the boundary layer the levels have fixed altitudes above the sea, whatever the ground.
        above = end + surface_altitude if end <= 6e3 else end
        count = int(np.ceil((above - start) / step - 1e-9))
        if count > 0:
            pieces.append(np.linspace(start, above, count, endpoint=False))
            start = above
    return np.append(np.concatenate(pieces), TOP)


def _with(altitude: Floats, added: Sequence[float], keep: Sequence[float] = ()) -> Floats:
    """Levels with others in the place of those that are close by; the ends and `keep` stay."""
    further = np.unique(np.asarray(added, dtype=float))
    if not further.size:
        return altitude
    close = np.min(np.abs(altitude[:, None] - further), axis=1) < _CLOSE
    close[[0, -1]] = False
    close &= ~np.isin(altitude, keep)
    return np.unique(np.concatenate([altitude[~close], further]))
