"""What a solver found of columns: temperatures, how good they are, and how they were found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.schemas.arrays import Floats, Integers


class Method(IntEnum):
    """How a column was solved."""

    SPECTRAL = 0
    SPECTRAL_NEWTON = 1
    BDF2 = 2
    BDF2_NEWTON = 3
    EULER = 4
    EULER_NEWTON = 5
    GIVEN = 6  # not solved: the temperature was given


@dataclass(frozen=True, eq=False)
class Solution:
    """Surface temperatures and their quality.

    Attributes
    ----------
    temperature : ndarray, shape (columns, N)
        [K] at k / N of the period, k = 0 ... N - 1.
    melt : ndarray, shape (columns, N)
        Heat spent on melting snow [W m^-2].
    residual : ndarray, shape (columns,)
        Largest imbalance at any time [W m^-2].
    energy_closure : ndarray, shape (columns,)
        Mean over the period of all fluxes [W m^-2]; 0 where the energy closes.
    bound_excess : ndarray, shape (columns,)
        How far the temperature leaves the range of its instantaneous equilibria and the back [K].
    method : ndarray of uint8, shape (columns,)
        A `Method`.
    iterations : ndarray of int32, shape (columns,)
        Beyond those that found the material's common matrix and starting point.
    film : ndarray or None, shape (columns, N) or (columns, 2 N)
        Water on the surface [kg m^-2], of leaves and then of the soil in their gaps; None where none may be.
    sources : ndarray or None, shape (columns, 2 N)
        Temperatures of leaves, then of the soil in their gaps [K], whose radiation together is that of `temperature`;
        None of a skin.
    """

    temperature: Floats
    melt: Floats
    residual: Floats
    energy_closure: Floats
    bound_excess: Floats
    method: npt.NDArray[np.uint8]
    iterations: Integers
    film: Floats | None = None
    sources: Floats | None = None

    @property
    def given(self) -> dict[str, npt.NDArray[Any]]:
        """The fields that it has, by name."""
        values = ((field.name, getattr(self, field.name)) for field in fields(self))
        return {name: array for name, array in values if array is not None}

    @classmethod
    def stacked(cls, parts: Sequence[Solution]) -> Solution:
        """The columns of several solutions, one after the other."""
        return cls(**{name: np.concatenate([part.given[name] for part in parts]) for name in parts[0].given})

    def columns(self, chosen: Integers) -> Solution:
        """The solution of an index array of columns."""
        return Solution(**{name: values[chosen] for name, values in self.given.items()})

    def with_columns(self, chosen: Integers, replacement: Solution) -> Solution:
        """The solution, into whose index array of columns that of another is written."""
        for name, values in self.given.items():
            values[chosen] = getattr(replacement, name)
        return self

    def under(self, forcing: Forcing, material: SurfaceMaterial) -> Forcing:
        """A forcing of its columns, at any number of steps, with the film that it has."""
        if self.film is None:
            return forcing
        canopy = material.canopy
        skins = [material.film] if canopy is None else [canopy.leaves.film, canopy.soil.film]
        steps = self.temperature.shape[1]
        old_times, new_times = (np.arange(count) / count for count in (steps, forcing.shape[1]))
        films = {}
        for name, skin, film in zip(
            ("film", "film_below"), skins, np.split(self.film, len(skins), axis=1), strict=False
        ):
            share = film if skin is None else skin.share(film)
            films[name] = np.stack([np.interp(new_times, old_times, row, period=1.0) for row in share])
        return replace(forcing, **films)
