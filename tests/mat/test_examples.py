"""The packaged jobs: each is whole, planned without complaint, and copied by `mat init`."""

import pytest
from click.testing import CliRunner

from skyshine.mat.cli import main
from skyshine.mat.job import load_job
from skyshine.mat.plan import make_plan
from skyshine.mat.scene import check_scene, source_hours
from skyshine.mat.starter import example_names, starter_files
from skyshine.materials.library import load_library

SCENES = ["airfield", "desert_vehicle", "ship", "urban_canyon", "year"]


def test_the_scenes_that_are_promised():
    assert example_names() == ["starter", *SCENES]


@pytest.mark.parametrize("name", SCENES)
def test_plan(name, tmp_path):
    result = CliRunner().invoke(main, ["init", str(tmp_path / "job"), "--example", name])
    assert result.exit_code == 0, result.output
    loaded = load_job(tmp_path / "job" / "job.yaml")
    check_scene(loaded)
    plan = make_plan(loaded, load_library())
    assert set(loaded.job.operated) <= set(plan.materials)
    assert len(plan.tasks) == len(loaded.job.states) * (len(loaded.job.bands) + 1) + len(loaded.job.bands)


def test_night_of_the_airfield_has_a_moon():
    hours = source_hours(load_job(starter_files("airfield")[0]).job)
    assert hours["sun"][0][1] < hours["moon"][-1][0]  # the Moon rises after sunset


def test_states_of_the_year_have_the_sun_of_their_month():
    job = load_job(starter_files("year")[0]).job
    days = [source_hours(job.of_state(k))["sun"][0] for k in range(1, 13)]
    lengths = [_clock(end) - _clock(start) for start, end in days]
    assert max(lengths) == lengths[5] and min(lengths) == lengths[11]
    # At 50 degrees north the day lasts 16.2 h in mid June and 8.1 h in mid December, without refraction (geometry of the solstices).
    assert lengths[5] == pytest.approx(16.2, abs=0.2) and lengths[11] == pytest.approx(8.0, abs=0.2)


def _clock(text: str) -> float:
    hours, minutes = text.split(":")
    return int(hours) + int(minutes) / 60


def test_unknown_example(tmp_path):
    result = CliRunner().invoke(main, ["init", str(tmp_path / "x"), "--example", "airfeld"])
    assert result.exit_code == 2 and "did you mean 'airfield'" in result.output and not (tmp_path / "x").exists()
