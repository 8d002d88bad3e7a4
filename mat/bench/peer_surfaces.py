"""Temperatures of faces as peers compute them: by marching in time, and by EnergyPlus."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import cache, partial

import numpy as np

from skyshine.mat.bench import energyplus
from skyshine.mat.bench.equal_error import EqualError, Measured, rms
from skyshine.mat.bench.marching import march
from skyshine.mat.job.model import Job
from skyshine.mat.scene.surface import scene_inputs, surface_materials
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.solver import solve_columns
from skyshine.materials.library import MaterialLibrary
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack
from skyshine.schemas.arrays import Floats

# Steps a day of ours; steps, days, cells a layer and theta of marching schemes, and of the finest, by which both are
# judged.
_STEPS = (24, 48, 96, 144)
_MARCHES = ((24, 5, 5, 1.0), (96, 5, 10, 0.5), (288, 8, 20, 0.5))
_FINEST = (576, 10, 30, 0.5)
# Steps an hour of EnergyPlus, days at most and by how many kelvin the last two may differ; and of the finest.
_OF_ENERGYPLUS, _FINEST_OF_ENERGYPLUS = ((4, 25, 0.4), (6, 40, 0.04), (12, 40, 0.01), (30, 40, 0.01)), (60, 60, 1e-4)
_PLANES = [(0.0, 0.0), *((slope, azimuth) for slope in (45.0, 90.0) for azimuth in (0.0, 90.0, 180.0, 270.0))]
_COPIES = 16  # copies of the planes: a table has as many faces of a material
_SKIN_M = 2e-3  # thickness of the skin of the wall of EnergyPlus
_WORK = "a day of a face of "


def surfaces(job: Job, library: MaterialLibrary, names: Sequence[str]) -> list[EqualError]:
    """A day of faces of all slopes: of the first material that has layers alone beside marching in time, of concrete on
    insulation beside EnergyPlus, where it is installed.
    """
    inputs = scene_inputs(job, 1)
    slope, azimuth = np.array(_PLANES * _COPIES).T
    altitude = np.array([1e3 * job.surface_altitudes_km[0]])

    @cache
    def forcing(steps: int) -> Forcing:
        return Scene(*inputs, altitude, slope, azimuth).forcing(steps)

    rows = []
    stacks = surface_materials([library[name] for name in names], job.operated, inputs[1].wetting)
    material = next((stack for stack in stacks if stack.canopy is None and stack.thermal.layers), None)
    if material is not None:
        rows.append(_beside_marching(material, forcing))
    if energyplus.program() is not None:
        rows.append(_beside_energyplus(forcing))
    return rows


def _beside_marching(material: SurfaceMaterial, forcing: Callable[[int], Forcing]) -> EqualError:
    """Temperatures of a material by our solver and by marching schemes."""
    reference = _marched(material, forcing, *_FINEST)
    theirs = [
        _measured(
            f"{setting[0]} steps and {setting[1]} days", partial(_marched, material, forcing, *setting), reference
        )
        for setting in _MARCHES
    ]
    judged = f"root mean square against {_FINEST[0]} steps, {_FINEST[2]} cells a layer"
    ours = _by_solver(material, forcing, reference)
    return EqualError.of(f"{_WORK}{material.name}", "marching in time", "K", ours, theirs, judged)


def _beside_energyplus(forcing: Callable[[int], Forcing]) -> EqualError:
    """Temperatures of the wall of `energyplus` by our solver in the job's weather, and by EnergyPlus in its own."""
    layers = tuple(Layer(*layer) for layer in energyplus.LAYERS)
    skin = Layer(_SKIN_M, *energyplus.LAYERS[0][1:])
    stack, bare = ThermalStack(skin, layers, Back("adiabatic")), SurfaceProperties(1e-3, 0.0, 0.0, False, False)
    wall = SurfaceMaterial("concrete", stack, bare, energyplus.SOLAR_ABSORPTANCE, energyplus.EMISSIVITY)
    exact, _ = energyplus.hourly(*_FINEST_OF_ENERGYPLUS)
    theirs = []
    for setting in _OF_ENERGYPLUS:
        temperature, seconds = energyplus.hourly(*setting)
        theirs.append(Measured(f"{setting[0]} steps an hour", seconds, rms(temperature - exact)))
    ours = _by_solver(wall, forcing, _marched(wall, forcing, *_FINEST))
    judged = f"root mean square, each against its own finest steps, {_FINEST_OF_ENERGYPLUS[0]} an hour of EnergyPlus"
    return EqualError.of(f"{_WORK}concrete on insulation", "EnergyPlus", "K", ours, theirs, judged)


def _by_solver(material: SurfaceMaterial, forcing: Callable[[int], Forcing], reference: Floats) -> list[Measured]:
    """Our solver with few steps to many, judged by temperatures of the same faces."""

    def solve(steps: int) -> Floats:
        temperature = np.empty(forcing(steps).shape)
        for columns, solution in solve_columns(material, forcing, steps=steps, fine_steps=None):
            temperature[columns] = solution.temperature
        return temperature

    return [_measured(f"{steps} steps", partial(solve, steps), reference) for steps in _STEPS]


def _marched(
    material: SurfaceMaterial, forcing: Callable[[int], Forcing], steps: int, days: int, cells: int, theta: float
) -> Floats:
    return march(material, forcing(steps), steps, days, cells, theta)


def _measured(name: str, solve: Callable[[], Floats], reference: Floats) -> Measured:
    """Processor seconds of a face and error at the times that the reference has too; the forcing is known before."""
    solve()
    begin = time.process_time()
    temperature = solve()
    seconds = (time.process_time() - begin) / len(temperature)
    times = np.gcd(temperature.shape[1], reference.shape[1])
    every, other = temperature.shape[1] // times, reference.shape[1] // times
    return Measured(name, seconds, rms(temperature[:, ::every] - reference[:, ::other]))
