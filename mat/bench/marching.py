"""Surface temperatures by marching in time through finite differences, as commonly done: peers for the bench.

A skin and some cells a layer, stepped day after day of the same forcing until the start is forgotten, by a theta
scheme with one Newton step of the surface balance. Vectorised over columns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.surface.back_boundary import back_drive
from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.schemas.arrays import Floats

DAY = 86400.0  # s


@dataclass(frozen=True, eq=False)
class Grid:
    """Nodes of a stack: capacity of each [J m^-2 K^-1], conductance behind each [W m^-2 K^-1]; the last leads to the
    back.
    """

    capacity: Floats
    conductance: Floats

    @classmethod
    def of(cls, material: SurfaceMaterial, cells: int) -> Grid:
        """A skin node and `cells` cells in each layer, and a cavity's; no heat may come from the back."""
        thermal = material.thermal
        widths = np.repeat([layer.thickness / cells for layer in thermal.layers], cells)
        conductivity = np.repeat([layer.conductivity for layer in thermal.layers], cells)
        volumetric = np.repeat([layer.density * layer.heat_capacity for layer in thermal.layers], cells)
        half = 0.5 * widths / conductivity
        resistance = np.concatenate([half[:1], half[:-1] + half[1:], half[-1:]])
        if thermal.back.coefficient is not None:
            resistance[-1] += 1 / thermal.back.coefficient
        conductance = 1 / resistance
        if thermal.back.kind == "adiabatic":
            conductance[-1] = 0.0
        skin = thermal.skin
        capacity = np.concatenate([[skin.thickness * skin.density * skin.heat_capacity], volumetric * widths])
        if thermal.back.capacity is not None and thermal.back.exchange is not None:
            capacity = np.append(capacity, thermal.back.capacity)
            conductance = np.append(conductance, thermal.back.exchange)
        return cls(capacity, conductance)

    @property
    def exchange(self) -> Floats:
        """(n, n) matrix of the heat that leaves each node per kelvin, the back at 0."""
        inner = self.conductance[:-1]
        matrix = np.diag(self.conductance + np.concatenate([[0.0], inner]))
        return matrix - np.diag(inner, 1) - np.diag(inner, -1)


def _at_times(forcing: Forcing, material: SurfaceMaterial, steps: int) -> list[Balance]:
    """The balance of all columns at each of some steps of the day, by the forcing of the nearest time before."""
    times = forcing.shape[1]
    balances = []
    for time in range(times):
        parts = {}
        for name, values in forcing.given.items():
            parts[name] = values if values.shape[-1] == 1 else values[:, time : time + 1]
        balances.append(Balance(Forcing(**parts), material))
    return [balances[step * times // steps] for step in range(steps)]


def march(material: SurfaceMaterial, forcing: Forcing, steps: int, days: int, cells: int, theta: float) -> Floats:
    """Surface temperatures (columns, steps) of the last day [K].

    Parameters
    ----------
    forcing : Forcing
        Forcing at times of which `steps` is a multiple.
    theta : float
        1/2 Crank-Nicolson, 1 implicit Euler.
    """
    grid = Grid.of(material, cells)
    balances = _at_times(forcing, material, steps)
    storage = grid.capacity * (steps / DAY)
    drive = back_drive(material, forcing, 24.0 * np.arange(steps) / steps)
    drive = drive[:, np.arange(steps) * drive.shape[1] // steps]
    temperature = np.repeat(
        np.mean(np.atleast_2d(forcing.air_temperature), axis=1, keepdims=True), len(storage), axis=1
    )
    temperature = np.broadcast_to(temperature, (forcing.shape[0], len(storage))).copy()
    exchange = grid.exchange
    implicit = np.linalg.inv(np.diag(storage) + theta * exchange)
    # The surface's own slope changes only the first row: Sherman and Morrison.
    surface_response = implicit[:, 0]
    series = np.empty((forcing.shape[0], steps))
    for _ in range(days):
        for step in range(steps):
            series[:, step] = temperature[:, 0]
            after = balances[(step + 1) % steps]
            gain = -(temperature @ exchange.T)
            gain[:, -1] += grid.conductance[-1] * drive[:, (step + 1) % steps]
            loss, slope = after.loss_and_slope(temperature[:, :1])
            if theta < 1:
                loss = theta * loss + (1 - theta) * balances[step].loss(temperature[:, :1])
            gain[:, :1] -= loss
            change = gain @ implicit.T
            slope = theta * slope
            change -= slope * change[:, :1] / (1 + slope * surface_response[0]) * surface_response
            temperature += change
    return series
