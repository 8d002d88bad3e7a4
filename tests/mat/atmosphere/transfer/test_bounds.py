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
from skyshine.mat.atmosphere.particles.particles import HenyeyGreensteinModel
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer import bounds, optics
from skyshine.mat.atmosphere.transfer.bounds import Scattering, mean_absorptance, particle_bounds, table_lines
from skyshine.mat.atmosphere.transfer.layer_columns import vertical_column
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import SpectralResponse, planck_wavenumber
from skyshine.mat.radiometry.equivalent_temperature import REFERENCE

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
    assert np.all(np.isfinite(bounds.light) & (bounds.light > 0)) and np.all(
        np.isfinite(bounds.field) & np.isfinite(bounds.gain)
    )
    white = Scattering.of(BandAtmosphere.of(made("clear", surface_albedo=1.0), points).air)
    assert np.all(np.isinf(white.field)) and np.all(np.isinf(white.light))


THIN_LAYERS = {
    "clear": CloudLayer("ice", 9e3, 10e3, 30.0, 1e-5),
    "hazy": CloudLayer("water", 500.0, 900.0, 8.0, 1e-4),
    "thick cloud": CloudLayer("ice", 6e3, 9e3, 30.0, 1e-4),
    "polar night": CloudLayer("ice", 50.0, 300.0, 10.0, 1e-5),
}


@pytest.mark.parametrize(
    ("name", "band"),
    [
        ("clear", "3.8 um"),
        ("hazy", "10.5 um"),
        ("polar night", "3.8 um"),
        *(
            pytest.param(name, band, marks=pytest.mark.validation)  # twenty seconds, of what the others show too
            for name, band in (
                ("thick cloud", "10.5 um"),
                ("clear", "10.5 um"),
                ("hazy", "3.8 um"),
                ("thick cloud", "3.8 um"),
                ("polar night", "10.5 um"),
            )
        ),
    ],
)
def test_thin_layers_stay_below_their_bound(name, band):
    state, points = made(name, clouds=[THIN_LAYERS[name], *STATES[name].get("clouds", [])]), band_of(band)
    air, sun = BandAtmosphere.of(state, points), solar_irradiance(points.wavenumber)
    bounds = particle_bounds(air.air, Scattering.of(air.air), table_lines(air.air, GRID), sun, points.radiance_weight)
    place = len(state.aerosols)  # of the layer that is written first
    assert bounds.shape == (len(state.particles),) and 0 < bounds[place] < np.inf
    less = replace(state, hydrometeors=state.hydrometeors[1:])
    whole, without = air.table(GRID, sun), BandAtmosphere.of(less, points).table(GRID, sun)
    largest = max(np.abs(value - seen(without)[kind]).max() for kind, value in seen(whole).items())
    background = planck_wavenumber(points.wavenumber, REFERENCE) @ points.radiance_weight
    largest = max(largest, np.abs(whole.transmittance - without.transmittance).max() * background)
    assert 0 < largest <= bounds[place]
    print(f"{name}, {band}: bound over largest {bounds[place] / largest:.2g}")


def test_light_that_soot_takes_from_the_source_stays_below_its_bound():
    """Particles that only absorb, over black ground, under a source that outshines the air: a beam from the zenith to
    the ground loses 1 - exp(-t) of what the air leaves of it; one along the lower edge of the layer, which is 1 km
    thick, crosses 226 km of it.
    """
    points = band_of("3.8 um")
    state = made("no particles", surface_albedo=0.0, clouds=[CloudLayer("ice", 9e3, 10e3, 30.0, 1e-4)])
    (ice,) = state.hydrometeors
    soot = HenyeyGreensteinModel("soot", np.array([0.5, 20.0]), np.ones(2), np.ones(2), np.zeros(2))
    air = BandAtmosphere.of(replace(state, hydrometeors=(replace(ice, model=soot),)), points).air
    sun = 1e6 * solar_irradiance(points.wavenumber)
    (bound,) = particle_bounds(air, Scattering.of(air), table_lines(air, GRID), sun, points.radiance_weight)
    whole, of_soot = (
        np.sum(vertical_column(air.shells, section), axis=0)
        for section in (air.optics.extinction, air.optics.aerosol_extinction)
    )
    loss = -np.expm1(-of_soot) * np.exp(of_soot - whole) * sun @ points.radiance_weight / np.pi
    assert loss <= bound <= 250.0 * loss


@pytest.mark.parametrize(("upright", "longest"), [(1e-6, 1e-6), (1e-6, 1e-3), (1e-4, 0.05), (1e-3, 0.3), (0.0, 0.0)])
def test_the_mean_absorptance_is_that_of_the_secant_up_to_the_longest_line(upright, longest):
    """1 - exp(-t / mu) is at most t / mu, and the mean of the lesser of t / mu and the longest is t (1 + ln(l / t))."""
    cosine, weight = np.polynomial.legendre.leggauss(20)
    edge = upright / longest if longest else 1.0
    # Gauss nodes in the logarithm of the cosine, where the secant ends, and above.
    cosine = np.exp(0.5 * (cosine + 1) * np.log(edge))
    weight = -0.5 * weight * np.log(edge) * cosine
    depth = upright / cosine
    bound = mean_absorptance(np.array([upright]), np.array([longest]))[0]
    assert bound == pytest.approx(depth @ weight + edge * longest, rel=1e-9, abs=0)
    assert bound >= -np.expm1(-depth) @ weight - edge * np.expm1(-longest)


def test_layers_without_particles_change_nothing():
    points = band_of("10.5 um")
    state = made("hazy", clouds=[CloudLayer("ice", 9e3, 10e3, 30.0, 0.0)])
    air, sun = BandAtmosphere.of(state, points), solar_irradiance(points.wavenumber)
    bounds = particle_bounds(air.air, Scattering.of(air.air), table_lines(air.air, GRID), sun, points.radiance_weight)
    assert bounds[-1] == 0.0 and np.all(bounds[:-1] > 0)
    tables = [BandAtmosphere.of(one, points).table(GRID, sun) for one in (state, replace(state, hydrometeors=()))]
    for name in vars(tables[0]):
        assert np.array_equal(*(getattr(table, name) for table in tables))


def test_lines_end_at_the_range():
    air = BandAtmosphere.of(made("no particles"), band_of("10.5 um")).air
    lines = table_lines(air, PathGrid([0.1], [0.0, 50.0], [0.0], [30.0], [0.0]))
    assert lines.sum(axis=1)[0] == pytest.approx(100.0 * air.state.number_density[0], rel=1e-3)
    assert np.all(table_lines(air, GRID) >= 0)


def test_the_bound_of_molecules_takes_the_largest_value_of_their_phase_function():
    assert optics.rayleigh_phase(np.linspace(-1, 1, 201), 0.0).max() == bounds._RAYLEIGH_PEAK
