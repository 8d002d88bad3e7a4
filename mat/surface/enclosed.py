"""Temperatures of the ground and the walls around a scene, from their own heat balance under the same sky."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from skyshine.mat.surface.back_boundary import at_hours
from skyshine.mat.surface.days import solve_days
from skyshine.mat.surface.enclosure import AZIMUTHS, SLOPES, Emitter, Enclosure
from skyshine.mat.surface.forcing import Scene, Sky
from skyshine.mat.surface.horizon import LEVEL, Horizon
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.reading import in_steps
from skyshine.mat.surface.solver import STEPS
from skyshine.mat.surface.sun_path import SUN_STEPS, SunPath, sun_hours
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.mat.surface.weather import NearSurfaceAir
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import CheckFailed

# K: passes over ground and walls end where none changes a temperature by more. Each pass leaves at most the share that
# radiation has in the loss of heat, some 0.7 in calm air between walls that hide the whole sky.
TOLERANCE = 0.01
_PASSES = 60
# K that the last pass may still change: a surface at the edge between two methods of the solver moves so much.
_LARGEST_CHANGE = 0.2


@dataclass(frozen=True)
class GivenEmitter:
    """Ground or walls as they are given.

    Attributes
    ----------
    emissivity, albedo : float
        Emissivity for longwave, and albedo for sunlight.
    temperature : SurfaceMaterial, float, tuple of float or None
        Material whose heat balance is solved; or temperature in K, one or 24 at the hours 0 to 23; None: the air
        temperature.
    """

    emissivity: float
    albedo: float
    temperature: SurfaceMaterial | float | tuple[float, ...] | None = None


AIR = GivenEmitter(1.0, 0.0)


def solved_enclosure(
    sun: SunPath,
    weather: NearSurfaceAir,
    sky: Sky,
    altitudes_m: Sequence[float],
    *,
    ground: GivenEmitter,
    walls: GivenEmitter = AIR,
    horizon: Horizon = LEVEL,
    sky_view: float = 1.0,
    steps: int = STEPS,
) -> Enclosure:
    """The enclosure of a scene with the temperatures of its ground and walls.

    Parameters
    ----------
    sun, weather, sky
        As of `Scene`; an enclosure that the sky has already is replaced.
    altitudes_m : (L,) sequence
        Increasing, at which temperatures are solved [m].
    ground, walls : GivenEmitter
        The ground is level, walls are upright and face each of `ASPECTS`.
    horizon, sky_view
        As of `Enclosure`.
    steps : int
        Solver times of a day.

    Raises
    ------
    CheckFailed
        The temperatures of ground and walls do not settle.
    skyshine.mat.surface.solver.ConvergenceError
        No method solves one of them.

    Notes
    -----
    Ground and walls see the sky under the same horizon as all surfaces, each other, and walls other walls. They are
    solved in turn from air temperature on, each pass with the temperatures of the one before.
    """
    altitude = np.asarray(altitudes_m, float)
    enclosure = Enclosure(_given(ground, altitude), _given(walls, altitude), horizon, float(sky_view), altitude)
    solved = {
        name: (given.temperature, planes)
        for name, given, planes in (("ground", ground, slice(0, 1)), ("walls", walls, slice(1, None)))
        if isinstance(given.temperature, SurfaceMaterial) and not (name == "walls" and enclosure.open)
    }
    largest = np.inf
    for _ in range(_PASSES if solved else 0):
        enclosed_sky = replace(sky, enclosure=enclosure)
        changes = {}
        largest = 0.0
        for name, (material, planes) in solved.items():
            scene = Scene(sun, weather, enclosed_sky, altitude, SLOPES[planes], AZIMUTHS[planes])
            emitter, kelvin = getattr(enclosure, name), _temperature(material, scene, steps)
            before = np.inf if emitter.temperature is None else emitter.temperature
            largest = max(largest, float(np.abs(kelvin - before).max()))
            changes[name] = replace(emitter, temperature=kelvin)
        enclosure = replace(enclosure, **changes)
        # Level ground on an open plain sees nothing that depends on its temperature.
        if largest <= TOLERANCE or enclosure.open:
            break
    if solved and not enclosure.open and largest > _LARGEST_CHANGE:
        raise CheckFailed(
            f"temperatures of ground and walls still change by {largest:.2g} K after {_PASSES} passes; give the walls a"
            " temperature_c, or a larger sky_view"
        )
    if "ground" not in solved:
        return enclosure
    material, enclosed_sky = solved["ground"][0], replace(sky, enclosure=enclosure)

    @cache
    def ground_under(surroundings: Surroundings) -> Floats:
        scene = Scene(sun, weather, enclosed_sky, altitude, SLOPES[:1], AZIMUTHS[:1], surroundings)
        return _temperature(material, scene, steps)

    return replace(enclosure, ground_under=ground_under)


def _given(emitter: GivenEmitter, altitude: Floats) -> Emitter:
    """An emitter with the temperatures that are given; those to be solved begin at air temperature."""
    if emitter.temperature is None or isinstance(emitter.temperature, SurfaceMaterial):
        return Emitter(emitter.emissivity, emitter.albedo)
    day = at_hours(emitter.temperature, sun_hours())
    return Emitter(emitter.emissivity, emitter.albedo, np.tile(day, (altitude.size, 1, 1)))


def _temperature(material: SurfaceMaterial, scene: Scene, steps: int) -> Floats:
    """Temperature of a material on all planes of a scene, (A, P, SUN_STEPS)."""
    kelvin = np.empty((len(scene.altitude) * len(scene.slope), SUN_STEPS))
    for columns, solution in solve_days(material, scene.days, steps=steps):
        kelvin[columns] = in_steps(solution.temperature, SUN_STEPS)
    return kelvin.reshape(len(scene.altitude), len(scene.slope), SUN_STEPS)
