"""The band model's sky as the forcing of surfaces: measured levels, and interpolation against direct evaluation."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.gases.absorption import default_water_continuum
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.spectra.fluxes import broadband_fluxes
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.scene import clear_sky
from skyshine.mat.scene.clear_sky import band_model_sky
from skyshine.mat.scene.surface import surface_inputs
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.sun_path import SUN_STEPS, SunPath
from skyshine.schemas.errors import InputError


@pytest.fixture(scope="module")
def air():
    return AtmosphericState.from_profile(
        "midlatitude_summer",
        surface_altitude=0.0,
        aerosol=Aerosol("rural", visibility_km=23.0),
        surface_temperature=294.0,
    )


@pytest.fixture(scope="module")
def sky(air, few_suns):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(clear_sky, "SUN_ELEVATIONS", few_suns)
        return band_model_sky(air, 3000.0, 0.2, 1.0, default_water_continuum())


def test_interpolation_between_elevations_and_altitudes(air, sky):
    """Against the fluxes computed there: within 1 W/m2 of sunlight and 0.5 of longwave."""
    generator = np.random.default_rng(1)
    elevation = np.sort(generator.uniform(-3, 88, SUN_STEPS))
    altitude = np.array([130.0, 870.0, 2625.0])
    some = slice(None, None, 6)
    exact = broadband_fluxes(air, altitude, elevation[some], 0.2)
    direct, diffuse = sky.irradiance(SunPath(0.0, elevation, np.zeros(SUN_STEPS)), 0.0, altitude)
    sine = np.maximum(np.sin(np.radians(elevation[some])), 0)
    assert np.abs((direct[:, some] - exact.direct_normal) * sine).max() < 1.0
    assert np.abs(diffuse[:, some] - exact.diffuse).max() < 1.0
    own = np.interp(altitude, air.altitude, air.temperature)[:, None] + np.zeros(SUN_STEPS)
    assert np.abs(sky.longwave(own, 0.0, altitude)[:, 0] - exact.longwave_down).max() < 0.5


def test_clear_summer_sky(sky):
    """Pyrheliometers read 700 to 950 W/m2 at visibility 23 km and a high Sun, pyrgeometers some 350 under humid air."""
    noon = np.argmin(np.abs(sky.solar_elevation - 70))
    assert 700 < sky.direct[0, noon] < 950 and 100 < sky.diffuse[0, noon] < 300
    assert sky.direct[-1, noon] > sky.direct[0, noon] + 100
    assert 0.75 < sky.emissivity[0] < 0.92 and np.all(np.diff(sky.emissivity) < 0)


JOB = """\
skyshine: 1
name: cloud
site: {{latitude_deg: 45, longitude_deg: 0, date: 2026-06-22, utc_offset_h: 0}}
states:
  - profile: midlatitude_summer
    {clouds}
    weather: {{air_temperature_c: 20{fraction}}}
bands: [{{wavelength_um: [8, 12]}}]
materials: [concrete]
"""


def test_layers_and_a_fraction_of_cloud_are_not_both_taken(tmp_path):
    file = tmp_path / "job.yaml"
    file.write_text(JOB.format(clouds="clouds: [{type: stratus}]", fraction=", cloud_fraction: 0.5"), encoding="utf-8")
    with pytest.raises(InputError, match="states.0: found clouds and weather.cloud_fraction; allowed"):
        surface_inputs(file)


@pytest.mark.validation  # 6 s
def test_layers_of_cloud_take_the_place_of_a_fraction(tmp_path):
    """Stratus leaves no beam, little light, and a nearly black warm sky, whatever the fraction of the weather would
    do.
    """
    file = tmp_path / "job.yaml"
    found = {}
    for name, clouds, fraction in (("clear", "clouds: []", ""), ("layer", "clouds: [{type: stratus}]", "")):
        file.write_text(JOB.format(clouds=clouds, fraction=fraction), encoding="utf-8")
        _, (sun_path, weather, sky) = surface_inputs(file)
        assert np.all(weather.cloud_fraction == 0)
        found[name] = Scene(sun_path, weather, sky, np.array([0.0]), np.array([0.0]), np.array([0.0])).forcing(96)
    noon = 48
    clear, layer = found["clear"], found["layer"]
    assert layer.shortwave_direct[0, noon] < 1 < 500 < clear.shortwave_direct[0, noon]
    assert layer.shortwave_diffuse[0, noon] < 0.5 * (clear.shortwave_direct + clear.shortwave_diffuse)[0, noon]
    assert layer.longwave_sky[0, 0] > clear.longwave_sky[0, 0] + 30
