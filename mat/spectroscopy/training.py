"""Atmospheres and paths on which spectral points are chosen, and the held-out ones on which the choice is measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from skyshine.mat.atmosphere.gases.path_states import PathState
from skyshine.mat.atmosphere.state.profiles import load_profile
from skyshine.mat.radiometry.constants import BOLTZMANN
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.arrays import Booleans, Floats

TRAINING_PROFILES = ("tropical", "midlatitude_summer", "midlatitude_winter", "subarctic_summer", "subarctic_winter")
HELD_OUT_PROFILE = "us_standard"
# Levels of the training columns, km: fine where water vapour is.
LEVELS = 1e3 * np.array(
    [0, 0.5, 1, 1.5, 2, 3, 4, 5, 6, 7.5, 9, 10.5, 12, 14, 16, 18, 20, 23, 26, 30, 35, 40, 45, 50, 60, 70, 85, 100.0]
)
PERTURBED = (
    5  # perturbed versions of each training profile; with 2 the largest errors on unseen paths were twice as large
)
GRAZING_AIR_MASS = 38.0  # sea-level air mass at the horizon (Kasten and Young 1989)
MAX_H2O = 0.06  # mole fraction
# Training states of reference spectra: of each profile one, the first unchanged. Of their paths, and of those of the
# held-out states, every seventh: to space, between levels and horizontal, of all lengths.
REFERENCE_STATES, REFERENCE_PATHS = (0, 8, 14, 21, 28), 7


def training_states(perturbed: int = PERTURBED, seed: int = 1) -> list[PathState]:
    """The training atmospheres: each profile as it is and `perturbed` times with other humidity, temperature and
    gases.
    """
    rng = np.random.default_rng(seed)
    states = []
    for name in TRAINING_PROFILES:
        states.append(path_state(name, rng))
        states += [path_state(name, rng, *_perturbation(rng)) for _ in range(perturbed)]
    return states


def held_out_states(seed: int = 2) -> list[PathState]:
    """Atmospheres and paths that no choice has seen: another profile, other perturbations, other ranges."""
    rng = np.random.default_rng(seed)
    return [path_state(HELD_OUT_PROFILE, rng)] + [
        path_state(HELD_OUT_PROFILE, rng, *_perturbation(rng)) for _ in range(2)
    ]


def reference_states() -> tuple[list[PathState], list[PathState]]:
    """Atmospheres with some of their paths for reference spectra: those for fits, and the held-out ones for tests."""
    training = training_states()
    fit, test = [training[number] for number in REFERENCE_STATES], held_out_states()
    return [_some_paths(state) for state in fit], [_some_paths(state) for state in test]


def _some_paths(state: PathState) -> PathState:
    return replace(state, columns=state.columns[::REFERENCE_PATHS], apart=state.apart[::REFERENCE_PATHS])


def _perturbation(rng: np.random.Generator) -> tuple[float, float, float]:
    """Factor of the humidity, warming in K, and factor of the other gases."""
    humidity = np.exp(rng.uniform(np.log(0.1), np.log(3.0)))
    others = np.exp(rng.uniform(np.log(0.75), np.log(1.4)))
    return humidity, rng.uniform(-15.0, 15.0), others


def path_state(
    name: str, rng: np.random.Generator, humidity: float = 1.0, warming: float = 0.0, others: float = 1.0
) -> PathState:
    """A standard profile with its water vapour (at most saturated) and its other gases multiplied, warmer by some K,
    and with paths whose lengths are random.
    """
    profile = load_profile(name)
    z = profile.altitude
    pressure = np.exp(np.interp(LEVELS, z, np.log(profile.pressure)))
    temperature = np.clip(np.interp(LEVELS, z, profile.temperature) + warming, 150.0, 350.0)
    fraction = {
        gas: np.exp(np.interp(LEVELS, z, np.log(x))) for gas, x in profile.mole_fraction.items() if np.all(x > 0)
    }
    saturated = saturation_pressure(np.maximum(temperature, 200.0)) / pressure
    fraction["H2O"] = np.minimum(np.minimum(fraction["H2O"] * humidity, saturated), MAX_H2O)
    for gas in set(fraction) - {"H2O", "N2", "O2"}:
        fraction[gas] = fraction[gas] * others
    density = pressure / (BOLTZMANN * temperature)
    columns, apart = _paths(density, rng)
    return PathState(pressure, temperature, fraction["H2O"], fraction, columns, apart, _sky_paths(density))


def _vertical(density: Floats, bottom: int, top: int) -> Floats:
    """Air columns between two levels, shared between the levels of each slab (trapezoids); (L,)."""
    thickness = np.diff(LEVELS)[bottom:top]
    columns = np.zeros(LEVELS.size)
    columns[bottom:top] += 0.5 * thickness * density[bottom:top]
    columns[bottom + 1 : top + 1] += 0.5 * thickness * density[bottom + 1 : top + 1]
    return columns


def _paths(density: Floats, rng: np.random.Generator) -> tuple[Floats, Booleans]:
    """Air columns (R, L) of the paths through air of a density (L,) m^-3; paths whose gases are targets too (R,)."""
    top = LEVELS.size - 1
    columns, apart = [], []
    for bottom in (0, 3, 7, 12, 16, 20):  # to space, from the ground to 30 km and more
        for mass in (1.0, rng.uniform(1.3, 3.0), rng.uniform(4.0, 15.0), GRAZING_AIR_MASS):
            columns.append(mass * _vertical(density, bottom, top))
            apart.append(mass == 1.0 or mass == GRAZING_AIR_MASS)
    for bottom, end in ((0, 2), (0, 5), (0, 9), (2, 7), (5, 10), (9, 14)):
        for mass in (1.0, rng.uniform(1.5, 10.0), rng.uniform(10.0, 40.0)):
            columns.append(mass * _vertical(density, bottom, end))
            apart.append(False)
    for level in (0, 0, 2, 5, 9, 12, 16, 19):
        for decade in (10.0, 100.0, 1e3, 1e4, 1e5):
            column = np.zeros(LEVELS.size)
            column[level] = density[level] * decade * 10 ** rng.uniform(0.0, 1.0 if decade < 1e5 else 0.48)
            columns.append(column)
            apart.append(level < 9)
    return np.array(columns), np.array(apart)


def _sky_paths(density: Floats) -> list[Floats]:
    """Slabs of the sky seen from the ground and aloft, near zenith and low."""
    paths = []
    for bottom, mass in ((0, 1.66), (0, 10.0), (7, 1.66), (12, 3.0)):
        slabs = [mass * _vertical(density, s, s + 1) for s in range(bottom, LEVELS.size - 1)]
        paths.append(np.array(slabs))
    return paths
