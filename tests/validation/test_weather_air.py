"""Weather that differs from the profile by 16 K: what a path of 1 km at the ground and the sky gain by following it.

python -m pytest -m validation -s tests/validation/test_weather_air.py

Kelvin: change of a black body at 300 K in the band, of the radiance that the air of the path adds, level at 2 m above
the ground, at every 16th spectral point of the band.
"""

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.spectra.fluxes import broadband_fluxes
from skyshine.mat.job.load import load_job
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.radiometry.equivalent_temperature import kelvin_per_radiance
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of

pytestmark = pytest.mark.validation
WINTER = 272.2 - 273.15  # C, midlatitude winter at the ground
WEATHER = f"{{air_temperature_c: {WINTER + 16:.2f}, relative_humidity_percent: 60}}"
JOB = f"""\
skyshine: 1
name: weather of another day
site: {{latitude_deg: 45, longitude_deg: 10, date: 2026-01-15, utc_offset_h: 1}}
states:
  - {{profile: midlatitude_winter, air: profile, weather: {WEATHER}}}
  - {{profile: midlatitude_winter, weather: {WEATHER}}}
  - {{profile: midlatitude_winter, sounding: sounding.csv, weather: {WEATHER}}}
  - {{profile: midlatitude_winter, gases: {{H2O: {{scale: 1}}}}, weather: {WEATHER}}}
bands: [{{wavelength_um: [3, 5]}}, {{wavelength_um: [8, 12]}}]
sources: [sun]
materials: [asphalt_road]
"""
RANGES, HEIGHT = [0.1, 1.0, 5.0], 0.002  # km
STEP = 16  # between the spectral points that are taken
EQUAL = 0.05  # K between the weather and a sounding of the same air


def sounding_of(air):
    """The lowest 30 km of a state as a user would write them down: every other level."""
    rows = ["altitude[m],pressure[Pa],temperature[K],h2o[ppmv]"]
    columns = (air.altitude, air.pressure, air.temperature, 1e6 * air.mole_fraction["H2O"])
    for values in zip(*(column[::2] for column in columns), strict=True):
        if values[0] <= 30e3:
            rows.append(",".join(f"{value:.8g}" for value in values))
    return "\n".join(rows) + "\n"


@pytest.fixture(scope="module")
def airs(tmp_path_factory):
    """Air of the profile, of the weather, of a sounding with the weather's air, of the weather's temperature alone."""
    folder = tmp_path_factory.mktemp("air")
    (folder / "job.yaml").write_text(JOB, encoding="utf-8")
    header = "altitude[m],pressure[Pa],temperature[K],h2o[ppmv]\n"
    (folder / "sounding.csv").write_text(header + "0,1e5,280,1\n9,9.99e4,280,1\n", encoding="utf-8")
    job = load_job(folder / "job.yaml").trimmed
    (folder / "sounding.csv").write_text(sounding_of(atmospheric_state(job.site, job.states[1])), encoding="utf-8")
    job = load_job(folder / "job.yaml").trimmed
    assert [state.air for state in job.states] == ["profile", "weather", "profile", "weather"]
    return job, [atmospheric_state(job.site, state) for state in job.states]


@pytest.mark.parametrize("band", [1, 2])
def test_path_radiance_follows_the_weather_as_it_follows_a_sounding(airs, band):
    job, states = airs
    response = response_of(job.bands[band - 1])
    everything = points_of_band(absorption_table(), response)
    every = np.arange(0, everything.weight.size, STEP)
    weight = everything.weight[every] * everything.weight.sum() / everything.weight[every].sum()
    points = BandPoints(everything.points.subset(every), weight, everything.gases)
    grid = PathGrid(RANGES, [HEIGHT], [0.0], [-10.0], [0.0])
    dark = np.zeros(points.weight.size)
    kelvin = []
    for state in states:
        table = BandAtmosphere.of(state, points).table(grid, dark, quantities=("beta_star", "path_radiance_ratio"))
        through = np.exp(-5.5 * np.array(RANGES) / table.beta_star.reshape(-1))
        kelvin.append(table.path_radiance_ratio.reshape(-1) * (1 - through) * kelvin_per_radiance(response))
    change, difference, warmth = kelvin[1] - kelvin[0], kelvin[2] - kelvin[1], kelvin[3] - kelvin[0]
    print(
        f"\n{response.lower:g}-{response.upper:g} um, 0.1, 1, 5 km: weather less profile"
        f" {' '.join(f'{value:+.2f}' for value in change)} K, of it by temperature alone"
        f" {' '.join(f'{value:+.2f}' for value in warmth)} K; sounding of the same air less weather"
        f" {' '.join(f'{value:+.4f}' for value in difference)} K"
    )
    assert np.all(np.abs(difference) < EQUAL)
    assert change[1] > warmth[1] > 1.0  # the air of 1 km glows as warm as it is
    warmer = float(
        (planck_wavenumber(points.wavenumber, 288.2) - planck_wavenumber(points.wavenumber, 272.2))
        @ points.radiance_weight
    )
    assert np.all(change < 1.2 * warmer * kelvin_per_radiance(response))  # never more than an opaque path


def test_sky_longwave_follows_the_weather(airs):
    """Of a black body of the air, Brutsaert (1975), Water Resour. Res. 11, 742: 1.24 (e / T)^(1/7) of hPa and K, by
    7 % at most; the profile's sky is some 70 W/m2 too cold.
    """
    states = airs[1][:3]
    vapour = [state.mole_fraction["H2O"][0] * state.pressure[0] / 100 for state in states]
    longwave = np.array([broadband_fluxes(state, [0.0], [-5.0], 0.2).longwave_down[0] for state in states])
    brutsaert = np.array(
        [
            1.24 * (e / state.temperature[0]) ** (1 / 7) * 5.670374e-8 * state.temperature[0] ** 4
            for e, state in zip(vapour, states, strict=True)
        ]
    )
    print(f"\nsky longwave {longwave.round(1)} W/m2, by Brutsaert {brutsaert.round(1)}")
    assert longwave == pytest.approx(brutsaert, rel=0.07)
    assert longwave[1] - longwave[0] > 40.0 and abs(longwave[2] - longwave[1]) < 0.3
