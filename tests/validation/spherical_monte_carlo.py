"""Backward Monte Carlo in spherical shells: radiance of lines of sight from the ground, without refraction.

Photons start at the observer, are forced to be scattered in the air or by the ground, and each event adds the sunlight
that it sends back along the path. Nothing is shared with the package but the profile it is given.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

RADIUS = 6371008.8  # m
_AT_ONCE, _STEPS, _ANGLES = 4000, 160, np.linspace(0.0, np.pi, 1801)


@dataclass(frozen=True)
class SphericalAir:
    """Levels (L,) of altitude [m], extinction [m^-1] and scattering albedo, with moments times 2 l + 1 of the phase
    function (M, L), over a Lambertian ground.
    """

    altitude: np.ndarray
    extinction: np.ndarray
    albedo: np.ndarray
    moments: np.ndarray
    ground: float

    def radiance(self, sun, elevation, azimuth, photons, orders, seed=0):
        """Radiance per unit of the Sun's irradiance and its standard error, of a line at an elevation and an azimuth
        from the Sun [rad].
        """
        generator = np.random.default_rng(seed)
        phase = np.maximum(np.polynomial.legendre.legval(np.cos(_ANGLES), self.moments), 0.0)  # (L, X)
        share = 0.5 * (phase[:, 1:] + phase[:, :-1]) * -np.diff(np.cos(_ANGLES))
        cumulative = np.concatenate([np.zeros((len(share), 1)), np.cumsum(share, axis=1)], axis=1)
        phase, cumulative = 2 * phase / cumulative[:, -1:], cumulative / cumulative[:, -1:]
        batches = [
            self._batch(generator, phase, cumulative, sun, elevation, azimuth, orders)
            for _ in range(max(photons // _AT_ONCE, 2))
        ]
        light = np.concatenate(batches)
        return light.mean(), light.std() / np.sqrt(light.size)

    def _batch(self, generator, phase, cumulative, sun, elevation, azimuth, orders):
        to_sun = np.array([np.cos(sun), 0.0, np.sin(sun)])
        start = np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)
        place, direction = np.tile([0.0, 0.0, RADIUS], (_AT_ONCE, 1)), np.tile(start, (_AT_ONCE, 1))
        weight, light, row = np.ones(_AT_ONCE), np.zeros(_AT_ONCE), np.arange(_AT_ONCE)
        number = (row + generator.random(_AT_ONCE)) / _AT_ONCE
        for _ in range(orders):
            distance, depth, hits = self._along(place, direction)
            met = -np.expm1(-depth[:, -1])
            weight = np.where(hits, weight, weight * met)
            chance = np.where(hits, met, 1.0)
            in_air = number < chance
            wanted = -np.log1p(-np.minimum(number / np.maximum(chance, 1e-300), 1.0) * met * (1 - 1e-12))
            first = np.clip(np.sum(depth < wanted[:, None], axis=1) - 1, 0, depth.shape[1] - 2)
            near, far = depth[row, first], depth[row, first + 1]
            part = np.clip((wanted - near) / np.where(far > near, far - near, 1.0), 0.0, 1.0)
            length = distance[row, first] + (distance[row, first + 1] - distance[row, first]) * part
            place = place + direction * np.where(in_air, length, distance[:, -1])[:, None]
            up = place / np.linalg.norm(place, axis=1)[:, None]
            place = np.where(in_air[:, None], place, up * (RADIUS + 1e-3))
            height = np.linalg.norm(place, axis=1) - RADIUS
            level = np.interp(height, self.altitude, np.arange(self.altitude.size))
            level = np.minimum((level + generator.random(_AT_ONCE)).astype(int), self.altitude.size - 1)
            weight = weight * np.where(in_air, np.interp(height, self.altitude, self.albedo), self.ground)
            _, to_space, hidden = self._along(place, np.broadcast_to(to_sun, place.shape))
            beam = np.where(hidden, 0.0, np.exp(-to_space[:, -1]))
            angle = np.arccos(np.clip(direction @ to_sun, -1.0, 1.0)) / _ANGLES[1]
            below = np.minimum(angle.astype(int), _ANGLES.size - 2)
            scattered = phase[level, below] + (phase[level, below + 1] - phase[level, below]) * (angle - below)
            light += weight * beam * np.where(in_air, scattered / (4 * np.pi), np.maximum(up @ to_sun, 0.0) / np.pi)
            number = generator.random(_AT_ONCE)
            turn = np.arcsin(np.sqrt(number))  # from the ground, by Lambert's law
            for one in np.unique(level[in_air]):
                some = in_air & (level == one)
                turn[some] = np.interp(number[some], cumulative[one], _ANGLES)
            direction = _turned(np.where(in_air[:, None], direction, up), turn, generator)
            number = generator.random(_AT_ONCE)
        return light

    def _along(self, place, direction):
        """Distances (n, K) along rays to the top or the ground, optical depths up to them, and whether they hit it."""
        radius, rise = np.linalg.norm(place, axis=1), np.sum(place * direction, axis=1)
        top = RADIUS + self.altitude[-1]
        root = rise**2 - radius**2 + RADIUS**2
        hits = (rise < 0) & (root > 0)
        out = -rise + np.sqrt(np.maximum(rise**2 - radius**2 + top**2, 0.0))
        end = np.where(hits, np.maximum(-rise - np.sqrt(np.maximum(root, 0.0)), 0.0), out)[:, None]
        lowest, part = np.clip(-rise[:, None], 0.0, end), np.linspace(0.0, 1.0, _STEPS // 2)
        distance = np.concatenate([lowest * (1 - (1 - part) ** 2), lowest + (end - lowest) * part[1:] ** 2], axis=1)
        height = np.sqrt(np.maximum(radius[:, None] ** 2 + 2 * rise[:, None] * distance + distance**2, 0.0)) - RADIUS
        extinction = np.interp(height, self.altitude, self.extinction, right=0.0)
        pieces = 0.5 * (extinction[:, 1:] + extinction[:, :-1]) * np.diff(distance, axis=1)
        depth = np.concatenate([np.zeros((len(pieces), 1)), np.cumsum(pieces, axis=1)], axis=1)
        return distance, depth, hits


def _turned(axis, angle, generator):
    """Unit vectors at an angle from an axis, at any azimuth."""
    around = 2 * np.pi * generator.random(angle.size)
    other = np.where(np.abs(axis[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(axis, other)
    first /= np.linalg.norm(first, axis=1)[:, None]
    across = first * np.cos(around)[:, None] + np.cross(axis, first) * np.sin(around)[:, None]
    result = axis * np.cos(angle)[:, None] + across * np.sin(angle)[:, None]
    return result / np.linalg.norm(result, axis=1)[:, None]
