"""Extreme and stiff cases of atmosphere, surface and textures, drawn at random for a given time.

Nothing here is a kind scene: foil in a vacuum, fog of 100 m beside a range to space, air without water and air full of it, one seed a
material. What must hold is what physics and probability demand: finite numbers, bounds, balances that close.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.aerosol_column import BOUNDARY_MODELS, STRATOSPHERES
from skyshine.mat.atmosphere.cloud import LARGEST_OPTICAL_DEPTH, PHASES, RADII, THINNEST, TOP_LIMIT, CloudLayer
from skyshine.mat.atmosphere.compile import band_points
from skyshine.mat.atmosphere.profiles import PROFILES, Profile, load_profile
from skyshine.mat.atmosphere.rain import RATES, RainLayer
from skyshine.mat.atmosphere.solar import solar_irradiance
from skyshine.mat.atmosphere.sounding import read_sounding
from skyshine.mat.atmosphere.state import AtmosphericState
from skyshine.mat.quantities import BETA_CAP_KM, BETA_FACTOR, BandAtmosphere
from skyshine.mat.radiometry import SpectralResponse, planck_wavenumber
from skyshine.mat.scene import absorption_table
from skyshine.mat.surface.solver import TOLERANCE, solve_columns
from skyshine.mat.surface.stress import random_forcing, random_material
from skyshine.schemas.errors import InputError

SURFACE_BOUND = 0.5  # K beyond the instantaneous equilibria, for a solver with a time step
_ROUNDING = 1e-5  # relative: attenuation along lines of sight is kept in single precision
_SCALE_HEIGHT = 287.05 / 9.80665 * 1e-3  # km/K: gas constant of dry air over gravity (US Standard Atmosphere 1976)
_POINTS = 6  # lines of sight of an atmosphere


@dataclass(eq=False)
class Trial:
    """What one part came to.

    Attributes
    ----------
    cases : int
    failures : list of str
        Each with the numbers that draw the case again.
    worst : dict of str to float
        Largest of each measure: residuals and violations of bounds.
    slowest : float
        Processor seconds of the slowest case.
    slowest_case : str
    """

    cases: int = 0
    failures: list[str] = field(default_factory=list)
    worst: dict[str, float] = field(default_factory=dict)
    slowest: float = 0.0
    slowest_case: str = ""


def run(seconds: float, seed: int, parts: dict[str, Callable] | None = None) -> dict[str, Trial]:
    """Try random cases of each part in turn until the time is up, at least one of each.

    Parameters
    ----------
    seconds : float
        Wall clock.
    seed : int
        Case k of a part is drawn from [seed, k], whatever the time.
    parts : dict of str to callable, optional
        A callable takes a generator and returns measures with the most that each may be; by default `PARTS`.
    """
    parts = PARTS if parts is None else parts
    trials = {name: Trial() for name in parts}
    end = time.monotonic() + seconds
    number = 0
    while number == 0 or time.monotonic() < end:
        for name, case in parts.items():
            _one(trials[name], case, name, seed, number)
            if number and time.monotonic() >= end:
                break
        number += 1
    return trials


def _one(trial: Trial, case: Callable, name: str, seed: int, number: int) -> None:
    label = f"{name}, seed {seed}, case {number}"
    begin = time.process_time()
    try:
        with np.errstate(all="ignore"):
            found = case(np.random.default_rng([seed, number]))
    except Exception as error:  # noqa: BLE001 - whatever a case raises is what the suite is there to find
        trial.failures.append(f"{label}: {type(error).__name__}: {error}")
        found = {}
    spent = time.process_time() - begin
    trial.cases += 1
    if spent > trial.slowest:
        trial.slowest, trial.slowest_case = spent, label
    for measure, (value, allowed) in found.items():
        trial.worst[measure] = max(trial.worst.get(measure, 0.0), value if np.isfinite(value) else np.inf)
        if not value <= allowed:
            trial.failures.append(f"{label}: {measure} {value:.3g}, allowed {allowed:.3g}")


def surface_case(generator: np.random.Generator) -> dict[str, tuple[float, float]]:
    """One column that no kind scene has."""
    found = solve_columns(random_material(generator), random_forcing(generator))
    solutions = [solution for rows, solution in found if len(rows)]
    kelvin = np.concatenate([solution.temperature.ravel() for solution in solutions])
    return {
        "not finite": (float(np.count_nonzero(~np.isfinite(kelvin))), 0.0),
        "residual, W m^-2": (max(float(np.max(s.residual)) for s in solutions), TOLERANCE),
        "energy closure, W m^-2": (max(float(np.max(np.abs(s.energy_closure))) for s in solutions), TOLERANCE),
        "bound excess, K": (max(float(np.max(s.bound_excess)) for s in solutions), SURFACE_BOUND),
    }


def atmosphere_case(generator: np.random.Generator) -> dict[str, tuple[float, float]]:
    """Lines of sight that no kind scene has, through a state between those of no water and of fog."""
    table = absorption_table()
    state = _random_state(generator)
    start, end = table.coverage[generator.integers(len(table.coverage))]
    low = float(np.exp(generator.uniform(np.log(start), np.log(end * 0.99))))
    response = SpectralResponse.rectangular(1e4 / min(low * 1.005 + 5.0, end), 1e4 / low)
    band = band_points(table.points(*response.wavenumber_range), response)
    air = BandAtmosphere.of(state, band)
    sun = solar_irradiance(band.wavenumber) if generator.random() < 0.7 else np.zeros(band.weight.size)
    ground = state.surface_altitude * 1e-3
    places = (
        _extreme(generator, np.exp(generator.uniform(np.log(1e-6), np.log(1e5), _POINTS)), (0.0, 1e5)),
        _extreme(generator, ground + np.exp(generator.uniform(np.log(1e-3), np.log(1e5), _POINTS)), (ground, 1e5)),
        _extreme(generator, generator.uniform(-90, 90, _POINTS), (-90.0, 0.0, 90.0)),
        _extreme(generator, generator.uniform(-90, 90, _POINTS), (-90.0, 0.0, 90.0)),
        _extreme(generator, generator.uniform(0, 180, _POINTS), (0.0, 180.0)),
    )
    q = air.at_points(*places, sun)
    values = np.concatenate([q.beta_star, q.path_radiance_ratio, q.ambient, q.direct, q.transmittance])
    hottest = max(float(state.temperature.max()), float(state.surface_temperature))
    black = float(planck_wavenumber(band.wavenumber, hottest) @ band.radiance_weight)
    # The path may let through what is brightest: no more than if all of the band were as bright.
    light = float(np.max(sun * band.wavenumber**2 * 1e-4) * band.weight.sum()) / np.pi
    from_beta = np.where(q.valid & (places[0] > 0), np.exp(-BETA_FACTOR * places[0] / q.beta_star) - q.transmittance, 0.0)
    result = {
        "not finite": (float(np.count_nonzero(~np.isfinite(values))), 0.0),
        "below 0": (max(0.0, -float(values.min())), 0.0),
        "transmittance above 1": (float(q.transmittance.max()) - 1, 1e-12),
        "beta* over its cap": (float(q.beta_star.max()) / BETA_CAP_KM, 1.0),
        "transmittance of beta*": (float(np.abs(from_beta).max()), 1e-6),
        "direct light over the brightest in space": (float(q.direct.max()) / light if light else float(q.direct.max()), 1 + _ROUNDING),
    }
    if not light:  # nothing but emission: no path is brighter than a black body as warm as the warmest air or ground
        result["path over a black body"] = (float(q.path_radiance_ratio.max()) / black if black else 0.0, 1 + _ROUNDING)
    return result


def _random_state(generator) -> AtmosphericState:
    """A state that is not refused: clouds that must freeze or melt are, as they should be, and drawn again."""
    while True:
        try:
            return _any_state(generator)
        except InputError:
            continue


def _any_state(generator) -> AtmosphericState:
    aerosol = str(generator.choice([*BOUNDARY_MODELS, "none"]))
    profile = str(generator.choice(list(PROFILES)))
    sounding = generator.random() < 0.3
    return AtmosphericState.from_profile(
        _random_sounding(generator, profile) if sounding else profile,
        surface_altitude=float(generator.choice([-500.0, 0.0, generator.uniform(0, 5900)])),
        co2_ppm=float(generator.choice([0.0, 420.0, 5000.0])),
        humidity_scale=float(generator.choice([0.0, 1.0, 10.0])),
        gas_scale={"O3": float(generator.choice([0.0, 1.0, 100.0]))},
        aerosol=aerosol,
        visibility_km=None if aerosol == "none" else float(np.exp(generator.uniform(np.log(0.1), np.log(300.0)))),
        wind_speed=float(generator.choice([0.0, 4.0, 60.0])),
        air_mass=int(generator.integers(1, 11)),
        stratosphere=str(generator.choice(list(STRATOSPHERES))),
        clouds=[_random_cloud(generator) for _ in range(generator.choice([0, 0, 1, 3]))],
        rain=RainLayer(float(np.exp(generator.uniform(*np.log(RATES)))), generator.uniform(20.0, 15e3)) if generator.random() < 0.3 else None,
        surface_temperature=float(generator.uniform(180, 350)),
        surface_albedo=float(generator.choice([0.0, 0.1, 1.0])),
    )


def _random_cloud(generator) -> CloudLayer:
    """From nothing to more than any sky holds, in the thinnest and the thickest layers, at any height whatever the air there."""
    phase = str(generator.choice(PHASES))
    thickness = float(np.exp(generator.uniform(np.log(THINNEST), np.log(TOP_LIMIT / 2))))
    base = float(generator.choice([0.0, generator.uniform(0.0, TOP_LIMIT - thickness)]))
    depth = float(generator.choice([0.0, np.exp(generator.uniform(np.log(1e-4), np.log(LARGEST_OPTICAL_DEPTH))), LARGEST_OPTICAL_DEPTH]))
    return CloudLayer(phase, base, base + thickness, float(generator.uniform(*RADII[phase])), depth)


def _random_sounding(generator, name: str) -> Profile:
    """What a balloon may bring home: inversions, layers without water between wet ones, few levels."""
    levels = np.sort(generator.uniform(0.0, 30.0, int(generator.integers(3, 40))))
    levels = np.unique(np.round(levels, 3))
    warm = np.clip(288.0 - 6.5 * np.minimum(levels, 11.0) + generator.normal(0.0, 12.0, levels.size), 190.0, 320.0)
    wet = np.where(generator.random(levels.size) < 0.2, 0.0, generator.uniform(0.0, 100.0, levels.size))
    scale = _SCALE_HEIGHT * (warm[1:] + warm[:-1]) / 2  # of the air between two levels, km
    pressure = 1013.0 * np.exp(-levels[0] / 7.5 - np.cumsum(np.append(0.0, np.diff(levels) / scale)))
    rows = (f"{z},{p:.6f},{t:.2f},{u:.2f}" for z, p, t, u in zip(levels, pressure, warm, wet))
    text = "\n".join(["altitude[km],pressure[hPa],temperature[K],relative_humidity[%]", *rows]) + "\n"
    return read_sounding(text, Path("drawn.csv"), load_profile(name))


def _extreme(generator, values: np.ndarray, ends: tuple[float, ...]) -> np.ndarray:
    """The values, some of them replaced by the ends of what is allowed."""
    return np.where(generator.random(values.size) < 0.3, generator.choice(ends, values.size), values)


def texture_case(generator: np.random.Generator) -> dict[str, tuple[float, float]]:
    """Materials of one seed, of one colour, of colours on a line; posteriors of any colour."""
    from skyshine.tmm.classify import fit

    count = int(generator.integers(1, 12))
    seeds, number = [], []
    for material in range(count):
        size = int(generator.choice([1, 2, 3, 500]))
        spread = float(generator.choice([0.0, 1e-9, 1.0, 60.0]))
        centre = generator.uniform([0, -100, -100], [100, 100, 100])
        if generator.random() < 0.3:
            centre = np.array([50.0, 0.0, 0.0])  # several materials of the very same colour
        across = generator.normal(size=(1, 3)) if generator.random() < 0.3 else np.ones((1, 3))
        seeds.append(centre + spread * generator.normal(size=(size, 1 if across.any() and generator.random() < 0.5 else 3)) * across)
        number += [material] * size
    names = tuple(f"m{k}" for k in range(count))
    prior = {name: float(np.exp(generator.uniform(-20, 20))) for name in names}
    model = fit(np.concatenate(seeds), np.array(number), names, prior)
    colours = generator.uniform([-10, -150, -150], [110, 150, 150], (200, 3))
    log = model.log_posterior(model.squared_distance(colours))
    return {
        "not finite": (float(np.count_nonzero(np.isnan(log) | (log == np.inf))), 0.0),
        "posterior off 1": (float(np.abs(np.exp(log).sum(axis=0) - 1).max()), 1e-9),
    }


PARTS = {"surface": surface_case, "atmosphere": atmosphere_case, "texture": texture_case}
