"""The film of water on a face through a day: the march of schemas/formats/htt-1.md."""

from __future__ import annotations

import math

import numpy as np

from .axis import Floats

RETURNS, DAYS = 1e-9, 30  # of the capacity, by which a film that returns may differ; days marched through at most


class Film:
    """The film on one face.

    Attributes
    ----------
    loss, evaporation : (steps, offsets) ndarray
        Heat loss of a whole film above that of the dry face [W m^-2]; water that it loses [kg m^-2 s^-1].
    sunlight, dry_sunlight : (steps,) ndarray
        Absorbed above that of the dry face, and by that [W m^-2].
    rain : (steps,) ndarray
        [kg m^-2 s^-1]
    capacity : float
        [kg m^-2]
    before : float or None
        Water at midnight before the day [kg m^-2]; None: the film returns after the day.
    """

    def __init__(
        self,
        loss: Floats,
        evaporation: Floats,
        sunlight: Floats,
        dry_sunlight: Floats,
        rain: Floats,
        capacity: float,
        before: float | None,
    ) -> None:
        self.loss, self.evaporation, self.sunlight, self.dry_sunlight = loss, evaporation, sunlight, dry_sunlight
        self.rain, self.capacity, self.before = rain, capacity, before
        self.returns = before is None
        self.scale = 86400.0 / rain.size / capacity

    def light(self, absorbed: Floats) -> Floats:
        """Sunlight that a whole film absorbs more under a change of heat."""
        left = np.divide(absorbed, self.dry_sunlight, out=np.zeros(absorbed.size), where=self.dry_sunlight > 0)
        result: Floats = self.sunlight * np.clip(1 + left, 0, 1)
        return result

    def shares(self, evaporation: Floats, water: float) -> tuple[Floats, float]:
        """Share that the film covers at each step, and the water at the end of the day over the capacity."""
        gain = (np.maximum(-evaporation, 0.0) + self.rain) * self.scale
        loss = np.maximum(evaporation, 0.0) * self.scale
        covered = np.zeros(gain.size)
        for step in range(gain.size):
            side = root(float(loss[step]), water + float(gain[step]))
            covered[step], water = side * side, side**3
        return covered, water

    def in_the_open(self, evaporation: Floats) -> tuple[Floats, float, float]:
        """Share at each step of the file's own day, the water before it and at its end."""
        if self.before is not None:
            start = min(self.before / self.capacity, 1.0)
            return *self.shares(evaporation, start)[:1], start, start
        end = 0.0
        for _ in range(DAYS):
            start = end
            covered, end = self.shares(evaporation, start)
            if end - start <= RETURNS:
                break
        return covered, start, end


def root(loss: float, water: float) -> float:
    """The root r of r^3 + loss r^2 = water, 0 to 1, by Newton's method from above."""
    if water <= 0:
        return 0.0
    side = math.cbrt(water) if loss <= 0 else min(math.cbrt(water), math.sqrt(water / loss))
    for _ in range(60):
        change = (side * side * (side + loss) - water) / (side * (3 * side + 2 * loss))
        side -= change
        if abs(change) <= 1e-16 * side:
            break
    return min(side, 1.0)
