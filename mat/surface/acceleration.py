"""Steps of an iteration of many columns: Anderson acceleration, and Newton's step by each column's own slopes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.schemas.arrays import Floats, Reals

_INNER = 2  # corrections of a step by the common matrix towards one by own slopes


@dataclass(frozen=True, eq=False)
class OwnSlopes:
    """Newton's step by each column's own slopes d from that by the common ones g.

    x = (diag(d) + C)^-1 r is found from c = (diag(g) + C)^-1 r by x <- x + s (c - x - (diag(g) + C)^-1 (d - g) x). With
    the common matrix's diagonal k of C the factor s = (g + k) / (d + k) is exact without conduction, and 1 where it
    leaves slopes no weight.
    """

    excess: Reals
    stretch: Reals
    inverse: Reals

    @classmethod
    def of(cls, slope: Reals, common: Reals, stiffness: Reals, inverse: Reals) -> OwnSlopes:
        """That of slopes (columns, N) [W m^-2 K^-1].

        Parameters
        ----------
        slope : (columns, N) ndarray
            d [W m^-2 K^-1].
        common : (N,) ndarray
            g.
        stiffness : (1,) ndarray
            k.
        inverse : (N, N) ndarray
            Transposed.
        """
        column_slope, stretch = np.maximum(slope, 0.0), common + stiffness
        return cls(column_slope - common, stretch / (column_slope + stiffness), inverse)

    def step(self, common: Reals) -> Reals:
        """The step x (columns, N) [K] from the common one c."""
        step = common * self.stretch
        for _ in range(_INNER):
            correction = (step * self.excess) @ self.inverse
            correction += step
            np.subtract(common, correction, out=correction)
            correction *= self.stretch
            step += correction
        return step


def steeper(
    slope: Reals, change: Reals, unknown: Reals, loss: Reals, last_change: Reals, previous: Reals, last_loss: Reals
) -> Reals:
    """Slopes, where the last step went too far at least the mean one over it: steps across a bend do not cycle then."""
    step = unknown - previous
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = (loss - last_loss) / step
    beyond = (change * last_change < 0) & (mean > slope)
    result: Reals = np.where(beyond, mean, slope)
    return result


class Anderson:
    """Anderson acceleration of depth two, each column its own.

    References
    ----------
    Walker and Ni (2011), Anderson acceleration for fixed-point iterations, SIAM J. Numer. Anal. 49, 1715-1735.
    """

    def __init__(self) -> None:
        self.last: tuple[Reals, Reals] | None = None
        self.steps: list[tuple[Reals, Reals]] = []

    def next(self, target: Reals, change: Reals) -> Reals:
        """The next iterate from G(x) and G(x) - x; `target` and `change` are kept, not copied."""
        if self.last is not None:
            self.steps = [(target - self.last[0], change - self.last[1]), *self.steps[:1]]
        self.last = target, change
        if not self.steps:
            return target
        bend = self.steps[0][1]
        square = _dot(bend, bend)
        with np.errstate(divide="ignore", invalid="ignore"):
            single = len(self.steps) == 1
            weights = [_dot(bend, change) / square] if single else self._two(square, bend, change)
        result = target.copy()
        for weight, (step, _) in zip(weights, self.steps, strict=True):
            result -= np.where(np.isfinite(weight), weight, 0.0).astype(step.dtype)[:, None] * step
        return result

    def _two(self, square: Floats, bend: Reals, change: Reals) -> list[Floats]:
        """Weights of both steps; `square` is the square of the newer bend."""
        older = self.steps[1][1]
        second, cross = _dot(older, older), _dot(bend, older)
        right, right_older = _dot(bend, change), _dot(older, change)
        determinant = square * second - cross**2
        # Nearly parallel differences carry one direction only.
        single = determinant < np.sqrt(np.finfo(change.dtype).eps) * square * second
        newer = np.where(single, right / square, (second * right - cross * right_older) / determinant)
        two = np.where(single, 0.0, (square * right_older - cross * right) / determinant)
        return [newer, two]


def _dot(a: Reals, b: Reals) -> Floats:
    product: Floats = np.einsum("ct,ct->c", a, b).astype(float)
    return product
