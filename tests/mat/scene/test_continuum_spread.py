"""What the choice of a water vapour continuum changes in a job's bands: much in humid air, nothing in dry air."""

import pytest

import skyshine.mat
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.job.load import load_job
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.continuum_spread import other_continua, spread_kelvin, spread_warnings

WINDOW = SpectralResponse.rectangular(8.0, 12.0)


@pytest.fixture(scope="module")
def loaded():
    return load_job(skyshine.mat.example("starter"))


def test_humid_air_differs_more_than_dry_air(loaded):
    job = loaded.trimmed
    humid, dry = (
        spread_kelvin(job, AtmosphericState.from_profile(name), WINDOW, ["mt_ckd_4.3", "mt_ckd_2.4"])
        for name in ("tropical", "subarctic_winter")
    )
    assert humid > 0.5 and dry < 0.15 * humid


def test_the_same_continuum_does_not_differ(loaded):
    job = loaded.trimmed
    assert spread_kelvin(job, AtmosphericState.from_profile("tropical"), WINDOW, [job.water_continuum]) == 0


def test_check_names_the_spread(loaded):
    lines = spread_warnings(loaded)
    assert any("water vapour continua of MT_CKD differ by" in line and "K on lines of sight" in line for line in lines)


def test_continua_of_the_package_but_that_of_lowtran_are_compared(loaded):
    assert other_continua(loaded.trimmed) == ["mt_ckd_4.3", "mt_ckd_2.4"]
