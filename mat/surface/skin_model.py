"""Skin temperatures under a record as a function of some of the material's parameters, with exact derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skyshine.mat.surface.back_boundary import back_drive
from skyshine.mat.surface.free_parameters import FreeParameter, parameter_values, with_values
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.record import Record, record_forcing
from skyshine.mat.surface.solver import DAY
from skyshine.mat.surface.symbolic_balance import SymbolicMaterial, forcing_rows
from skyshine.mat.surface.symbolic_column import Collocation, cell_shares, collocation_points, grid, rate_function
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

LONGEST_INTERVAL = 3600.0  # s
_DEGREE = 2  # degree of the Radau collocation
_CELLS = 16  # in each layer
_TOLERANCE = 1e-6  # K, of Newton's last step


@dataclass(frozen=True, eq=False)
class SkinModel:
    """A level surface under a record that repeats.

    Attributes
    ----------
    material : SurfaceMaterial
        Does not melt.

    Notes
    -----
    The weather is linear between the record's times. The finite volumes and the collocation are those of the oracle; on
    intervals of at most an hour they and the solver, at its own steps, agree to some hundredths of a kelvin.

    Raises
    ------
    InputError
        The surface is snow.
    """

    material: SurfaceMaterial
    record: Record
    parameters: tuple[FreeParameter, ...]

    def __post_init__(self) -> None:
        if self.material.surface.snow:
            raise InputError(f"material '{self.material.name}': snow; allowed: surfaces that do not melt")

    def temperatures(self, shares: Floats, guess: Floats | None = None) -> tuple[Floats, Floats]:
        """Skin temperatures (N,) [K] at the record's times, at shares (free,) of the way between bounds.

        Parameters
        ----------
        shares : (free,) ndarray
        guess : ndarray, optional
            All temperatures, as an earlier call gave them.

        Returns
        -------
        temperature : (N,) ndarray
            [K]
        whole : (points, states) ndarray
            All temperatures [K].

        Raises
        ------
        RuntimeError
            Newton does not converge.
        """
        equations, values = self._equations, self._values(shares)
        flat = np.full((equations.points, equations.size), float(np.mean(self.record.values["air_temperature"])))
        try:
            states = equations.solve(values, flat if guess is None else guess, _TOLERANCE)
        except RuntimeError:
            if guess is None:
                raise
            states = equations.solve(values, flat, _TOLERANCE)
        return self._at_times(states)[:, 0], states

    def derivatives(self, shares: Floats, states: Floats) -> Floats:
        """Derivatives of the skin temperatures by the shares, (N, free) [K], where all temperatures are `states`."""
        by_value = self._equations.derivatives(states, self._values(shares))
        slopes = [parameter.slope(float(share)) for parameter, share in zip(self.parameters, shares, strict=True)]
        slopes_of_skin: Floats = self._at_times(by_value)[:, 0] * np.array(slopes)
        return slopes_of_skin

    def _values(self, shares: Floats) -> Floats:
        return np.array(list(parameter_values(self.parameters, shares).values()))

    def _at_times(self, values: Floats) -> Floats:
        """What belongs to the record's times, of values by point along the first axis: the last interval ends at the
        first time.
        """
        ends = self._equations.ends(values)[self._intervals - 1 :: self._intervals]
        return np.roll(ends, 1, axis=0)

    @property
    def _intervals(self) -> int:
        """Number of intervals of a step of the record."""
        return int(np.ceil(self.record.step / LONGEST_INTERVAL - 1e-9))

    @cached_property
    def _equations(self) -> Collocation:
        import casadi as ca

        record, names = self.record, [parameter.name for parameter in self.parameters]
        symbols = ca.SX.sym("free", len(names))
        values = {name: symbols[index] for index, name in enumerate(names)}
        shares = cell_shares(SymbolicMaterial.of(self.material), _CELLS, DAY, record.period)
        material = with_values(self.material, values)
        rate = rate_function(ca, material, grid(material, shares), symbols, values.get("back_temperature"))
        return Collocation(rate, self._forcing(), record.step / self._intervals, _DEGREE)

    def _forcing(self) -> Floats:
        """Weather and back at the points of all intervals, linear between the record's times."""
        record = self.record
        no_light = np.zeros(record.steps)
        forcing = record_forcing(record, (no_light, record.values["sw_down"], no_light), 0.0)
        hours = start_hour(record) + np.arange(float(record.steps)) * (record.step / 3600.0)
        drive = np.broadcast_to(back_drive(self.material, forcing, hours), (1, record.steps))
        rows = np.vstack([forcing_rows(forcing, record.steps, self.material, by_time=False), drive])
        points = (np.arange(record.steps * self._intervals)[:, None] + collocation_points(_DEGREE)).ravel()
        times = points / self._intervals
        return np.stack([np.interp(times, np.arange(record.steps + 1), np.append(row, row[0])) for row in rows])


def start_hour(record: Record) -> float:
    """Clock hour (UTC) at which a record begins."""
    return float((record.start - record.start.astype("datetime64[D]")) / np.timedelta64(1, "h"))


def start_shares(parameters: Sequence[FreeParameter]) -> Floats:
    """Where the material's own values lie between the bounds, (free,)."""
    return np.array([parameter.share(parameter.start) for parameter in parameters])
