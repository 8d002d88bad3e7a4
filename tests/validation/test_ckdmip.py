"""Fluxes of 50 atmospheres at the ground and at the top against line-by-line fluxes of CKDMIP, by water vapour.

Evaluation-1 of the Correlated K-Distribution Model Intercomparison Project (Hogan and Matricardi 2020, Geosci. Model
Dev. 13, 6501), present day: LBLRTM 12.8, no particles; longwave over a black ground, sunlight over an albedo of 0.15.
Its water vapour continuum is older than MT_CKD 4.2: longwave is a test of lines, band model and transfer with
`mt_ckd_2.4`; what `mt_ckd_4.3_closure` and `mt_ckd_4.3` change is printed beside: -3 and -5.5 W m-2 beyond 45 mm. The
profiles are thinned to layers of 100 hPa, which scatters single ones by 1 W m-2. Run with ``-s`` for the tables.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.io import netcdf_file

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.spectra.fluxes import BroadbandPoints
from skyshine.mat.atmosphere.spectra.level_fluxes import LevelFluxes
from skyshine.mat.atmosphere.state.state import AtmosphericState

pytestmark = [pytest.mark.validation, pytest.mark.shared_data]  # 4 minutes

GASES = {
    name: f"{name.lower().replace('-', '')}_mole_fraction_fl"
    for name in ("H2O", "O3", "CO2", "CH4", "N2O", "CFC-11", "CFC-12", "O2", "N2")
}
CLASSES = ((0.0, 5.0), (5.0, 15.0), (15.0, 30.0), (30.0, 45.0), (45.0, 100.0))  # mm of water
CONTINUA = ("mt_ckd_2.4", "mt_ckd_4.3_closure", "mt_ckd_4.3")
ALBEDO = 0.15
EDGE = 0.01  # of a layer, in the logarithm of pressure
GRAVITY, GAS_CONSTANT, WATER_MASS, AIR_MASS = 9.80665, 8.314463, 0.0180153, 0.0289644  # m s-2, J mol-1 K-1, kg mol-1
TSIS = 1361.0  # W m-2, of the points with what lies outside them (Coddington et al. 2021)
LOWEST_MU = 0.3  # cosine of the Sun's zenith angle; below, a plane layer is no longer a shell
# W m-2, means of a class: longwave down at the ground and up at the top; shares of sunlight down at the ground, up at
# the top.
LONGWAVE_DOWN, LONGWAVE_UP, SUNLIGHT, SUNLIGHT_UP = 1.5, 2.0, 0.005, 0.002


def read(folder, name):
    with netcdf_file(folder / "ckdmip" / f"ckdmip_evaluation1_{name}_present_reduced.nc", mmap=False) as file:
        return {key: variable.data.astype(float) for key, variable in file.variables.items()}


@pytest.fixture(scope="module")
def atmospheres(shared_data):
    """States and precipitable water [mm] (50,)."""
    given = read(shared_data, "concentrations")
    states, water = [], []
    for row in range(len(given["pressure_hl"])):
        edge, kelvin = given["pressure_hl"][row][::-1], given["temperature_hl"][row][::-1]
        edge = np.maximum(edge, 1e-2)
        fraction = {name: given[key][row][::-1] for name, key in GASES.items()}
        water.append(np.sum(fraction["H2O"] * -np.diff(edge)) * WATER_MASS / AIR_MASS / GRAVITY)
        # The layers of LBLRTM are even, some 100 hPa thick: two levels close to each edge.
        step = EDGE * -np.diff(np.log(edge))
        logarithm = np.sort(np.concatenate([-np.log(edge[:-1]) + step, -np.log(edge[1:]) - step]))
        logarithm[0], logarithm[-1] = -np.log(edge[[0, -1]])
        pressure, temperature = np.exp(-logarithm), np.interp(logarithm, -np.log(edge), kelvin)
        mole = {name: np.repeat(np.maximum(x, 1e-20), 2) for name, x in fraction.items()}
        mass = AIR_MASS * (1 - mole["H2O"]) + WATER_MASS * mole["H2O"]
        scale = GAS_CONSTANT * temperature / (mass * GRAVITY)
        height = np.append(0.0, np.cumsum(0.5 * (scale[1:] + scale[:-1]) * np.diff(logarithm)))
        below = height <= 100e3
        state = AtmosphericState(
            name=f"ckdmip {row}",
            altitude=height[below],
            pressure=pressure[below],
            temperature=temperature[below],
            mole_fraction={name: x[below] for name, x in mole.items()},
            aerosols=(),
            surface_temperature=float(kelvin[0]),
            surface_albedo=0.0,
        )
        vapour = state.mole_fraction["H2O"] * water[-1] / state.precipitable_water(0.0)
        states.append(replace(state, mole_fraction=state.mole_fraction | {"H2O": vapour}))
    return states, np.array(water)


@cache
def points(continuum):
    return BroadbandPoints.open(table=AbsorptionTable.open(water_continuum=continuum))


def by_class(water, values, title, unit):
    """Mean and rms of differences (50, K) in each class of water vapour, printed."""
    print(f"\n{title}, {unit}: mean and rms by mm of water")
    means = []
    for low, high in CLASSES:
        rows = (water >= low) & (water < high)
        means.append(values[rows].mean(axis=0))
        rms = np.sqrt(np.mean(values[rows] ** 2, axis=0))
        cells = "   ".join(f"{mean:+8.3f} {size:7.3f}" for mean, size in zip(means[-1], rms, strict=True))
        print(f"{low:4.0f} to {high:3.0f} mm ({rows.sum():2d}): {cells}")
    return np.array(means)


def test_longwave(shared_data, atmospheres):
    states, water = atmospheres
    theirs = read(shared_data, "lw_fluxes")
    down, up = np.empty((2, len(states), len(CONTINUA)))
    for row, state in enumerate(states):
        for column, continuum in enumerate(CONTINUA):
            longwave = points(continuum).longwave
            fluxes = LevelFluxes.of(state, longwave, [])
            down[row, column] = fluxes.thermal_down[0] @ longwave.weight - theirs["flux_dn_lw"][row, -1]
            up[row, column] = fluxes.thermal_up[-1] @ longwave.weight - theirs["flux_up_lw"][row, 0]
    print(f"\n{CONTINUA}")
    at_ground = by_class(water, down, "longwave down at the ground, ours less LBLRTM", "W m-2")
    at_top = by_class(water, up, "longwave up at the top, ours less LBLRTM", "W m-2")
    assert np.abs(at_ground[:, 0]).max() <= LONGWAVE_DOWN
    assert np.abs(at_top[:, 0]).max() <= LONGWAVE_UP


def test_shortwave(shared_data, atmospheres):
    states, water = atmospheres
    theirs = read(shared_data, "sw_fluxes")
    shortwave = points("mt_ckd_4.3_closure").shortwave
    used = theirs["mu0"] >= LOWEST_MU
    elevation = np.degrees(np.arcsin(theirs["mu0"][used]))
    down, up = np.empty((2, len(states), used.sum()))
    for row, state in enumerate(states):
        fluxes = LevelFluxes.of(replace(state, surface_albedo=ALBEDO), shortwave, elevation)
        top = theirs["flux_dn_sw"][row, used, 0]
        sunlight = shortwave.weight * (top / theirs["mu0"][used]).mean() / TSIS
        whole = fluxes.in_band(np.zeros(sunlight.size), sunlight)
        ground = whole.direct[0, :, 0] + whole.diffuse_down[0, :, 0]
        down[row] = (ground - theirs["flux_dn_sw"][row, used, -1]) / theirs["flux_dn_sw"][row, used, -1]
        up[row] = (whole.diffuse_up[-1, :, 0] - theirs["flux_up_sw"][row, used, 0]) / top
    print(f"\ncosines of the Sun's zenith angle: {theirs['mu0'][used]}")
    at_ground = by_class(water, 100 * down, "sunlight down at the ground, ours over LBLRTM's less 1", "%")
    at_top = by_class(water, 100 * up, "sunlight up at the top, ours less LBLRTM's over that arriving", "%")
    assert np.abs(at_ground).max() <= 100 * SUNLIGHT
    assert np.abs(at_top).max() <= 100 * SUNLIGHT_UP
