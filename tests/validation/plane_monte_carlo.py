"""Backward Monte Carlo in plane layers over a black ground: radiance with its standard error, however peaked the
phase function.

Discrete ordinates of peaked phase functions do not settle near the Sun: corrections of first and second order do not
hold those after. Here photons start at the observer, are scattered by the whole phase function, never leave before they
are scattered, and each event adds the sunlight that it sends back along the path. Layers are those of
`plane_parallel.py`; nothing else is shared.
"""

from __future__ import annotations

import numba
import numpy as np

# Angles of the phase functions, closer where they are steep.
ANGLES = 2 * np.arcsin(np.linspace(0.0, 1.0, 4001) ** 2)
_LIGHT, _BATCHES = 0.02, 20


def phase_functions(moments):
    """Phase functions (n, X) at `ANGLES` of moments (n, L), mean over the sphere 1, and cumulative shares (n, X)."""
    cosine = np.cos(ANGLES)
    phase = np.zeros((len(moments), ANGLES.size))
    before, here = np.zeros_like(cosine), np.ones_like(cosine)
    for order in range(moments.shape[1]):
        phase += (2 * order + 1) * moments[:, order, None] * here
        before, here = here, ((2 * order + 1) * cosine * here - order * before) / (order + 1)
    phase = np.maximum(phase, 0.0)
    share = 0.25 * (phase[:, 1:] + phase[:, :-1]) * -np.diff(cosine)
    total = np.concatenate([np.zeros((len(phase), 1)), np.cumsum(share, axis=1)], axis=1)
    return phase / total[:, -1:], total / total[:, -1:]


def radiance(layers, depth, cosine, suns, photons, seed=0):
    """Radiance per unit of the Sun's irradiance normal to the beam, (S,) sr^-1, and its standard error (S,).

    Parameters
    ----------
    layers : plane_parallel.Layers
    depth : float
        Optical depth of the observer below the top.
    cosine : float
        Of the angle from the vertical at which the light travels that is seen, positive upward.
    suns : (S, 2) array
        Cosine of the Sun's zenith angle; azimuth of the line of sight from it, rad.
    photons : int
    """
    phase, total = phase_functions(layers.moments)
    zenith, azimuth = np.asarray(suns, float).T
    across = np.sqrt(1 - zenith**2)
    to_sun = np.stack([across * np.cos(azimuth), across * np.sin(azimuth), zenith], axis=1)
    edges = np.concatenate([[0.0], np.cumsum(layers.depth)])
    count = max(photons // _BATCHES, 1)
    generator = np.random.default_rng(seed)
    light = np.array(
        [
            _photons(edges, layers.albedo, phase, total, float(depth), -float(cosine), to_sun, count, generator)
            for _ in range(_BATCHES)
        ]
    )
    return light.mean(axis=0), light.std(axis=0, ddof=1) / np.sqrt(_BATCHES)


@numba.njit(cache=False)
def _photons(edges, albedo, phase, total, start, rise, to_sun, count, generator):
    suns, last, bins = len(to_sun), edges[-1], phase.shape[1] - 1
    light = np.zeros(suns)
    for _ in range(count):
        x, y, z = np.sqrt(1 - rise * rise), 0.0, rise
        place, weight = start, 1.0
        while True:
            reach = (place if z > 0 else last - place) / max(abs(z), 1e-12)
            met = -np.expm1(-reach)
            if met <= 0:
                break
            weight *= met
            place += (-1.0 if z > 0 else 1.0) * abs(z) * -np.log1p(-generator.random() * met)
            place = min(max(place, 0.0), last)
            layer = min(max(np.searchsorted(edges, place) - 1, 0), albedo.size - 1)
            weight *= albedo[layer]
            for s in range(suns):
                cosine = x * to_sun[s, 0] + y * to_sun[s, 1] + z * to_sun[s, 2]
                at = np.sqrt(np.sqrt(max(0.5 - 0.5 * cosine, 0.0))) * bins
                k = min(int(at), bins - 1)
                value = phase[layer, k] + (phase[layer, k + 1] - phase[layer, k]) * (at - k)
                light[s] += weight * value * np.exp(-place / to_sun[s, 2])
            if weight < _LIGHT:
                if generator.random() > weight / (2 * _LIGHT):
                    break
                weight = 2 * _LIGHT
            number = generator.random()
            k = min(max(np.searchsorted(total[layer], number) - 1, 0), bins - 1)
            step = total[layer, k + 1] - total[layer, k]
            part = (number - total[layer, k]) / step if step > 0 else 0.5
            near, far = (k / bins) ** 4, ((k + 1) / bins) ** 4
            half = near + (far - near) * part  # (1 - cosine) / 2
            turn, bend = 1 - 2 * half, 2 * np.sqrt(max(half * (1 - half), 0.0))
            around = 2 * np.pi * generator.random()
            a, b = bend * np.cos(around), bend * np.sin(around)
            level = np.sqrt(x * x + y * y)
            if level < 1e-8:
                x, y, z = a, b, turn * (1.0 if z > 0 else -1.0)
            else:
                x, y, z = (
                    turn * x + (a * x * z - b * y) / level,
                    turn * y + (a * y * z + b * x) / level,
                    turn * z - a * level,
                )
            size = np.sqrt(x * x + y * y + z * z)
            x, y, z = x / size, y / size, z / size
    return light / (4 * np.pi * count)
