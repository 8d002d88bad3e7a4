"""The altitudes at which a state is described, and interpolation between those of a profile."""

from __future__ import annotations

import numpy as np

TOP = 100e3  # m
# Spacing of levels by height above the ground: (up to, step) in m. Water vapour halves in about 1.4 km; 250 m keeps the
# error of a property linear between levels below 0.4 %.
SPACING = ((3e3, 250.0), (12e3, 500.0), (26e3, 1e3), (50e3, 2.5e3), (TOP, 10e3))
# A level of the regular spacing gives way to one that is asked for and this close, m.
_CLOSE = 40.0
# Levels of a profile are added until the air between levels follows it this closely.
_TEMPERATURE_TOLERANCE, _WATER_TOLERANCE, _MOST_ADDED = 0.5, 0.1, 30  # K, relative
_STRUCTURE_TOP = 20e3  # m; above, water vapour and temperature change too little over a regular step to need more


def level_altitudes(surface_altitude, profile, edges=()):
    """Altitudes of the levels, from the ground to the top.

    Fine near the ground, with those levels of the profile that the regular ones would miss: inversions, dry layers.

    Parameters
    ----------
    surface_altitude : float
        Above sea level, m.
    profile : Profile
    edges : sequence of float
        Altitudes that must be levels, m.

    Returns
    -------
    (N,) array
        m, increasing.
    """
    altitude = _with(_regular(surface_altitude), [z for z in edges if surface_altitude < z < TOP])
    own = (profile.altitude > surface_altitude) & (profile.altitude < _STRUCTURE_TOP)
    own = profile.altitude[own & np.all(np.abs(profile.altitude[:, None] - np.array([*edges, np.inf])) > 1.0, axis=1)]
    if not own.size:
        return altitude
    water = np.maximum(profile.mole_fraction["H2O"], 1e-9)
    kinds = ((profile.temperature, linear, _TEMPERATURE_TOLERANCE), (np.log(water), linear, _WATER_TOLERANCE))
    for _ in range(_MOST_ADDED):
        # How far the straight lines between the levels are from the profile at its own levels, in tolerances.
        off = np.zeros(own.size)
        for values, interpolate, tolerance in kinds:
            at_levels = interpolate(altitude, profile.altitude, values)
            here = np.interp(own, altitude, at_levels) - interpolate(own, profile.altitude, values)
            off = np.maximum(off, np.abs(here) / tolerance)
        if off.max() <= 1.0:
            break
        altitude = _with(altitude, [own[np.argmax(off)]], keep=edges)
    return altitude


def linear(points, nodes, values):
    """Linear interpolation; below the first node the lowest layer is continued."""
    slope = (values[1] - values[0]) / (nodes[1] - nodes[0])
    below = values[0] + slope * (points - nodes[0])
    return np.where(points < nodes[0], below, np.interp(points, nodes, values))


def exponential(points, nodes, values):
    """Interpolation linear in the logarithm, in which a 0 stays 0."""
    tiny = np.finfo(float).tiny
    result = np.exp(linear(points, nodes, np.log(np.maximum(values, tiny))))
    return np.where(result <= 2 * tiny, 0.0, result)


def _regular(surface_altitude):
    pieces, start = [], surface_altitude
    for end, step in SPACING:
        # Above the boundary layer the levels stand at fixed altitudes above the sea, whatever the ground.
        end = end + surface_altitude if end <= 6e3 else end
        count = int(np.ceil((end - start) / step - 1e-9))
        if count > 0:
            pieces.append(np.linspace(start, end, count, endpoint=False))
            start = end
    return np.append(np.concatenate(pieces), TOP)


def _with(altitude, added, keep=()):
    """Levels with others in the place of those that are close by; the ends and `keep` stay."""
    added = np.unique(np.asarray(added, dtype=float))
    if not added.size:
        return altitude
    near = np.min(np.abs(altitude[:, None] - added), axis=1) < _CLOSE
    near[[0, -1]] = False
    near &= ~np.isin(altitude, keep)
    return np.unique(np.concatenate([altitude[~near], added]))
