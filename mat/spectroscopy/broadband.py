"""Choice of the points that stand for the whole thermal and the whole solar spectrum in fluxes on the ground.

The absorption table's points are reduced by the method that chose them (`atmosphere.selection`), with fluxes at many
altitudes, under many states, as targets. The error is measured on states of a profile that no choice has seen.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from skyshine.mat.atmosphere.band.selection import select_points
from skyshine.mat.atmosphere.particles.aerosol import AerosolModel
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.sources.sun_and_moon import solar_irradiance
from skyshine.mat.atmosphere.spectra.fluxes import (
    FILETYPE,
    LONGWAVE,
    QUANTITIES,
    SHORTWAVE,
    sky_emission,
    sunlight_shares,
)
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.profiles import load_profile
from skyshine.mat.atmosphere.state.state import AerosolComponent, AtmosphericState
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.spectroscopy.training import HELD_OUT_PROFILE, TRAINING_PROFILES
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, write_file

FORMAT_VERSION = "1.0"
PERTURBED, HELD_OUT = 8, 10  # perturbed versions of each training profile, and of the held-out one
HEIGHTS = np.array([0.0, 0.5e3, 1e3, 2e3, 3e3, 5e3, 8e3])  # m above the ground
ELEVATIONS = np.array([-4.0, 0.5, 3.0, 8.0, 15.0, 30.0, 50.0, 75.0])  # degree
CANDIDATES = 1600
REGIONS = 16  # of the spectrum, of equal energy: each gives its share of the candidates
TOLERANCE, MOST_POINTS = 0.025, 96
# A flux's error counts in units of 1 W m^-2 and 1 % of the flux: the tolerance is 0.025 W m^-2 and 0.025 % of it.
_UNIT, _RELATIVE = 1.0, 0.01
_WEIGHT_TEMPERATURE = 260.0  # K, of the black body whose flux the weights of the thermal points hold exactly
_BLACK_TEMPERATURES = np.linspace(200.0, 330.0, 8)  # K: an opaque sky
_CHUNK = 1024  # points treated together, for memory
_AEROSOLS = ("none", "rural", "rural", "urban", "maritime", "tropospheric", "fog_radiation")
# Cloud in every third state: particles of fog, 10 um and more, in a layer 1 km thick.
_CLOUD_MODEL, _CLOUD_BASES, _CLOUD_DEPTHS = "fog_advection", (0.5e3, 8e3), (0.3, 60.0)


def training_states(seed=11):
    """States whose fluxes are targets: the training profiles, each as it is and `PERTURBED` times otherwise."""
    rng = np.random.default_rng(seed)
    plain = [AtmosphericState.from_profile(name) for name in TRAINING_PROFILES]
    return plain + [perturbed_state(name, rng) for name in TRAINING_PROFILES for _ in range(PERTURBED)]


def held_out_states(seed=12):
    """States on which the error is measured."""
    rng = np.random.default_rng(seed)
    return [AtmosphericState.from_profile(HELD_OUT_PROFILE)] + [
        perturbed_state(HELD_OUT_PROFILE, rng) for _ in range(HELD_OUT)
    ]


def perturbed_state(name, rng):
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


def _with_cloud(state, rng):
    base = state.surface_altitude + rng.uniform(*_CLOUD_BASES)
    depth = np.exp(rng.uniform(*np.log(_CLOUD_DEPTHS)))
    inside = (state.altitude >= base) & (state.altitude <= base + 1e3)
    component = AerosolComponent(AerosolModel.load(_CLOUD_MODEL), np.where(inside, depth / 1e3, 0.0))
    return replace(state, aerosols=(*state.aerosols, component))


def _sky_emission(state, points):
    return sky_emission(state, points, state.surface_altitude + HEIGHTS)


def longwave_targets(states, points):
    """Thermal fluxes (M, P) W m^-2 (cm^-1)^-1 of the states at `HEIGHTS`."""
    return np.concatenate([_in_chunks(partial(_sky_emission, state), points) for state in states])


def shortwave_targets(states, points):
    """Direct and diffuse shares of sunlight (M, P) each, of the states at `HEIGHTS` and `ELEVATIONS`."""

    def shares(state, part):
        altitude = state.surface_altitude + HEIGHTS
        both = sunlight_shares(state, part, altitude, ELEVATIONS, state.surface_albedo)
        return np.stack(both).reshape(2, altitude.size * ELEVATIONS.size, -1).astype(np.float32)

    parts = [_in_chunks(partial(shares, state), points) for state in states]
    return np.concatenate(parts, axis=1)


def _in_chunks(evaluate, points):
    size = points.wavenumber.size
    return np.concatenate(
        [evaluate(points.subset(np.arange(s, min(s + _CHUNK, size)))) for s in range(0, size, _CHUNK)], axis=-1
    )


def choose(rows, weight, *, tolerance=TOLERANCE, max_points=MOST_POINTS):
    """Points and weights that hold weighted sums.

    Parameters
    ----------
    rows : (M, P) array
        Targets at each point.
    weight : (P,) array
        Such that ``rows @ weight`` are fluxes, W m^-2.
    tolerance : float
        Rms of the errors over 1 W m^-2 and 1 % of the flux.
    max_points : int

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


def _candidates(rows, weight):
    """Indices of candidates: from regions of equal weight, evenly over the mean target in each."""
    region = np.minimum((REGIONS * np.cumsum(weight) / weight.sum()).astype(int), REGIONS - 1)
    mean, found = rows.mean(axis=0), []
    for number in range(REGIONS):
        mine = np.flatnonzero(region == number)
        order = mine[np.argsort(mean[mine], kind="stable")]
        found.append(order[np.unique(np.linspace(0, order.size - 1, CANDIDATES // REGIONS).astype(int))])
    return np.sort(np.concatenate(found))


def build(out, table, *, tolerance=TOLERANCE, max_points=MOST_POINTS, progress=None):
    """Choose the broadband points of an absorption table and write them.

    Parameters
    ----------
    out : path
    table : AbsorptionTable
    tolerance, max_points
        As `choose`.
    progress : callable, optional
        Called after each of the four stages.

    Returns
    -------
    dict
        Numbers of points by spectrum, and errors by quantity: {"max", "p95", "rms"} in W m^-2.
    """
    training, unseen = training_states(), held_out_states()
    step = progress or (lambda: None)
    thermal = table.points(*LONGWAVE)
    middle = thermal.interval_edges.mean(axis=1)[thermal.interval]
    black = np.pi * planck_wavenumber(middle, _WEIGHT_TEMPERATURE)
    opaque = np.pi * planck_wavenumber(middle, _BLACK_TEMPERATURES[:, None])
    rows = np.concatenate([longwave_targets(training, thermal), opaque])
    index, weight = choose(rows / black, thermal.weight * black, tolerance=tolerance, max_points=max_points)
    longwave, weight = index, weight / black[index]
    step()
    exact = longwave_targets(unseen, thermal)
    errors = {"longwave_down": _summary(exact[:, longwave] @ weight - exact @ thermal.weight)}
    groups = {"longwave": _points_group(longwave, weight, middle, "cm-1", "weight of the point")}
    step()

    solar = table.points(*SHORTWAVE)
    middle = solar.interval_edges.mean(axis=1)[solar.interval]
    width = np.diff(solar.interval_edges, axis=1)[solar.interval, 0]
    sunlight = solar.weight * solar_irradiance(middle, width)
    rows = np.concatenate(shortwave_targets(training, solar))
    index, weight = choose(rows, sunlight, tolerance=tolerance, max_points=max_points)
    step()
    for name, exact in zip(QUANTITIES[1:], shortwave_targets(unseen, solar), strict=True):
        errors[name] = _summary(exact[:, index] @ weight - exact @ sunlight)
    groups["shortwave"] = _points_group(index, weight, middle, "W m-2", "sunlight that the point stands for, at 1 au")
    step()

    groups["errors"] = Group(groups={name: Group(attributes=errors[name]) for name in QUANTITIES})
    about = {
        "absorption_sha256": table.content,
        "description": (
            "Points of the absorption table and their weights, for broadband fluxes on the ground; errors in W m-2"
            " against all points, on states of a profile that was not used in the choice."
        ),
    }
    job = f"mat lines broadband; tolerance {tolerance:g}, max_points {max_points}"
    header = Header(FILETYPE, FORMAT_VERSION, table.version, job, title="skyshine broadband points")
    write_file(out, Group(groups=groups, attributes=about), header)
    return {"points": {"longwave": longwave.size, "shortwave": index.size}, "errors": errors}


def _points_group(index, weight, wavenumber, units, long_name):
    return Group(
        axes={"point": Axis(wavenumber[index], "cm-1", "middle of the point's interval")},
        variables={
            "index": Variable(
                ("point",), index.astype(np.int32), "1", "place of the point among the table's of this spectrum"
            ),
            "weight": Variable(("point",), weight, units, long_name),
        },
    )


def _summary(error):
    size = np.abs(error)
    return {"max": float(size.max()), "p95": float(np.percentile(size, 95)), "rms": float(np.sqrt(np.mean(error**2)))}
