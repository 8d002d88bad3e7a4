"""Databases of a job that leaves things out: as the whole ones within what they say, the same bytes each time, restored
by one key.
"""

import dataclasses
import json
import shutil

import h5py
import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.left_out import temperature_times
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.compiled import compiled_band
from skyshine.mat.scene.grids import path_grid
from skyshine.mat.scene.sources import source_irradiance
from skyshine.mat.tables.verify import problems
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5_digest import as_text

JOB = """\
skyshine: 1
name: left out
site: {latitude_deg: 29.7, longitude_deg: -82.0, date: 2026-06-28, utc_offset_h: -5}
states:
  - profile: midlatitude_summer
    visibility_km: 23
    clouds: [{phase: ice, height_km: [9, 10], optical_depth: 0}]
    weather: {air_temperature_c: [22, 33], relative_humidity_percent: 60, wind_speed_m_s: 2}
bands: [{name: unused, wavelength_um: [3, 5]}, {name: used, wavelength_um: [10.5, 10.6]}]
sources: [moon]
materials: [asphalt_road, grass_green]
output: {pictures: false}
atmosphere_grid:
  range_km: [0.001, 5, 300]
  altitude_km: [0.01, 1, 700]
  elevation_deg: [-90, -5, 0, 30]
  source_elevation_deg: [-10, 0, 45]
  source_azimuth_deg: [0, 90, 180]
surface_grid: {altitude_km: [0, 1], azimuth_deg: [0, 180], slope_deg: [0, 45]}
"""
NAMES = ("beta_star", "path_radiance_ratio", "ambient_radiance", "direct_radiance")


def made(build, folder, more=""):
    folder.mkdir()
    (folder / "job.yaml").write_text(JOB + more, encoding="utf-8")
    loaded = load_job(folder / "job.yaml")
    return loaded, build(loaded, jobs=1), folder / "built"


@pytest.fixture(scope="module")
def kept(build_inline, tmp_path_factory):
    needs = 'needs: {bands: [used], hours: ["22:10", "04:10"]}\n'
    return made(build_inline, tmp_path_factory.mktemp("kept") / "job", needs)


@pytest.fixture(scope="module")
def restored(build_inline, tmp_path_factory):
    return made(
        build_inline,
        tmp_path_factory.mktemp("restored") / "job",
        "needs: {bands: [used]}\naccuracy: {negligible_k: 0}\n",
    )


def opened(built, name="s01b02.lunar_atmq.h5"):
    return skyshine.mat.open(built[2] / name)


def test_only_the_named_band_is_there(kept):
    assert {path.name for path in kept[2].glob("*.h5")} == {"s01b02.lunar_atmq.h5", "s01.htt.h5", "b02.band.h5"}
    assert all(problems(path) == [] for path in kept[2].glob("*.h5"))


def test_the_file_says_what_it_lacks_and_by_how_much(kept, restored):
    notes = opened(kept).root.groups["accuracy"].attributes
    assert "scattered light of the moon" in notes["left_out"]
    assert 0 < notes["left_out_bound_kelvin"] <= 0.02 and 0 < notes["left_out_bound"] < 0.02
    assert opened(restored).root.groups["accuracy"].attributes["left_out"] == "none"
    said = json.loads((kept[2] / "build.json").read_text())["files"]["s01b02.lunar_atmq.h5"]["notes"]
    assert any("scattered light of the moon" in note for note in said)


def test_no_value_differs_by_more_than_that(kept):
    """Direct computation with the scattered moonlight that the file leaves out, and without it."""
    job = kept[0].trimmed.on_date_of_state(1)
    state, response, table = atmospheric_state(job.site, job.states[0]), response_of(job.bands[1]), absorption_table()
    everything = points_of_band(table, response)
    compiled, _ = compiled_band(kept[0].on_date_of_state(1), job.states[0], response, state, everything)
    moon = source_irradiance(job, "moon", compiled.band.wavenumber, compiled.band.width)
    air = BandAtmosphere.of(state, compiled.band)
    dark = dataclasses.replace(air, air=dataclasses.replace(air.air, scatters=False))
    with_light, without = (one.table(path_grid(job), moon) for one in (air, dark))
    bound = opened(kept).root.groups["accuracy"].attributes["left_out_bound"]
    absorbed = (1 - with_light.transmittance)[..., None, None]
    path = np.abs(with_light.path_radiance_ratio - without.path_radiance_ratio) * absorbed
    sky = np.abs(with_light.ambient - without.ambient) * with_light.transmittance[..., None]
    assert 0 < path[with_light.valid].max() <= bound and 0 < sky[with_light.valid].max() <= bound
    assert np.array_equal(with_light.beta_star, without.beta_star)


NIGHT = 'needs: {bands: [used], hours: ["22:10", "04:10"]}\n'


def test_part_of_a_day_reads_like_the_whole(build_surface, tmp_path):
    half_hours = [f"{number // 2:02d}:{number % 2 * 30:02d}" for number in range(48)]
    written = JOB.replace("slope_deg: [0, 45]}", f"slope_deg: [0, 45], time: {half_hours}}}")
    files = []
    for name, more in (("night", NIGHT), ("day", "")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "job.yaml").write_text(written + more, encoding="utf-8")
        files.append(build_surface(load_job(tmp_path / name / "job.yaml"), tmp_path / name))
    night, day = map(skyshine.mat.open, files)
    assert night.root.axes["time"].values[[0, -1]].tolist() == [22.0, 28.5] and day.root.axes["time"].values.size == 48
    times = np.concatenate([np.linspace(22, 24, 40), np.linspace(0, 4.5, 40)])
    place = {"material": "grass_green", "altitude": 0.3, "azimuth": 300.0, "slope": 20.0}
    assert np.allclose(night.temperature(**place, time=times), day.temperature(**place, time=times), atol=1e-4)
    assert np.allclose(
        night.temperature(**place, time=times[:-1]), night.temperature(**place, time=times[:-1] + 24.0), atol=1e-9
    )
    with pytest.raises(InputError, match="time: found 12; allowed: 22 to 28.5"):
        night.temperature(**place, time=12.0)
    assert night.error("temperature")["maximum"] < 5.0  # azimuths stand half a turn apart


def test_times_that_are_not_written_are_placed_between_the_hours_needed(kept, restored):
    night, day = (opened(built, "s01.htt.h5") for built in (kept, restored))
    times = night.root.axes["time"].values
    assert times.size == len(temperature_times(kept[0].trimmed)) < 14 and day.root.axes["time"].values.size > times.size
    assert times[0] <= 22 + 1 / 6 and times[-1] >= 28 + 1 / 6 and np.all(np.diff(times) > 0)
    asked = np.concatenate([np.linspace(22.2, 24, 40), np.linspace(0, 4.1, 40)])
    place = {"material": "grass_green", "altitude": 0.3, "azimuth": 180.0, "slope": 45.0}
    read = [table.temperature(**place, time=asked) for table in (night, day)]
    assert np.abs(read[0] - read[1]).max() < 0.3  # where the day has fewer nodes


def test_another_tolerance_is_built_anew_and_the_same_is_kept(build_inline, kept, tmp_path):
    loaded, folder = kept[0], shutil.copytree(kept[2], tmp_path / "built")
    assert all(file["kept"] for file in build_inline(loaded, out=folder, jobs=1)["files"].values())
    accuracy = loaded.trimmed.accuracy.model_copy(update={"negligible_k": 0.019})
    other = dataclasses.replace(loaded, trimmed=loaded.trimmed.model_copy(update={"accuracy": accuracy}))
    again = build_inline(other, out=folder, jobs=1)["files"]
    assert not again["s01b02.lunar_atmq.h5"]["kept"] and again["s01.htt.h5"]["kept"]


def test_a_tolerance_of_the_surface_grid_places_times_of_the_whole_day(build_surface, tmp_path):
    text = JOB.replace("slope_deg: [0, 45]}", "slope_deg: [0, 45], tolerance: 1 K}")
    (tmp_path / "job.yaml").write_text(text + 'needs: {bands: [used], hours: ["22:10", "04:10"]}\n', encoding="utf-8")
    with h5py.File(build_surface(load_job(tmp_path / "job.yaml"), tmp_path)) as file:
        times, read = file["time"][()], file["time"].attrs["interpolation"]
    assert (
        as_text(read) == "linear"
        and times[0] <= 22 + 1 / 6
        and times[-1] >= 28 + 1 / 6
        and np.all(np.diff(times) > 0)
        and times.size < 24
    )
