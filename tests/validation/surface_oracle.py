"""The same heat balance written independently in casadi: finite volumes in the layers, collocation in time.

It shares no numerics with the solver: the layers are cut into cells, the day into intervals with Radau points, and all
temperatures of the period are found at once by Newton with casadi's exact derivatives. Slow, and only for checking.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skyshine.mat.surface.back_boundary import back_drive
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.symbolic_balance import SymbolicMaterial, forcing_rows
from skyshine.mat.surface.symbolic_column import Collocation, cell_shares, collocation_points, grid, rate_function
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError


@dataclass(frozen=True, eq=False)
class OracleSolution:
    """Times [s] (n,), surface temperature [K] (n,) and cell temperatures [K] (n, cells)."""

    time: Floats
    surface: Floats
    cells: Floats


def solve_oracle(
    material: SurfaceMaterial,
    forcing_at: Callable[[Floats], Forcing],
    *,
    period: float = 86400.0,
    intervals: int = 144,
    degree: int = 3,
    cells: int = 40,
    start: float | None = None,
) -> OracleSolution:
    """Temperatures of one column, periodic or from a start.

    Parameters
    ----------
    forcing_at : callable
        Gives the `Forcing` of one column at times (n,) [s].
    period : float
        [s]
    intervals, degree : int
        Number of intervals, and degree of the Radau collocation.
    cells : int
        Number of cells in each layer.
    start : float, optional
        Uniform temperature at the beginning [K], in place of periodicity.

    Returns
    -------
    OracleSolution
        At the ends of the intervals; the last is the end of the period.

    Raises
    ------
    InputError
        The surface is snow, whose melting the oracle does not know.
    RuntimeError
        Newton does not converge.
    """
    import casadi as ca

    if material.surface.snow:
        raise InputError(f"material '{material.name}': snow; allowed: surfaces that do not melt")
    interval = period / intervals
    times = ((np.arange(intervals)[:, None] + collocation_points(degree)) * interval).ravel()
    forcing = forcing_at(times)
    drive = np.broadcast_to(back_drive(material, forcing, times / 3600), (1, times.size))
    symbols = SymbolicMaterial.of(material, by_time=True)
    stack = grid(symbols, cell_shares(symbols, cells, period, period))
    rows = np.vstack([forcing_rows(forcing, times.size, material, by_time=True), drive])
    equations = Collocation(rate_function(ca, symbols, stack, ca.SX.sym("none", 0)), rows, interval, degree, start)
    guess = float(np.mean(forcing.air_temperature)) if start is None else start
    values = equations.solve(np.zeros(0), np.full((times.size, equations.size), guess))
    states = equations.ends(values)
    return OracleSolution((np.arange(float(intervals)) + 1) * interval, states[:, 0], states[:, 1:])
