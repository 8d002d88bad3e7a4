"""A job without bands builds its temperatures; what needs a pixel says that it has no band."""

import pytest
from click.testing import CliRunner

import skyshine.mat
from skyshine.mat.cli import main


@pytest.fixture(scope="module")
def job(builds_here, tmp_path_factory):
    file = tmp_path_factory.mktemp("alone") / "job.yaml"
    file.write_text(
        "skyshine: 1\nname: alone\n"
        "site: {latitude_deg: 47, longitude_deg: 7, date: 2026-06-21, utc_offset_h: 2}\n"
        "states: [{profile: midlatitude_summer, weather: {air_temperature_c: [12, 26]}}]\n"
        "bands: []\nmaterials: [concrete]\noutput: {folder: built}\n"
        "surface_grid: {altitude_km: [0], azimuth_deg: [0, 180], slope_deg: [0, 90]}\n"
    )
    report = skyshine.mat.build(file)
    assert list(report.files) == ["s01.htt.h5"]
    return file


def test_the_temperatures_are_built_drawn_and_verified(job):
    assert {file.name for file in job.parent.glob("built/*.h5")} == {"s01.htt.h5"}
    assert (job.parent / "built" / "pictures" / "s01.htt.png").is_file()
    result = CliRunner().invoke(main, ["verify", str(job.parent / "built" / "s01.htt.h5")])
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize("command", [["report"], ["bench"]])
def test_what_needs_a_band_says_so(job, command):
    result = CliRunner().invoke(main, [*command, str(job)])
    assert result.exit_code == 2 and "found no band; allowed here: one or more; add one to bands" in result.output


def test_a_contrast_needs_a_band(job):
    result = CliRunner().invoke(main, ["contrast", str(job.parent / "built"), "concrete", "concrete", "--range", "1"])
    assert result.exit_code == 2 and "has no band; build a job that has one" in result.output
