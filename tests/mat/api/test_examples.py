"""The packaged jobs: each is whole, planned without complaint, and copied by `mat init`."""

import shutil

import pytest
from click.testing import CliRunner

from skyshine.mat.api.examples import example_names, starter_files
from skyshine.mat.builder.tasks import run_task
from skyshine.mat.cli import main
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.plan import Kind, Task, make_plan
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.check import check_scene
from skyshine.mat.scene.sources import source_hours
from skyshine.mat.tables.loader import open_table
from skyshine.mat.tables.verify import problems
from skyshine.materials.library import load_library

# Bands in which the mean transmittance errs in emitted light: 3-5, 3.4-4.8, 7.7-9.5 and 3-5 um.
SCENES = ["airfield", "dead_sea", "desert_vehicle", "ship", "street", "urban_canyon", "year"]


def test_the_scenes_that_are_promised():
    assert set(example_names()) == {"starter", "frames", *SCENES}


@pytest.mark.parametrize("name", SCENES)
def test_plan(name, tmp_path):
    result = CliRunner().invoke(main, ["init", str(tmp_path / "job"), "--example", name])
    assert result.exit_code == 0, result.output
    loaded = load_job(tmp_path / "job" / "job.yaml")
    check_scene(loaded)
    plan = make_plan(loaded, load_library())
    assert set(loaded.trimmed.operated) <= set(plan.materials)
    states, bands = len(loaded.trimmed.states), len(loaded.trimmed.bands)
    assert len(plan.tasks) == states * (bands + 1) + bands


def test_night_of_the_airfield_has_a_moon():
    hours = source_hours(load_job(starter_files("airfield")[0]).trimmed)
    assert hours["sun"][0][1] < hours["moon"][-1][0]  # the Moon rises after sunset


def test_every_day_of_the_year_is_planned(tmp_path):
    for file in starter_files("year"):
        shutil.copyfile(file, tmp_path / file.name)
    loaded, library = load_job(tmp_path / "every_day.yaml"), load_library()
    plan = make_plan(loaded, library)
    assert len(plan.tasks) == 365 * 3 + 2 and plan.materials == library.names
    dates = [state.date for state in loaded.trimmed.states]
    assert dates == sorted(set(dates)) and len(dates) == 365
    elevation = loaded.trimmed.atmosphere_grid.source_elevation_deg
    noon = [90 - 50 + 23.44, 0]  # degree, the Sun at the summer solstice at 50 degrees north
    assert elevation[-1] > noon[0] and elevation[0] < noon[1]


def test_states_of_the_year_have_the_sun_of_their_month():
    job = load_job(starter_files("year")[0]).trimmed
    days = [source_hours(job.on_date_of_state(k))["sun"][0] for k in range(1, 13)]
    lengths = [_clock(end) - _clock(start) for start, end in days]
    assert max(lengths) == lengths[5] and min(lengths) == lengths[11]
    # At 50 degrees north the day lasts 16.2 h in mid June and 8.1 h in mid December, without refraction (geometry of
    # the solstices).
    assert lengths[5] == pytest.approx(16.2, abs=0.2) and lengths[11] == pytest.approx(8.0, abs=0.2)


def _clock(text: str) -> float:
    hours, minutes = text.split(":")
    return int(hours) + int(minutes) / 60


@pytest.mark.validation  # 5 s; all examples: tests/validation/test_examples_build.py
def test_the_shore_of_the_dead_sea_is_built(build_inline, tmp_path):
    """On the shore, 430 m below the sea, a pressure of 1,064 hPa is usual; the lowest air is the warmest."""
    (file,) = starter_files("dead_sea")
    text = file.read_text(encoding="utf-8").replace("pictures: true", "pictures: false")
    text = text.replace("[8, 12]", "[10, 10.4]")  # a part of its band is built sooner, through the same air
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    loaded = load_job(tmp_path / "job.yaml")
    report = build_inline(loaded, jobs=1)
    assert set(report["files"]) == {"s01.htt.h5", "s01b01.atmq.h5", "b01.band.h5"}
    for name in report["files"]:
        assert problems(tmp_path / "built" / name) == []
    air = atmospheric_state(loaded.trimmed.site, loaded.trimmed.states[0])
    assert air.pressure[0] == pytest.approx(106_400, rel=0.01)
    table = open_table(tmp_path / "built" / "s01.htt.h5")
    day = [table.temperature(material="limestone", altitude=km, azimuth=0, slope=0, time=6.0) for km in (-0.43, 0.0)]
    assert day[0] > day[1]


def test_unknown_example(tmp_path):
    result = CliRunner().invoke(main, ["init", str(tmp_path / "x"), "--example", "airfeld"])
    assert result.exit_code == 2 and "did you mean 'airfield'" in result.output and not (tmp_path / "x").exists()


def test_a_state_is_built_on_its_own_date(tmp_path):
    warm = "profile: midlatitude_summer, weather: {air_temperature_c: 15}"
    (tmp_path / "job.yaml").write_text(
        "skyshine: 1\nname: two days\nsite: {latitude_deg: 50, longitude_deg: 10, date: 2026-06-21, utc_offset_h:"
        f" 1}}\nstates: [{{{warm}}}, {{date: 2026-12-21, {warm}}}]\nbands: [{{wavelength_um: [8, 12]}}]\nmaterials:"
        " [concrete]\nsurface_grid: {altitude_km: [0], azimuth_deg: [0], slope_deg: [0], time: ['00:00',"
        " '12:00']}\noutput: {pictures: false}\n"
    )
    loaded, noon = load_job(tmp_path / "job.yaml"), []
    for state in (1, 2):
        run_task(Task(Kind.TEMPERATURE, state, 0, (f"s{state:02d}.htt.h5",), 0), loaded, tmp_path, ("concrete",), True)
        table = open_table(tmp_path / f"s{state:02d}.htt.h5")
        assert table.attributes["date"] == ("2026-06-21", "2026-12-21")[state - 1]
        noon.append(float(table.temperature(material="concrete", time=12.0)))
    assert noon[0] > noon[1] + 10  # the same air, and the Sun at 63 or at 17 degrees
