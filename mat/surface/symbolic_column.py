"""Temperatures of a column by finite volumes in its layers and Radau collocation in time, with exact derivatives.

casadi differentiates the rate of change of one state by the state and by parameters of the material. All temperatures
of a period are found at once by Newton; those of a record follow from its end, so that it has no initial condition.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from skyshine.mat.surface.symbolic_balance import FORCING, SymbolicMaterial, loss
from skyshine.schemas.arrays import Floats, Integers

# Width of a layer's last cell over that of its first, more in layers of more damping depths. The ratio of neighbours
# falls as cells grow in number: with a fixed one the error of the finite volumes would not fall with them.
_STRETCH = 6.0
_SEMI_INFINITE_DEPTHS = 12.0  # damping depths of the period taken as infinity: exp(-12) = 6e-6
_LARGEST_STEP = 40.0  # K a Newton step may change any temperature: chosen, a day's range of the driest ground
_ROUNDS = 60


@dataclass(frozen=True, eq=False)
class Cell:
    """A finite volume: width [m], conductivity [W m^-1 K^-1], volumetric heat capacity [J m^-3 K^-1]; the numbers may
    be casadi expressions.
    """

    width: Any
    conductivity: Any
    capacity: Any

    @property
    def half_resistance(self) -> Any:
        """From the middle to an edge [m^2 K W^-1]."""
        return 0.5 * self.width / self.conductivity


def cell_shares(material: SymbolicMaterial, cells: int, period: float, infinity: float) -> list[tuple[Floats, Any]]:
    """For each layer, widths (cells,) that sum to 1, and its thickness [m]; the stack's numbers must be known.

    Parameters
    ----------
    cells : int
        Number of cells in each layer.
    period : float
        Period of the waves that the cells resolve [s].
    infinity : float
        Longest period [s]: 12 of its damping depths represent a layer without end.
    """
    shares = []
    for layer in material.thermal.layers:
        diffusivity = layer.conductivity / (layer.density * layer.heat_capacity)
        thickness = layer.thickness
        if np.isinf(thickness):
            thickness = _SEMI_INFINITE_DEPTHS * np.sqrt(diffusivity * infinity / np.pi)
        depths = thickness / np.sqrt(diffusivity * period / np.pi)  # that damp the waves
        stretch = max(_STRETCH, depths) if depths > 0.2 else 1.0
        widths = stretch ** (np.arange(float(cells)) / max(cells - 1, 1))
        shares.append((widths / widths.sum(), thickness))
    return shares


def grid(material: SymbolicMaterial, shares: Sequence[tuple[Floats, Any]]) -> list[Cell]:
    """Cells of the stack from the surface inwards."""
    cells = []
    for layer, (widths, thickness) in zip(material.thermal.layers, shares, strict=True):
        capacity = layer.density * layer.heat_capacity
        extent = thickness if isinstance(layer.thickness, float) and np.isinf(layer.thickness) else layer.thickness
        cells += [Cell(extent * width, layer.conductivity, capacity) for width in widths]
    return cells


def rate_function(
    ca: Any, material: SymbolicMaterial, cells: Sequence[Cell], parameters: Any, drive: Any = None
) -> Any:
    """casadi function of state, forcing and free parameters to the state's rate of change [K/s] and its derivatives.

    Parameters
    ----------
    ca : module
        casadi.
    material : SymbolicMaterial
        Its numbers may depend on `parameters`.
    parameters : casadi.SX
        Column of parameters, or of none.
    drive : casadi.SX, optional
        Drive of the back, which replaces the last value of the forcing.

    Returns
    -------
    casadi.Function
        The state is the surface, then the cells, then the air of a cavity that stores heat; the forcing has the values
        of `FORCING` and the drive of the back. The derivatives by the state are those of its tridiagonal pattern,
        column by column, those by `parameters` column by column.
    """
    enclosed = _floats(material)
    cell_count = len(cells)
    size = cell_count + 1 + enclosed
    state, forcing = ca.SX.sym("T", size), ca.SX.sym("p", len(FORCING) + 1)
    down = [(state[0] - state[1]) / cells[0].half_resistance]
    between = zip(cells, cells[1:], range(1, cell_count), strict=False)
    down += [(state[i] - state[i + 1]) / (cell.half_resistance + below.half_resistance) for cell, below, i in between]
    behind = forcing[-1] if drive is None else drive
    down.append(_into_back(material, state[size - 1] if enclosed else behind, state[cell_count], cells[-1]))
    skin = material.thermal.skin
    capacity = skin.thickness * skin.density * skin.heat_capacity
    rates = [(-loss(ca, material, state[0], forcing[: len(FORCING)]) - down[0]) / capacity]
    rates += [(down[i - 1] - down[i]) / (cells[i - 1].width * cells[i - 1].capacity) for i in range(1, cell_count + 1)]
    if enclosed:
        back = material.thermal.back
        rates.append((down[cell_count] - back.exchange * (state[size - 1] - behind)) / back.capacity)
    rate = ca.vertcat(*rates)
    rows, columns = _tridiagonal(size)
    by_state = ca.jacobian(rate, state)
    band = ca.vertcat(*(by_state[int(row), int(column)] for row, column in zip(rows, columns, strict=True)))
    outputs = [ca.densify(part) for part in (rate, band, ca.vec(ca.jacobian(rate, parameters)))]
    return ca.Function("rate", [state, forcing, parameters], outputs)


def _floats(material: SymbolicMaterial) -> bool:
    """Whether the back is a cavity whose air is a state of its own."""
    ended = not np.isinf(material.thermal.layers[-1].thickness)
    return ended and material.thermal.back.kind == "cavity" and bool(material.thermal.back.capacity)


def _into_back(material: SymbolicMaterial, drive: Any, temperature: Any, cell: Cell) -> Any:
    """Heat flux out of the last cell into a back that is driven by a temperature or a heat flux, or into the air of a
    cavity.
    """
    boundary = material.thermal.back
    thickness = material.thermal.layers[-1].thickness
    if boundary.kind == "adiabatic" or np.isinf(thickness):
        return 0.0
    if boundary.kind == "heated":
        return -drive
    resistance = cell.half_resistance
    if boundary.coefficient is not None:
        resistance = resistance + 1.0 / boundary.coefficient
    if boundary.exchange is not None and not boundary.capacity:
        resistance = resistance + 1.0 / boundary.exchange
    return (temperature - drive) / resistance


def _tridiagonal(size: int) -> tuple[Integers, Integers]:
    """Rows and columns of a tridiagonal matrix's entries."""
    at = np.arange(size)
    return np.concatenate([at, at[1:], at[:-1]]), np.concatenate([at, at[:-1], at[1:]])


def collocation_points(degree: int) -> Floats:
    """Radau points of an interval from 0 to 1, the last at its end, (degree,)."""
    import casadi as ca

    return np.array(ca.collocation_points(degree, "radau"))


@dataclass(frozen=True, eq=False)
class Collocation:
    """The equations of all temperatures of a period, for Newton and for derivatives by free parameters.

    Attributes
    ----------
    rate : casadi.Function
        See `rate_function`.
    forcing : (fields, intervals * degree) ndarray
        Forcing at the points of the intervals.
    interval : float
        [s]
    degree : int
        Degree of the Radau collocation.
    start : float or None
        Uniform temperature at the beginning [K], in place of periodicity.
    """

    rate: Any
    forcing: Floats
    interval: float
    degree: int
    start: float | None = None

    @property
    def size(self) -> int:
        """Temperatures of a state."""
        return int(self.rate.size1_in(0))

    @property
    def points(self) -> int:
        """Points of all intervals."""
        return int(self.forcing.shape[1])

    def solve(self, parameters: Floats, guess: Floats, tolerance: float = 1e-8) -> Floats:
        """Temperatures (points, size) [K] at values of the free parameters, by Newton from a guess of that shape.

        Raises
        ------
        RuntimeError
            Newton does not converge.
        """
        from scipy.sparse.linalg import spsolve

        values, change, before = guess, np.inf, np.inf
        for _ in range(_ROUNDS):
            rate, band, _ = self._evaluated(values, parameters)
            step = spsolve(self._matrix(band), -self._defect(values, rate).ravel()).reshape(values.shape)
            change = float(np.abs(step).max())
            # Across a bend of the balance whole steps may go to and fro; a half one ends between.
            share = 0.5 if change > 0.5 * before else 1.0
            before = change
            values = values + step * min(share, _LARGEST_STEP / change) if change > 0 else values
            if change < tolerance:
                return values
        raise RuntimeError(f"the collocation's Newton iteration did not converge: last step {change:.3g} K")

    def derivatives(self, values: Floats, parameters: Floats) -> Floats:
        """Derivatives of the solution by each free parameter, (points, size, free)."""
        from scipy.sparse.linalg import splu

        _, band, by_free = self._evaluated(values, parameters)
        right = self.interval * by_free.reshape(self.points, len(parameters), self.size).transpose(0, 2, 1)
        derivatives: Floats = splu(self._matrix(band)).solve(np.ascontiguousarray(right.reshape(-1, len(parameters))))
        return derivatives.reshape(self.points, self.size, len(parameters))

    def ends(self, values: Floats) -> Floats:
        """What belongs to the ends of the intervals, of values by point along the first axis."""
        return values[self.degree - 1 :: self.degree]

    def _evaluated(self, values: Floats, parameters: Floats) -> tuple[Floats, Floats, Floats]:
        """Rates (points, size), band of their derivatives by the state and derivatives by the free parameters."""
        many = np.repeat(np.reshape(parameters, (-1, 1)), self.points, axis=1)
        outputs = self._mapped(values.T, self.forcing, many)
        rate, band, by_free = (np.asarray(part).T for part in outputs)
        return rate, band, by_free

    @cached_property
    def _mapped(self) -> Any:
        return self.rate.map(self.points)

    @cached_property
    def _weights(self) -> Floats:
        """Derivatives of the Lagrange polynomials (rows) at the start and the points (columns)."""
        nodes = np.concatenate([[0.0], collocation_points(self.degree)])
        polynomials = [
            np.poly1d(np.delete(nodes, i), r=True) / np.prod(nodes[i] - np.delete(nodes, i)) for i in range(len(nodes))
        ]
        return np.array([np.polyval(np.polyder(polynomial), nodes) for polynomial in polynomials])

    def _defect(self, values: Floats, rate: Floats) -> Floats:
        """Residuals of the equations, (points, size)."""
        states = values.reshape(-1, self.degree, self.size)
        starts = np.roll(states[:, -1], 1, axis=0)
        if self.start is not None:
            starts[0] = self.start
        slopes = np.einsum("jp,njs->nps", self._weights[1:, 1:], states) + np.einsum(
            "p,ns->nps", self._weights[0, 1:], starts
        )
        defect: Floats = slopes.reshape(values.shape) - self.interval * rate
        return defect

    @cached_property
    def _fixed(self) -> Any:
        """The part of the matrix that does not depend on temperatures."""
        from scipy.sparse import csc_array, identity, kron

        intervals = self.points // self.degree
        end_weights = np.zeros((self.degree, self.degree))
        end_weights[:, -1] = self._weights[0, 1:]
        at = np.arange(intervals)
        before = (at - 1) % intervals
        follows = at if self.start is None else at[1:]
        shift = csc_array((np.ones(len(follows)), (follows, before[follows])), shape=(intervals, intervals))
        by_point = kron(identity(intervals), self._weights[1:, 1:].T) + kron(shift, end_weights)
        return csc_array(kron(by_point, identity(self.size)))

    @cached_property
    def _places(self) -> tuple[Integers, Integers]:
        """Rows and columns of the bands of all points."""
        offset = self.size * np.arange(self.points)[:, None]
        rows, columns = _tridiagonal(self.size)
        return (offset + rows).ravel(), (offset + columns).ravel()

    def _matrix(self, band: Floats) -> Any:
        """Derivatives of the equations by the temperatures."""
        from scipy.sparse import csc_array

        return self._fixed - csc_array((self.interval * band.ravel(), self._places), shape=self._fixed.shape)
