"""Sunlight and moonlight of a job: the Sun's distance on its day, the Moon's on its night."""

from functools import partial

import numpy as np
import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.scene.sources import source_irradiance, usual_irradiance


@pytest.fixture
def job_on(tmp_path, tiny_job):
    def on(day: str):
        file = tmp_path / "job.yaml"
        file.write_text(tiny_job().replace("2026-06-28", day), encoding="utf-8")
        return load_job(file).trimmed

    return on


def total(light) -> float:
    """W m^-2 over the whole solar table."""
    edges = np.concatenate([np.arange(10, 33500, 5), np.arange(33500, 49500, 50), np.arange(49500, 83501, 500)])
    middle = 0.5 * (edges[1:] + edges[:-1]).astype(float)
    return float(light("sun", middle, np.diff(edges).astype(float)) @ np.diff(edges))


# Perihelion and aphelion of 2026 (Astronomical Almanac): 0.98330 and 1.01664 au. Of the solar constant, 1361 W m^-2
# (Kopp and Lean 2011), 1407.6 and 1316.8 W m^-2 arrive.
@pytest.mark.parametrize(("day", "expected"), [("2026-01-03", 1407.6), ("2026-07-06", 1316.8)])
def test_sunlight_falls_with_the_square_of_the_distance(job_on, day, expected):
    assert total(partial(source_irradiance, job_on(day))) == pytest.approx(expected, rel=2e-3)


def test_usual_sunlight_is_that_at_one_astronomical_unit():
    assert total(usual_irradiance) == pytest.approx(1361.0, rel=2e-3)


def test_usual_moonlight_has_the_shape_of_moonlight_between_the_quarters(job_on):
    """Full Moon of 2026-06-29, first quarter of 2026-06-21 (Astronomical Almanac): in 3.5 to 4.5 um reflected sunlight
    turns into the Moon's own emission, more so at full Moon.
    """
    wavenumber = 1e4 / np.linspace(4.5, 3.5, 11)
    usual, full, half = (
        light(wavenumber) / light(wavenumber).mean()
        for light in (
            partial(usual_irradiance, "moon"),
            partial(source_irradiance, job_on("2026-06-29"), "moon"),
            partial(source_irradiance, job_on("2026-06-21"), "moon"),
        )
    )
    assert np.all(0.96 * np.minimum(full, half) <= usual) and np.all(usual <= 1.04 * np.maximum(full, half))
    assert np.max(np.abs(full / half - 1)) > 0.05


def test_moonlight_is_that_of_its_night(job_on):
    """Full Moon of 2026-06-29, 23:57 UTC, new Moon of 2026-06-15 (Astronomical Almanac): at 0.55 um a full Moon gives
    about 4.5 mW m^-2 um^-1 at its mean distance (Miller and Turner 2009), a new one next to nothing.
    """
    wavenumber = np.array([1e4 / 0.555])
    full, new = (source_irradiance(job_on(day), "moon", wavenumber)[0] for day in ("2026-06-29", "2026-06-15"))
    per_um = full * wavenumber[0] ** 2 * 1e-4
    assert 3.0e-3 < per_um < 5.5e-3
    assert new < 3e-3 * full  # at 171 degrees, by Krisciunas and Schaefer 1991
