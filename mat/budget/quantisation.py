"""Pixel values, equation (44): gain, buffer gain and offset for a range of radiance, and the inverse.

The note says of (44) that its function int rounds to the nearest integer. The nearest to x - 1/2, halves upwards, is
the largest integer that is not above x.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Floats, Integers

BITS = (8, 12, 14, 16)


@dataclass(frozen=True)
class PixelScale:
    """Settings of a pixel buffer.

    Attributes
    ----------
    gain : float
        G, W m^-2 sr^-1: L/G is 1 at the highest radiance.
    buffer_gain, offset : float
        BG and DC: the lowest radiance gives pixel 0, the highest 2^bits - 1.
    """

    bits: int
    gain: float
    buffer_gain: float
    offset: float

    @classmethod
    def of(cls, lowest: float, highest: float, bits: int) -> PixelScale:
        """Settings that spread a range of radiance over all pixel values; a range of no width is one step wide."""
        if not 0 <= lowest <= highest or not np.isfinite(highest) or highest == 0:
            raise ValueError(f"no range of radiance: {lowest} to {highest}")
        offset = min(lowest / highest, 1 - 0.5**bits)
        return cls(bits, highest, 1 / (1 - offset), offset)

    @property
    def step(self) -> float:
        """Radiance from one pixel value to the next, W m^-2 sr^-1."""
        return self.gain / (self.buffer_gain * float(2**self.bits))

    def pixel(self, radiance: npt.ArrayLike) -> Integers:
        """Pixel values of radiances, (44); L/G is clipped to 0 to 1, and the value to the range of the buffer.

        Raises
        ------
        ValueError
            A radiance is not a number.
        """
        share = np.clip(np.asarray(radiance, float) / self.gain, 0.0, 1.0)
        if np.any(np.isnan(share)):
            raise ValueError("a radiance is not a number")
        value = np.floor(2**self.bits * self.buffer_gain * (share - self.offset))
        pixel: Integers = np.clip(value, 0, 2**self.bits - 1).astype(np.int64)
        return pixel

    def radiance(self, pixel: npt.ArrayLike) -> Floats:
        """Radiance in the middle of those that give a pixel value, W m^-2 sr^-1."""
        middle = np.asarray(pixel) + 0.5
        radiance: Floats = self.gain * (middle / (2**self.bits * self.buffer_gain) + self.offset)
        return radiance
