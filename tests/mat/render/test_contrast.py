"""Contrast through the day: crossovers, and the pixels it is made of."""

import datetime as dt

import numpy as np
import pytest
import yaml

import skyshine.mat
from skyshine.mat.api.contrast import contrast, draw_contrast
from skyshine.mat.job.load import load_job
from skyshine.mat.render.contrast import crossover_hours
from skyshine.mat.scene.agreement import twilight_warnings
from skyshine.schemas.errors import InputError

HOURS = np.arange(288) / 12


def test_crossovers_of_a_sine_are_its_zeros():
    assert crossover_hours(HOURS, np.sin((HOURS - 7.21) * 2 * np.pi / 24), step=1 / 12) == pytest.approx(
        [7.21, 19.21], abs=1e-4
    )


def test_a_crossover_over_midnight_counts_where_the_day_is_whole():
    wave = np.cos((HOURS - 6.0 - 1 / 48) * 2 * np.pi / 24)  # 0 at 12:01:15 and between 23:55 and 24:00 or so
    assert len(crossover_hours(HOURS, wave, step=1 / 12)) == 2
    half = HOURS < 12.0
    assert crossover_hours(HOURS[half], wave[half], step=1 / 12) == pytest.approx([1 / 48], abs=1e-3)


def test_contrast_that_touches_zero_is_no_crossover():
    values = np.array([1.0, 0.0, 2.0, 0.0, 0.0, -1.0, 3.0])
    hours = np.arange(7.0)
    assert crossover_hours(hours, values, step=1.0) == pytest.approx([4.0, 5.25])


def test_a_contrast_is_not_known_within_a_gap():
    """The wave changes its sign at 7.2 and 19.2 h; without the hours from 6 to 8 the first is not told."""
    wave, there = np.sin((HOURS - 7.21) * 2 * np.pi / 24), (HOURS < 6) | (HOURS > 8)
    assert crossover_hours(HOURS[there], wave[there], step=1 / 12) == pytest.approx([19.21], abs=1e-4)


def test_hours_of_a_twilight_that_the_tables_lack_are_left_out(tiny_job, build_inline, tmp_path):
    """With a lowest node of 0 degrees there are no values from the Sun's setting to the dark, and back."""
    text = tiny_job().replace("source_elevation_deg: [-20, 60]", "source_elevation_deg: [0, 30, 60, 90]")
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    loaded = load_job(tmp_path / "job.yaml")
    assert any("from 0 degrees down to" in line for line in twilight_warnings(loaded.trimmed))
    build_inline(loaded, jobs=1)
    (result,) = contrast(tmp_path / "built", "asphalt_road", "asphalt_road", range=1.0)
    assert 100 < result.hours.size < 288 and np.all(np.isfinite(result.material))
    assert np.sum(np.diff(result.hours) > 0.1) == 2


def test_a_material_has_no_contrast_against_itself(one_material):
    (result,) = contrast(one_material, "asphalt_road", "asphalt_road", range=1.0)
    assert np.all(result.contrast == 0) and result.crossovers == ()
    assert np.all((result.material > 250) & (result.material < 350))


def test_a_shaded_face_is_colder_by_day_and_after(one_material):
    (result,) = contrast(one_material, "asphalt_road", "asphalt_road", range=0.2, shade=["08:00-12:00"])
    assert result.contrast[HOURS == 10.0][0] < -2.0
    at = {hour: result.contrast[hour == HOURS][0] for hour in (11.0, 13.0, 17.0)}
    assert at[11.0] < at[13.0] < at[17.0] < -0.05
    assert at[17.0] < result.contrast[HOURS == 6.0][0] < 0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"material": "sea"}, "lacks the material 'sea'"),
        ({"slope": 45.0, "azimuth": 0.0, "elevation": -10.0, "heading": 0.0}, "turned away from the observer"),
        ({"shade": ["25:00-26:00"]}, "shade: found '25:00'"),
        ({"band": "b09"}, "found the band 'b09'"),
        ({"source": "moon"}, r"has no \.lunar_atmq"),
        ({"range": 500.0}, "put the observer at 353.6 km; allowed: up to"),
    ],
)
def test_what_cannot_be_compared_is_one_line(one_material, changes, words):
    given = {"material": "asphalt_road", "background": "asphalt_road"} | changes
    with pytest.raises(InputError, match=words):
        contrast(one_material, **given)


def test_a_contrast_knows_its_day_and_its_error(one_material):
    """Sunrise and sunset are as far apart as declination and latitude say; more shade errs more."""
    (result,) = contrast(one_material, "asphalt_road", "asphalt_road", range=0.2)
    rise, sunset = result.sun_up
    surface = skyshine.mat.open(one_material / "s01.htt.h5")
    site = yaml.safe_load(surface.attributes["job"])["site"]
    temperature = surface.error("temperature")["p99_kelvin"]
    latitude = np.radians(site["latitude_deg"])
    day = dt.date.fromisoformat(result.date).timetuple().tm_yday
    declination = np.radians(23.44) * np.sin(2 * np.pi * (day - 80.5) / 365.25)  # within 0.6 degree
    cosine = np.sin(np.radians(-0.833)) - np.sin(latitude) * np.sin(declination)
    length = np.degrees(np.arccos(cosine / (np.cos(latitude) * np.cos(declination)))) / 7.5
    assert sunset - rise == pytest.approx(length, abs=0.1)
    assert np.sqrt(2) * temperature <= result.stated_error < 20.0  # a coarse grid
    assert result.wavelength[0] < result.wavelength[1] and result.sight.range == 0.2
    (shaded,) = contrast(one_material, "asphalt_road", "asphalt_road", range=0.2, shade=["08:00-12:00"])
    assert shaded.stated_error > result.stated_error


def test_the_picture_shows_both_bands(one_material, tmp_path):
    (result,) = contrast(one_material, "asphalt_road", "asphalt_road", shade=["08:00-12:00"])
    assert draw_contrast([result, result], "shaded", "sunlit", tmp_path / "c.png").stat().st_size > 10_000


def test_a_contrast_as_xarray(one_material):
    (result,) = contrast(one_material, "asphalt_road", "asphalt_road", shade=["08:00-12:00"])
    data = result.to_xarray()
    np.testing.assert_array_equal(data.contrast.values, data.material.values - data.background.values)
    assert data.time.size == 288 and data.contrast.attrs["units"] == "K" and data.attrs["band"] == result.band
