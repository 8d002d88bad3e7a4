"""What the choice of a water vapour continuum changes in a job's bands: much in humid air, nothing in dry air."""

from dataclasses import replace

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.atmosphere.band.sample import Sample
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.segments import Depths
from skyshine.mat.job.load import load_job
from skyshine.mat.radiometry.blackbody import SpectralResponse, planck_wavenumber
from skyshine.mat.scene.assessed_points import assessed_points
from skyshine.mat.scene.bands import absorption_table
from skyshine.mat.scene.continuum_spread import other_continua, spread_kelvin, spread_warnings
from skyshine.mat.scene.grids import path_grid

WINDOW = SpectralResponse.rectangular(8.0, 12.0)


@pytest.fixture(scope="module")
def loaded():
    return load_job(skyshine.mat.example("starter"))


def test_air_without_water_does_not_differ_and_humid_air_does(loaded):
    humid = AtmosphericState.from_profile("tropical")
    dry = replace(humid, mole_fraction=humid.mole_fraction | {"H2O": 1e-12 * humid.mole_fraction["H2O"]})
    spread = [spread_kelvin(loaded.trimmed, air, WINDOW, ["mt_ckd_4.3", "mt_ckd_2.4"]) for air in (humid, dry)]
    assert 0.3 < spread[0] < 5.0 and spread[1] < 1e-6


def test_the_spread_is_that_of_lines_of_sight_through_the_whole_air(loaded):
    job, state, other = loaded.trimmed, AtmosphericState.from_profile("tropical"), "mt_ckd_2.4"
    clear, radiances = replace(state, aerosols=(), hydrometeors=()), []
    for name in (job.water_continuum, other):
        band = assessed_points(WINDOW, name)
        air = SpectralAir.of(clear, band.points, band.gases, band.weight)
        lines = Sample.for_test(air.shells, path_grid(job), 16, np.random.default_rng(0)).lines
        radiances.append([radiance(air, line) @ band.radiance_weight for line in lines])
    warmer, colder = (planck_wavenumber(band.wavenumber, kelvin) @ band.radiance_weight for kelvin in (300.5, 299.5))
    expected = np.percentile(np.abs(np.subtract(*radiances)) / (warmer - colder), 95)
    assert spread_kelvin(job, state, WINDOW, [other]) == pytest.approx(expected, rel=1e-6)


def radiance(air, line):
    """Radiance at the observer of a black body of 300 K at the end of the first segments of a line."""
    depth, end = line.segments.column(air.optics.extinction), line.node[-1]
    emitted = air.thermal_radiance(line.segments, Depths(depth))[:end].sum(axis=0)
    return np.exp(-depth[:end].sum(axis=0)) * planck_wavenumber(air.optics.wavenumber, 300.0) + emitted


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
