"""The same heat balance written independently in casadi: finite volumes in the layers, collocation in time.

It shares no numerics with the solver: the layers are cut into cells, the day into intervals with Radau points, and all
temperatures of the period are found at once by Newton with casadi's exact derivatives. Slow, and only for checking.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.constants import Stefan_Boltzmann

from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.back_boundary import back_drive
from skyshine.mat.surface.balance import Forcing
from skyshine.mat.surface.convection import AIR_GAS_CONSTANT, AIR_HEAT_CAPACITY, natural_coefficients
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.materials.records import SurfaceProperties
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

_GROWTH = 1.12  # of cells inwards
_SEMI_INFINITE_DEPTHS = 12.0  # daily damping depths that stand for infinity: exp(-12) = 6e-6


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
    material : SurfaceMaterial
    forcing_at : callable
        Gives the `Forcing` of one column at times (n,) [s].
    period : float
        [s]
    intervals, degree : int
        Of the Radau collocation.
    cells : int
        In each layer.
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
    points = np.array(ca.collocation_points(degree, "radau"))
    times = (np.arange(intervals)[:, None] + points[None, :]) * (period / intervals)
    forcing = forcing_at(times.ravel())
    rate, size = _rate(ca, material, cells, period)
    parameters = np.vstack(
        [_parameters(forcing, times.size), back_drive(material, forcing, times.ravel() / 3600) + 0 * times.ravel()]
    )
    residual, unknowns = _collocation(ca, rate, size, parameters, intervals, degree, period, start)
    guess = float(np.mean(forcing.air_temperature)) if start is None else start
    values = _newton(ca, residual, unknowns, np.full(size * times.size, guess))
    states = values.reshape(intervals, degree, size)[:, -1]
    ends = (np.arange(float(intervals)) + 1) * (period / intervals)
    return OracleSolution(ends, states[:, 0], states[:, 1:])


def _grid(material: SurfaceMaterial, cells: int, period: float) -> list[tuple[float, float, float]]:
    """Cells of the stack from the surface inwards: width, conductivity, volumetric heat capacity."""
    grid = []
    for layer in material.thermal.layers:
        capacity = layer.density * layer.heat_capacity
        thickness = layer.thickness
        damping = np.sqrt(layer.conductivity * period / (np.pi * capacity))
        thickness = min(thickness, _SEMI_INFINITE_DEPTHS * damping) if np.isinf(thickness) else thickness
        growth = _GROWTH if thickness > 0.2 * damping else 1.0
        widths = growth ** np.arange(cells)
        widths *= thickness / widths.sum()
        grid += [(width, layer.conductivity, capacity) for width in widths]
    return grid


def _rate(ca: Any, material: SurfaceMaterial, cells: int, period: float) -> tuple[Any, int]:
    """casadi function of (state, forcing and back) to the state's rate of change [K/s]; the state is surface, then
    cells.
    """
    grid = _grid(material, cells, period)
    size = len(grid) + 1
    state, parameter = ca.SX.sym("T", size), ca.SX.sym("p", len(_NAMES) + 1)
    resistance = [0.5 * width / conductivity for width, conductivity, _ in grid]
    down = [(state[0] - state[1]) / resistance[0]]
    down += [
        (state[i] - state[i + 1]) / (resistance[i - 1] + resistance[i]) for i in range(1, size - 1)
    ]  # between cells i and i + 1
    down.append(_into_back(material, parameter[len(_NAMES)], state[size - 1], resistance[-1]))
    skin = material.thermal.skin
    capacity = skin.thickness * skin.density * skin.heat_capacity
    rates = [(-_loss(ca, material, state[0], parameter[: len(_NAMES)]) - down[0]) / capacity]
    rates += [(down[i - 1] - down[i]) / (grid[i - 1][0] * grid[i - 1][2]) for i in range(1, size)]
    return ca.Function("rate", [state, parameter], [ca.vertcat(*rates)]), size


def _into_back(material: SurfaceMaterial, drive: Any, temperature: Any, resistance: float) -> Any:
    """Heat flux out of the last cell into a back that is driven by a temperature or a heat flux."""
    boundary = material.thermal.back
    if boundary.kind == "adiabatic" or np.isinf(material.thermal.layers[-1].thickness):
        return 0.0
    if boundary.kind == "cavity":
        raise InputError("found a back of kind 'cavity'; allowed here: the others; march in finite volumes")
    if boundary.kind == "heated":
        return -drive
    if boundary.coefficient is not None:
        resistance = resistance + 1.0 / boundary.coefficient
    return (temperature - drive) / resistance


_NAMES = (
    *("shortwave", "longwave", "air", "vapour", "pressure", "wind", "wind_height", "air_height"),
    *("upward", "warmer", "colder"),
)


def _parameters(forcing: Forcing, count: int) -> Floats:
    """Forcing of the balance at each time, (fields, times): see `_NAMES`."""
    warmer, colder = natural_coefficients(forcing.cos_slope, forcing.pressure)
    rows = [
        forcing.shortwave_direct + forcing.shortwave_diffuse + forcing.shortwave_reflected,
        forcing.longwave_sky + forcing.longwave_ground,
        forcing.air_temperature,
        forcing.vapour_pressure,
        forcing.pressure,
        forcing.wind_speed,
        forcing.wind_height,
        forcing.air_height,
        1.0 + np.minimum(90.0 - np.degrees(np.arccos(forcing.cos_slope)), 0.0) / 90.0,
        warmer,
        colder,
    ]
    return np.stack([np.broadcast_to(row, (1, count))[0] for row in rows])


def _loss(ca: Any, material: SurfaceMaterial, surface: Any, parameter: Any) -> Any:
    """Outward flux of the surface [W m^-2] as a casadi expression."""
    short, long, air, vapour, pressure, speed, wind_height, air_height, upward, warmer, colder = ca.vertsplit(parameter)
    wind = speed, wind_height, air_height
    emissivity = material.thermal_emissivity
    net = emissivity * (Stefan_Boltzmann * surface**4 - long) - material.solar_absorptance * short
    properties = material.surface
    volumetric = pressure / (AIR_GAS_CONSTANT * air) * AIR_HEAT_CAPACITY
    difference = surface - air
    width = ca.sqrt(difference**2 + 0.01)
    natural = 0.5 * (warmer**3 * (width + difference) + colder**3 * (width - difference))
    forced = _forced(ca, properties, volumetric, pressure, wind)
    if properties.exposure == "field" and properties.roughness_length <= 0.3:
        forced *= _stability(ca, properties.roughness_length, difference / air, wind, upward)
    coefficient = ca.if_else(pressure > 0, (8.0 + forced**3 + natural) ** (1.0 / 3.0), 0.0)
    net += coefficient * difference
    if properties.wetness:
        celsius = surface - ZERO_CELSIUS
        frozen = ca.fmin(ca.fmax(-celsius / 2.0, 0.0), 1.0)
        ice = frozen * frozen * (3.0 - 2.0 * frozen)
        over_ice = 9.550426 - 5723.265 / surface + 3.53068 * ca.log(surface) - 0.00728332 * surface
        over_water = _over_water(ca, surface)
        deficit = (ca.exp(ice * over_ice + (1.0 - ice) * over_water) - vapour) * (1.0 + ice * 0.333 / 2.501)
        resistance = volumetric / coefficient
        if properties.canopy:
            resistance += _leaves(ca, properties, short, air, (vapour, pressure))
        else:
            resistance += properties.surface_resistance
        net += properties.wetness * volumetric / (0.665e-3 * pressure) * deficit / resistance
    return net


def _over_water(ca: Any, kelvin: Any) -> Any:
    """Logarithm of the saturation pressure [ln Pa]."""
    bend = 53.878 - 1331.22 / kelvin - 9.44523 * ca.log(kelvin) + 0.014025 * kelvin
    level = 54.842763 - 6763.22 / kelvin - 4.210 * ca.log(kelvin) + 0.000367 * kelvin
    return level + ca.tanh(0.0415 * (kelvin - 218.8)) * bend


def _leaves(ca: Any, surface: SurfaceProperties, sunlight: Any, air: Any, humidity: tuple[Any, Any]) -> Any:
    """Resistance of a canopy [s m^-1]."""
    least, trees = surface.surface_resistance, surface.roughness_length > 0.3
    vapour, pressure = humidity
    light = 1.1 * sunlight / (150.0 if trees else 300.0)
    share = (light + least * (5.0 if trees else 3.0) / 5000.0) / (1.0 + light)
    deficit = 0.622 * ca.fmax(ca.exp(_over_water(ca, air)) - vapour, 0.0) / pressure
    mild = ca.fmax(1.0 - 0.0016 * (air - 298.15) ** 2, 0.01)
    return ca.fmin(least * (1.0 + (54.53 if trees else 36.35) * deficit) / (share * mild), 5000.0)


def _forced(ca: Any, surface: SurfaceProperties, volumetric: Any, pressure: Any, wind: tuple[Any, Any, Any]) -> Any:
    """Transfer coefficient of the wind in neutral air [W m^-2 K^-1]; `wind` is speed, its height, that of the air."""
    roughness, (speed, wind_height, air_height) = surface.roughness_length, wind
    if surface.exposure == "field":
        logs = ca.log(1 + wind_height / roughness) * ca.log(1 + air_height * np.exp(2.0) / roughness)
        return volumetric * 0.16 * ca.sqrt(speed**2 + 0.01) / logs

    def at(height: float) -> Any:
        return speed * np.log(height / 0.03) / ca.log(wind_height / 0.03)

    thin = (pressure / 101325.0) ** 0.8
    if surface.exposure == "plate":
        return 5.678 * (0.53 if roughness > 3e-5 else 0.50) * (at(2.0) / 0.3048) ** 0.78 * thin
    factor = np.interp(np.log10(roughness), [-5, -4, -3, np.log10(0.002), -2], [1.0, 1.11, 1.52, 1.67, 2.17])
    if surface.exposure == "roof":
        return factor * 0.0296 * 0.0257 / 5.0 * (1.2041 * at(6.0) * 5.0 / 1.81e-5) ** 0.8 * 0.71 ** (1 / 3) * thin
    return factor * (1.63 * at(10.0) ** 0.89 + 1.775 * at(10.0) ** 0.617) * thin


def _stability(ca: Any, roughness: float, relative: Any, wind: tuple[Any, Any, Any], upward: Any) -> Any:
    """Louis' factor at a difference over air temperature."""
    speed, wind_height, air_height = wind
    height = ca.sqrt(wind_height * air_height)

    def heat(level: Any) -> Any:
        return ca.log(1 + level * np.exp(2.0) / roughness)

    momentum, there = ca.log(1 + height / roughness), ca.log(1 + wind_height / roughness)
    squared = (speed**2 + 0.01) * (momentum / there) ** 2
    number = 9.80665 * height * relative * heat(height) / heat(air_height) / squared
    excess = 2.0
    cubic = 3.2165 + 4.3431 * excess + 0.5360 * excess**2 - 0.0781 * excess**3
    power = 0.5802 - 0.1571 * excess + 0.0327 * excess**2 - 0.0026 * excess**3
    free = 15 * cubic * 0.16 / (momentum * heat(height)) * (1 + height * np.exp(2.0) / roughness) ** power
    warm, cold = ca.fmax(number, 0.0), ca.fmax(-number, 0.0)
    unstable = 1 + 15 * warm / (1 + free * ca.sqrt(warm + 1e-16))
    level = ca.if_else(number > 0, unstable, 1 / (1 + 15 * cold * ca.sqrt(1 + 5 * cold)))
    return 1 + upward * (level - 1)


def _collocation(
    ca: Any,
    rate: Any,
    size: int,
    parameters: Floats,
    intervals: int,
    degree: int,
    period: float,
    start: float | None,
) -> tuple[Any, Any]:
    """Equations of Radau collocation, periodic or from a start, and their unknowns, ordered interval, point, state."""
    nodes = np.concatenate([[0.0], ca.collocation_points(degree, "radau")])
    weights = _derivative_weights(nodes)
    unknowns = ca.MX.sym("x", size, intervals * degree)
    slopes = rate.map(intervals * degree)(unknowns, ca.DM(parameters)) * (period / intervals)
    ends = unknowns[:, degree - 1 :: degree]
    starts = ca.horzcat(ends[:, -1] if start is None else start * ca.DM.ones(size), ends[:, :-1])
    equations = []
    for point in range(degree):
        total = weights[0, point + 1] * starts
        for other in range(degree):
            total = total + weights[other + 1, point + 1] * unknowns[:, other::degree]
        equations.append(total - slopes[:, point::degree])
    return ca.vertcat(*(ca.vec(equation) for equation in equations)), unknowns


def _derivative_weights(nodes: Floats) -> Floats:
    """Derivatives of the Lagrange polynomials (rows) at the nodes (columns)."""
    polynomials = [
        np.poly1d(np.delete(nodes, i), r=True) / np.prod(nodes[i] - np.delete(nodes, i)) for i in range(len(nodes))
    ]
    return np.array([np.polyval(np.polyder(polynomial), nodes) for polynomial in polynomials])


def _newton(ca: Any, residual: Any, unknowns: Any, start: Floats) -> Floats:
    """Temperatures at which the residual vanishes."""
    from scipy.sparse.linalg import spsolve

    flat = ca.vec(unknowns)
    both = ca.Function("both", [unknowns], [residual, ca.jacobian(residual, flat)])
    values: Floats = start
    for _ in range(40):
        defect, matrix = both(values.reshape(-1, unknowns.shape[0]).T)
        step = spsolve(matrix.sparse().tocsc(), -np.array(defect).ravel())
        values = values + step * min(1.0, 40.0 / np.abs(step).max())
        if np.abs(step).max() < 1e-8:
            return values
    raise RuntimeError(f"the oracle's Newton iteration did not converge: last step {np.abs(step).max():.3g} K")
