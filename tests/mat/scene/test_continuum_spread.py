"""What the choice of a water vapour continuum changes in a job's bands: much in humid air, nothing in dry air."""

from dataclasses import replace

import pytest

import skyshine.mat
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.job.load import load_job
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.bands import absorption_table
from skyshine.mat.scene.continuum_spread import other_continua, spread_kelvin, spread_warnings

WINDOW = SpectralResponse.rectangular(8.0, 12.0)


@pytest.fixture(scope="module")
def loaded():
    return load_job(skyshine.mat.example("starter"))


def test_air_without_water_does_not_differ_and_humid_air_does(loaded):
    humid = AtmosphericState.from_profile("tropical")
    dry = replace(humid, mole_fraction=humid.mole_fraction | {"H2O": 1e-12 * humid.mole_fraction["H2O"]})
    spread = [spread_kelvin(loaded.trimmed, air, WINDOW, ["mt_ckd_4.3", "mt_ckd_2.4"]) for air in (humid, dry)]
    assert 0.3 < spread[0] < 5.0 and spread[1] < 1e-6


def test_the_same_continuum_does_not_differ(loaded):
    job = loaded.trimmed
    assert spread_kelvin(job, AtmosphericState.from_profile("tropical"), WINDOW, [job.water_continuum]) == 0


def test_check_names_the_spread(loaded):
    lines = spread_warnings(loaded)
    assert any("water vapour continua of MT_CKD differ by" in line and "K on lines of sight" in line for line in lines)


def test_continua_of_the_package_but_that_of_lowtran_are_compared(loaded):
    assert other_continua(loaded.trimmed) == ["mt_ckd_4.3", "mt_ckd_2.4"]


def test_the_table_without_a_name_has_the_continuum_of_jobs_that_name_none(loaded):
    assert absorption_table().content == absorption_table(loaded.trimmed.water_continuum).content
    assert absorption_table().content != AbsorptionTable.open().content  # whose own is another
