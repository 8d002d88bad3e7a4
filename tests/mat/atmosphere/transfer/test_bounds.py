"""Bounds of what may be left out hold against the whole computation, in every kind of air, and are not far beyond
it.
"""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer import bounds, optics
from skyshine.mat.atmosphere.transfer.bounds import Scattering
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import SpectralResponse

# Observers from the ground to space, lines through the tangent point, the Sun in front, behind, above and below the
# horizon.
GRID = PathGrid(
    range_km=[0.0, 0.05, 1.0, 20.0, 300.0, 3000.0],
    altitude_km=[0.002, 1.0, 9.0, 30.0, 500.0],
    elevation_deg=[-90.0, -20.0, -3.0, 0.0, 2.0, 35.0, 90.0],
    source_elevation_deg=[-20.0, -5.0, 0.0, 2.0, 35.0, 90.0],
    source_azimuth_deg=[0.0, 4.0, 90.0, 180.0],
)
BANDS = {"3.8 um": (3.798, 3.801), "10.5 um": (10.5, 10.52)}
STATES = {
    "clear": {"name": "us_standard", "aerosol": Aerosol(visibility_km=300.0)},
    "hazy": {"name": "tropical", "aerosol": Aerosol("maritime", visibility_km=5.0)},
    "visibility 0.1 km": {"name": "midlatitude_summer", "aerosol": Aerosol(visibility_km=0.1)},
    "thick cloud": {"name": "midlatitude_summer", "clouds": [CloudLayer("water", 500.0, 1500.0, 8.0, 60.0)]},
    "thin cirrus": {"name": "us_standard", "clouds": [CloudLayer("ice", 9e3, 10e3, 30.0, 0.5)]},
    "volcano": {"name": "us_standard", "aerosol": Aerosol(stratosphere="extreme_fresh")},
    "polar night": {"name": "subarctic_winter", "surface_temperature": 220.0, "surface_albedo": 0.6},
    "no particles": {"name": "us_standard", "aerosol": Aerosol("none")},
}
# How far above the largest light a bound may lie: far where light is scattered many times or, by large droplets, in a
# narrow peak, near elsewhere.
LOOSENESS = {"thick cloud": 6000.0, "visibility 0.1 km": 100.0}


def made(name, **more):
    settings = {**STATES[name], **more}
    return AtmosphericState.from_profile(settings.pop("name"), **settings)


def band_of(name):
    response = SpectralResponse.rectangular(*BANDS[name])
    return points_of_band(AbsorptionTable.open(), response)


def seen(table):
    """Path, sky and direct radiance as an observer gets them, W m^-2 sr^-1."""
    through = table.transmittance[..., None]
    return {
        "path": table.path_radiance_ratio * (1 - through)[..., None],
        "sky": table.ambient * through,
        "direct": table.direct * through,
    }


# Each air in one band, and one of them in both; `validation` has all.
DAILY = {
    ("clear", "3.8 um"),
    ("hazy", "3.8 um"),
    ("hazy", "10.5 um"),
    ("visibility 0.1 km", "10.5 um"),
    ("thin cirrus", "10.5 um"),
    ("volcano", "3.8 um"),
    ("polar night", "10.5 um"),
    ("no particles", "3.8 um"),
}


@pytest.mark.parametrize(
    ("name", "band"),
    [
        pytest.param(name, band, marks=() if (name, band) in DAILY else pytest.mark.validation)
        for name in STATES
        for band in BANDS
    ],
)
def test_scattered_light_stays_below_its_bound(name, band):
    points = band_of(band)
    air = BandAtmosphere.of(made(name), points)
    sun = solar_irradiance(points.wavenumber)
    bound = Scattering.of(air.air).radiance(sun, points.radiance_weight)
    whole, dark = air.table(GRID, sun), replace(air, air=replace(air.air, scatters=False)).table(GRID, sun)
    differences = {kind: np.abs(value - seen(dark)[kind]) for kind, value in seen(whole).items()}
    largest = max(differences["path"].max(), differences["sky"].max())
    assert largest <= bound * (1 + 1e-6) and bound < LOOSENESS.get(name, 70.0) * largest
    assert not np.any(differences["direct"]) and np.array_equal(whole.beta_star, dark.beta_star)
    print(f"{name}, {band}: bound over largest {bound / largest:.2g}")


def test_light_is_bounded_by_the_source_itself():
    """Water absorbs in the cloud, so that a bound exists; between a white ground and the air there is none, and light
    is never left out.
    """
    points = band_of("3.8 um")
    bounds = Scattering.of(BandAtmosphere.of(made("thick cloud"), points).air)
    assert np.all(np.isfinite(bounds.light) & (bounds.light > 0))
    white = Scattering.of(BandAtmosphere.of(made("clear", surface_albedo=1.0), points).air)
    assert np.all(np.isinf(white.light))


def test_layers_without_particles_change_nothing():
    points = band_of("10.5 um")
    state = made("hazy", clouds=[CloudLayer("ice", 9e3, 10e3, 30.0, 0.0)])
    sun = solar_irradiance(points.wavenumber)
    tables = [BandAtmosphere.of(one, points).table(GRID, sun) for one in (state, replace(state, hydrometeors=()))]
    for name in vars(tables[0]):
        assert np.array_equal(*(getattr(table, name) for table in tables))


def test_the_bound_of_molecules_takes_the_largest_value_of_their_phase_function():
    assert optics.rayleigh_phase(np.linspace(-1, 1, 201), 0.0).max() == bounds._RAYLEIGH_PEAK
