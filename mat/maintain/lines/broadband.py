"""Choice of the points that represent the whole thermal and the whole solar spectrum in fluxes.

The absorption table's points are reduced by the method that chose them (`atmosphere.selection`), with fluxes at many
altitudes, under many states, as targets: thermal ones from the sky for the heat balance, and, by other points, upward
and downward ones from the ground to space. The error is measured on states of a profile that no choice has seen.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.band.selection import select_points
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.gases.spectral_points import SpectralPoints
from skyshine.mat.atmosphere.particles.aerosol import AerosolModel
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.spectra.fluxes import (
    FILETYPE,
    LONGWAVE,
    QUANTITIES,
    SHORTWAVE,
    sky_emission,
    sunlight_shares,
)
from skyshine.mat.atmosphere.spectra.level_fluxes import LevelFluxes
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.profiles import load_profile
from skyshine.mat.atmosphere.state.state import AerosolComponent, AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.spectroscopy.training import HELD_OUT_PROFILE, TRAINING_PROFILES
from skyshine.schemas.arrays import Floats, Integers, Reals
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, write_file

PERTURBED, HELD_OUT = 8, 10  # perturbed versions of each training profile, and of the held-out one
HEIGHTS = np.array([0.0, 0.5e3, 1e3, 2e3, 3e3, 5e3, 8e3])  # m above the ground
LEVELS = np.array([0.0, 0.5, 1, 2, 3, 5, 8, 11, 15, 20, 30, 50, 100]) * 1e3  # m above sea level, of upward fluxes too
ELEVATIONS = np.array([-4.0, 0.5, 3.0, 8.0, 15.0, 30.0, 50.0, 75.0])  # degree
CANDIDATES = 1600  # points, drawn in equal parts from the regions
REGIONS = 16  # regions of the spectrum, of equal energy: each gives its share of the candidates
TOLERANCE, MAX_POINTS = 0.0125, 96  # error of transmittance; spectral points of a band
# A flux's error counts in units of 1 W m^-2 and 1 % of the flux: the tolerance is 0.0125 W m^-2 and 0.0125 % of it.
_UNIT, _RELATIVE = 1.0, 0.01
_WEIGHT_TEMPERATURE = 260.0  # K, of the black body whose flux the weights of the thermal points give exactly
_BLACK_TEMPERATURES = np.linspace(200.0, 330.0, 8)  # K: an opaque sky
_CHUNK = 1024  # points treated together, for memory
Emission = Callable[[AtmosphericState, SpectralPoints], Floats]
_AEROSOLS = ("none", "rural", "rural", "urban", "maritime", "tropospheric", "fog_radiation")
# Cloud in every third state: particles of fog, 10 um and more, in a layer 1 km thick.
_CLOUD_MODEL, _CLOUD_BASES, _CLOUD_DEPTHS = "fog_advection", (0.5e3, 8e3), (0.3, 60.0)


def training_states(seed: int = 11) -> list[AtmosphericState]:
    """States whose fluxes are targets: the training profiles, each as it is and `PERTURBED` times otherwise."""
    rng = np.random.default_rng(seed)
    plain = [AtmosphericState.from_profile(name) for name in TRAINING_PROFILES]
    return plain + [perturbed_state(name, rng) for name in TRAINING_PROFILES for _ in range(PERTURBED)]


def held_out_states(seed: int = 12) -> list[AtmosphericState]:
    """States on which the error is measured."""
    rng = np.random.default_rng(seed)
    return [AtmosphericState.from_profile(HELD_OUT_PROFILE)] + [
        perturbed_state(HELD_OUT_PROFILE, rng) for _ in range(HELD_OUT)
    ]


def perturbed_state(name: str, rng: np.random.Generator) -> AtmosphericState:
    """A profile with other temperature, gases, ground, particles, and sometimes cloud."""
    profile = load_profile(name)
    profile = replace(profile, temperature=np.clip(profile.temperature + rng.uniform(-15.0, 15.0), 155.0, 345.0))
    factors = {gas: float(np.exp(rng.uniform(np.log(0.6), np.log(1.6)))) for gas in ("O3", "CH4", "N2O", "CO")}
    state = AtmosphericState.from_profile(
        profile,
        surface_altitude=float(rng.choice([0.0, 0.0, 500.0, 2000.0, 4000.0])),
        gas_amounts=GasAmounts(
            ppm={"CO2": float(rng.uniform(280.0, 800.0))},
            scale={"H2O": float(np.exp(rng.uniform(np.log(0.1), np.log(3.0)))), **factors},
        ),
        aerosol=Aerosol(
            str(rng.choice(_AEROSOLS)), visibility_km=float(np.exp(rng.uniform(np.log(1.0), np.log(150.0))))
        ),
        surface_albedo=float(rng.uniform(0.0, 0.9)),
    )
    return _with_cloud(state, rng) if rng.random() < 1 / 3 else state


def _with_cloud(state: AtmosphericState, rng: np.random.Generator) -> AtmosphericState:
    base = state.surface_altitude + rng.uniform(*_CLOUD_BASES)
    depth = np.exp(rng.uniform(*np.log(_CLOUD_DEPTHS)))
    inside = (state.altitude >= base) & (state.altitude <= base + 1e3)
    component = AerosolComponent(AerosolModel.load(_CLOUD_MODEL), np.where(inside, depth / 1e3, 0.0))
    return replace(state, aerosols=(*state.aerosols, component))


def _sky_emission(state: AtmosphericState, points: SpectralPoints) -> Floats:
    """Thermal fluxes (M, P) of the sky at `HEIGHTS`, W m^-2 (cm^-1)^-1."""
    return np.asarray(sky_emission(state, points, state.surface_altitude + HEIGHTS))


def _level_emission(state: AtmosphericState, points: SpectralPoints) -> Floats:
    """Upward, then downward thermal fluxes (M, P) near `LEVELS`, W m^-2 (cm^-1)^-1."""
    levels = np.unique(np.abs(state.altitude[:, None] - LEVELS).argmin(axis=0))
    fluxes = LevelFluxes.of(state, points, [])
    return np.concatenate([fluxes.thermal_up[levels], fluxes.thermal_down[levels[:-1]]])


def longwave_targets(emission: Emission, states: Sequence[AtmosphericState], points: SpectralPoints) -> Reals:
    """Thermal fluxes (M, P) W m^-2 (cm^-1)^-1 of the states."""
    return np.concatenate([_in_chunks(partial(emission, state), points) for state in states])


def shortwave_targets(states: Sequence[AtmosphericState], points: SpectralPoints) -> Reals:
    """Direct and diffuse shares of sunlight (M, P) each, of the states at `HEIGHTS` and `ELEVATIONS`."""

    def shares(state: AtmosphericState, part: SpectralPoints) -> Reals:
        altitude = state.surface_altitude + HEIGHTS
        both = sunlight_shares(SpectralAir.of(state, part), altitude, ELEVATIONS, state.mean_albedo)
        return np.stack(both).reshape(2, altitude.size * ELEVATIONS.size, -1).astype(np.float32)

    parts = [_in_chunks(partial(shares, state), points) for state in states]
    return np.concatenate(parts, axis=1)


def _in_chunks(evaluate: Callable[[SpectralPoints], Reals], points: SpectralPoints) -> Reals:
    size = points.wavenumber.size
    return np.concatenate(
        [evaluate(points.subset(np.arange(s, min(s + _CHUNK, size)))) for s in range(0, size, _CHUNK)], axis=-1
    )


def choose(
    rows: Reals, weight: Floats, *, tolerance: float = TOLERANCE, max_points: int = MAX_POINTS
) -> tuple[Integers, Floats]:
    """Points and weights that preserve weighted sums.

    Parameters
    ----------
    rows : (M, P) array
        Targets at each point.
    weight : (P,) array
        Such that ``rows @ weight`` are fluxes, W m^-2.
    tolerance : float
        Rms of the errors over 1 W m^-2 and 1 % of the flux.

    Returns
    -------
    index, weight : (k,) arrays
    """
    flux = rows @ weight
    candidates = _candidates(rows, weight)
    chosen, weights, _ = select_points(
        rows[:, candidates].T.astype(float),
        flux / weight.sum(),
        tolerance=tolerance,
        max_points=max_points,
        total_weight=weight.sum(),
        row_scale=weight.sum() / (_UNIT + _RELATIVE * flux),
        exchanges=2,
    )
    order = np.argsort(candidates[chosen])
    return candidates[chosen][order], weights[order]


def _candidates(rows: Reals, weight: Floats) -> Integers:
    """Indices of candidates: from regions of equal weight, evenly over the mean target in each."""
    region = np.minimum((REGIONS * np.cumsum(weight) / weight.sum()).astype(int), REGIONS - 1)
    mean, chosen = rows.mean(axis=0), []
    for number in range(REGIONS):
        members = np.flatnonzero(region == number)
        order = members[np.argsort(mean[members], kind="stable")]
        chosen.append(order[np.unique(np.linspace(0, order.size - 1, CANDIDATES // REGIONS).astype(int))])
    return np.sort(np.concatenate(chosen))


def build(
    out: str | os.PathLike[str],
    table: AbsorptionTable,
    *,
    tolerance: float = TOLERANCE,
    max_points: int = MAX_POINTS,
    progress: Callable[[], object] | None = None,
) -> dict[str, Any]:
    """Choose the broadband points of an absorption table and write them.

    Parameters
    ----------
    out : path
    table : AbsorptionTable
    tolerance, max_points
        As `choose`.
    progress : callable, optional
        Called after each of the six stages.

    Returns
    -------
    dict
        Numbers of points by spectrum, and errors by quantity: {"max", "p95", "rms"} in W m^-2.
    """
    training, unseen = training_states(), held_out_states()
    step = progress or (lambda: None)
    limits = {"tolerance": tolerance, "max_points": max_points}
    longwave, sky_error = _longwave(_sky_emission, table, training, unseen, step, **limits)
    levels, level_error = _longwave(_level_emission, table, training, unseen, step, **limits)
    shortwave, solar_errors = _shortwave(table, training, unseen, step, **limits)
    errors = {"longwave_down": sky_error, "longwave_levels": level_error, **solar_errors}
    groups = {
        "longwave": longwave,
        "longwave_levels": levels,
        "shortwave": shortwave,
        "errors": Group(groups={name: Group(attributes=errors[name]) for name in QUANTITIES}),
    }
    about = {
        "absorption_sha256": table.content,
        "description": (
            "Points of the absorption table and their weights, for broadband fluxes; errors in W m-2"
            " against all points, on states of a profile that was not used in the choice."
        ),
    }
    job = f"python -m mat.maintain.lines broadband; tolerance {tolerance:g}, max_points {max_points}"
    header = Header(FILETYPE, table.version, job, title="skyshine broadband points")
    write_file(out, Group(groups=groups, attributes=about), header)
    counts = {name: groups[name].axes["point"].values.size for name in groups if name != "errors"}
    return {"points": counts, "errors": errors}


def _longwave(
    emission: Emission,
    table: AbsorptionTable,
    training: Sequence[AtmosphericState],
    unseen: Sequence[AtmosphericState],
    step: Callable[[], object],
    **limits: Any,
) -> tuple[Group, dict[str, float]]:
    """The points of thermal fluxes, and their error."""
    points = table.points(*LONGWAVE)
    middle = points.interval_edges.mean(axis=1)[points.interval]
    black = np.pi * planck_wavenumber(middle, _WEIGHT_TEMPERATURE)
    opaque = np.pi * planck_wavenumber(middle, _BLACK_TEMPERATURES[:, None])
    rows = np.concatenate([longwave_targets(emission, training, points), opaque])
    index, weight = choose(rows / black, points.weight * black, **limits)
    weight = weight / black[index]
    step()
    exact = longwave_targets(emission, unseen, points)
    error = _summary(exact[:, index] @ weight - exact @ points.weight)
    step()
    return _points_group(index, weight, middle, "cm-1", "weight of the point"), error


def _shortwave(
    table: AbsorptionTable,
    training: Sequence[AtmosphericState],
    unseen: Sequence[AtmosphericState],
    step: Callable[[], object],
    **limits: Any,
) -> tuple[Group, dict[str, dict[str, float]]]:
    """The solar points, and their error by quantity."""
    points = table.points(*SHORTWAVE)
    middle = points.interval_edges.mean(axis=1)[points.interval]
    width = np.diff(points.interval_edges, axis=1)[points.interval, 0]
    sunlight = points.weight * solar_irradiance(middle, width)
    rows = np.concatenate(shortwave_targets(training, points))
    index, weight = choose(rows, sunlight, **limits)
    step()
    errors = {
        name: _summary(exact[:, index] @ weight - exact @ sunlight)
        for name, exact in zip(QUANTITIES[2:], shortwave_targets(unseen, points), strict=True)
    }
    step()
    return _points_group(index, weight, middle, "W m-2", "sunlight that the point stands for, at 1 au"), errors


def _points_group(index: Integers, weight: Floats, wavenumber: Floats, units: str, long_name: str) -> Group:
    return Group(
        axes={"point": Axis(wavenumber[index], "cm-1", "middle of the point's interval")},
        variables={
            "index": Variable(
                ("point",), index.astype(np.int32), "1", "place of the point among the table's of this spectrum"
            ),
            "weight": Variable(("point",), weight, units, long_name),
        },
    )


def _summary(error: Reals) -> dict[str, float]:
    size = np.abs(error)
    return {"max": float(size.max()), "p95": float(np.percentile(size, 95)), "rms": float(np.sqrt(np.mean(error**2)))}
