"""Tables follow the needs of a job: faces by themselves, points and lines of the paths that are read, heights too."""

import dataclasses

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.transfer.path_axes import ALL_PATHS, PathScope
from skyshine.mat.job.load import load_job
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.channels.surface_light import EmittedLight, surface_light
from skyshine.mat.quantities.sky_table import SkyTable
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.compiled import compiled_band
from skyshine.mat.scene.grids import path_grid, path_scope
from skyshine.mat.scene.sources import source_irradiance

JOB = """\
skyshine: 1
name: followed
site: {latitude_deg: 29.7, longitude_deg: -82.0, date: 2026-06-28, utc_offset_h: -5}
states:
  - profile: midlatitude_summer
    visibility_km: 23
    weather: {air_temperature_c: [22, 33], relative_humidity_percent: 60, wind_speed_m_s: 2}
bands: [{wavelength_um: [10.2, 10.8]}]
sources: [sun]
materials: [asphalt_road, grass_green]
output: {pictures: false}
atmosphere_grid:
  range_km: [0.001, 0.05, 0.2, 1, 5, 50]
  altitude_km: [0.01, 0.1, 1, 5]
  elevation_deg: [-90, -20, -5, 0, 5, 30, 90]
"""
NEEDS = """\
needs:
  range_km: [0.02, 0.1]
  observer_altitude_km: [0.01, 0.05]
  elevation_deg: [-4, 4]
  hours: ["10:00", "12:00"]
"""


def job_of(folder, more):
    (folder / "job.yaml").write_text(JOB + more, encoding="utf-8")
    return load_job(folder / "job.yaml")


def compiled(loaded):
    job, response = loaded.trimmed, response_of(loaded.trimmed.bands[0])
    state = atmospheric_state(job.site, job.states[0])
    everything = points_of_band(absorption_table(), response)
    return state, compiled_band(loaded.on_date_of_state(1), job.states[0], response, state, everything)[0]


def test_points_chosen_for_short_paths_are_fewer_and_hold_the_tolerance_there(tmp_path):
    _, whole = compiled(job_of(tmp_path, ""))
    _, part = compiled(job_of(tmp_path, NEEDS))
    assert part.index.size < whole.index.size
    assert all(error["rms"] <= 1e-3 for error in part.errors.values())


def test_gases_that_short_paths_do_not_show_stay_for_the_light_on_surfaces(tmp_path):
    """Ozone in 8-12 um: nothing over 40 m, and a tenth of the light of the sky."""
    text = JOB.replace("[10.2, 10.8]", "[8, 12]") + NEEDS.replace("[0.02, 0.1]", "[0.016, 0.04]").replace(
        "[-4, 4]", "[-60, -30]"
    )
    (tmp_path / "job.yaml").write_text(text + "accuracy: {spectral_tolerance: 0.002}\n", encoding="utf-8")
    _, part = compiled(load_job(tmp_path / "job.yaml"))
    assert "O3" in part.band.gases
    assert max(part.errors[kind]["rms"] for kind in ("sky_irradiance", "direct_irradiance")) < 5e-3


def test_quantities_of_short_paths_agree_with_the_whole_jobs_within_the_tolerance(tmp_path):
    needed, every = job_of(tmp_path, NEEDS), job_of(tmp_path, "")
    grid, tables = path_grid(needed.trimmed), []
    for loaded in (needed, every):
        state, band = compiled(loaded)
        sun = source_irradiance(needed.trimmed, "sun", band.band.wavenumber, band.band.width)
        tables.append(BandAtmosphere.of(state, band.band, scope=path_scope(loaded)).table(grid, sun))
    part, whole = tables
    lit = whole.direct > 0.1 * whole.direct.max()
    assert np.max(np.abs(part.transmittance - whole.transmittance)) < 4e-3
    assert np.max(np.abs(part.ambient / whole.ambient - 1)) < 8e-3
    assert np.max(np.abs(part.direct[lit] / whole.direct[lit] - 1)) < 8e-3


def test_sky_light_below_the_highest_surface_is_that_of_the_whole_table(tmp_path):
    loaded = job_of(tmp_path, NEEDS)
    state, band = compiled(loaded)
    air, altitude = BandAtmosphere.of(state, band.band).air, np.array([0.0, 40.0, 119.0])
    sun = source_irradiance(loaded.trimmed, "sun", band.band.wavenumber, band.band.width)
    air.prepare()
    low, whole = (
        SkyTable.over_ground(air, np.radians([30.0]), sun, scope) for scope in (PathScope(0.1, 120.0), ALL_PATHS)
    )
    assert low.altitude.tolist() == [0.0, 250.0] and whole.altitude.size == 21
    np.testing.assert_allclose(low.at(altitude), whole.at(altitude), rtol=1e-6)


def test_light_of_a_low_scene_stands_at_few_heights_and_around_its_source(tmp_path):
    loaded = job_of(tmp_path, NEEDS)
    state, band = compiled(loaded)
    atmosphere = BandAtmosphere.of(state, band.band, scope=PathScope(0.1, 120.0))
    sun = source_irradiance(loaded.trimmed, "sun", band.band.wavenumber, band.band.width)
    through, elevation = np.ones((1, band.band.weight.size)), np.array([50.0, 60.0])
    low, whole = (
        surface_light(air, sun, elevation, through, EmittedLight.of(air, 0), 1e-3)
        for air in (atmosphere, dataclasses.replace(atmosphere, scope=ALL_PATHS))
    )
    assert low.target_height_km.tolist() == [0.0, 0.25] and low.height_km.tolist() == [0.0, 0.25]
    assert low.above_rise[0] <= 50 <= 60 <= low.above_rise[-1] and low.above_rise.size < whole.above_rise.size
    rows = np.isin(whole.above_rise, low.above_rise)
    seen = [part.value.T @ (part.factor.T @ through[0]) for part in (low.direct, whole.direct)]
    np.testing.assert_allclose(seen[0], seen[1][rows][:, :2], atol=2e-3)


FACES = "surface_grid: {altitude_km: [0]%s}\n"


def test_faces_are_tabulated_as_a_grid_with_these_nodes_holds_them(build_surface, tmp_path):
    files = []
    grid = ", slope_deg: [0, 90], azimuth_deg: [30, 120]"
    needs = "needs: {faces_deg: [[0, 0], [90, 30], [90, 120]]}\n"
    for name, more in (("faces", FACES % "" + needs), ("grid", FACES % grid)):
        (tmp_path / name).mkdir()
        files.append(build_surface(job_of(tmp_path / name, more), tmp_path / name))
    faces, whole = map(skyshine.mat.open, files)
    assert faces.root.variables["temperature"].data.shape[2:4] == (2, 2)
    times = np.arange(0.0, 24.0, 0.5)
    for slope, azimuth in ((0.0, 77.0), (90.0, 30.0), (90.0, 120.0)):
        place = {"material": "grass_green", "altitude": 0.0, "slope": slope, "azimuth": azimuth, "time": times}
        assert np.max(np.abs(faces.temperature(**place) - whole.temperature(**place))) < 0.3
    assert "slopes and azimuths of the faces alone" in faces.root.groups["accuracy"].attributes["method"]
    # Between two azimuths a quarter turn apart linear interpolation errs by kelvins: none of that is in the faces.
    assert faces.error("temperature")["maximum"] < whole.error("temperature")["maximum"]


@pytest.mark.parametrize("hours", ["['13:00', '15:00']", "['13:00', '13:00']", "['23:00', '01:00']"])
def test_a_tolerance_holds_in_the_hours_that_are_needed(build_surface, tmp_path, hours):
    needs = f"accuracy: 1 K\nneeds: {{hours: {hours}, faces_deg: [[0, 0], [90, 200]]}}\n"
    file = build_surface(job_of(tmp_path, FACES % "" + needs), tmp_path)
    table = skyshine.mat.open(file)
    assert table.error("temperature")["p99"] <= 1.0
    assert table.root.axes["time"].values.size < 12
    first = float(hours[2:4])
    assert np.isfinite(table.temperature(material="asphalt_road", altitude=0, slope=90, azimuth=200, time=first))
