"""Fluxes on all levels: black bodies and sunlight in closed form, the whole spectrum, what is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.constants import Stefan_Boltzmann

import skyshine.mat
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.spectra.fluxes import broadband_fluxes
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.cli import main
from skyshine.schemas.errors import InputError


def test_fluxes_of_a_narrow_band_sum_to_that_of_the_band():
    levels = skyshine.mat.fluxes(wavenumber=(2500, 2510), source_elevation=[20, 60])
    data = levels.to_xarray()
    assert data.direct.dims == ("altitude", "source_elevation", "wavenumber") and data.direct.shape[1:] == (2, 2)
    assert data.thermal_up.units == "W m^-2 (cm^-1)^-1"
    np.testing.assert_allclose(levels.in_band["direct"], 5 * levels.direct.sum(axis=-1), rtol=1e-9)
    # Nothing absorbs above the highest level: sunlight through a level surface.
    line = skyshine.mat.spectrum(wavenumber=(2500, 2510), altitude=150, elevation=90, source_elevation=60)
    np.testing.assert_allclose(levels.direct[-1, 1], line.direct_irradiance * np.sin(np.radians(60)), rtol=1e-4)
    ground = skyshine.mat.spectrum(wavenumber=(2500, 2510), elevation=90, source_elevation=60)
    falling = (levels.thermal_down[0] + levels.diffuse_down[0, 1]) / ground.sky_irradiance
    np.testing.assert_allclose(falling, 1.0, rtol=0.02)  # plane layers for lines of sight through shells
    np.testing.assert_allclose(levels.direct[0, 1], ground.direct_irradiance * np.sin(np.radians(60)), rtol=1e-4)


def test_the_whole_spectrum():
    whole = skyshine.mat.fluxes(profile="us_standard", aerosol="none", source_elevation=np.float64(90))
    assert whole.to_xarray().thermal_up.dims == ("altitude",) and "the whole spectrum" in repr(whole)
    # Coddington et al. 2021; 1.1 % of it is below 0.3 um, where the spectrum of the points begins.
    assert whole.direct[-1, 0] == pytest.approx(0.989 * 1361, rel=0.003)
    emitted = 0.9 * Stefan_Boltzmann * 288.2**4  # of a ground of albedo 0.1
    assert whole.thermal_up[0] == pytest.approx(emitted + 0.1 * whole.thermal_down[0], rel=2e-3)
    air = AtmosphericState.from_profile("us_standard", aerosol=Aerosol("none"))
    other = broadband_fluxes(air, [0.0], [90.0], 0.1)  # lines of sight through shells
    assert whole.thermal_down[0] == pytest.approx(other.longwave_down[0], rel=5e-3)
    assert whole.diffuse_down[0, 0] == pytest.approx(other.diffuse[0, 0], rel=5e-3)
    assert 200 < whole.thermal_up[-1] < whole.thermal_up[0]
    assert np.all(np.diff(whole.direct[:, 0]) > -1e-9) and whole.thermal_down[-1] == 0


@pytest.mark.parametrize(
    ("profile", "rrtmgp"), [("us_standard", 259.3), ("tropical", 286.5), ("subarctic_winter", 198.6)]
)
def test_emission_to_space_is_that_of_rrtmgp(profile, rrtmgp):
    """Over a black ground; computed by tests/validation/test_broadband_rrtmgp.py, whose continuum is of its time."""
    air = {"profile": profile, "aerosol": "none", "co2_ppm": np.float64(400), "water_continuum": "mt_ckd_2.4"}
    black = skyshine.mat.fluxes(**air, surface_albedo=0, source="none")
    assert black.thermal_up[-1] == pytest.approx(rrtmgp, abs=0.8)
    kelvin = {"us_standard": 288.2, "tropical": 299.7, "subarctic_winter": 257.2}[profile]
    assert black.thermal_up[0] == pytest.approx(Stefan_Boltzmann * kelvin**4, rel=1e-3)
    bright = skyshine.mat.fluxes(**air, surface_albedo=1, source="none")
    assert bright.thermal_up[0] == pytest.approx(black.thermal_down[0], rel=1e-2)  # reflects and does not emit


def test_the_command_prints_levels():
    done = CliRunner().invoke(main, ["spectrum", "--fluxes", "--wavenumber", "2500:2505", "--source", "none", "--json"])
    printed = json.loads(done.stdout)
    assert done.exit_code == 0 and "direct" not in printed
    levels = skyshine.mat.fluxes(wavenumber=(2500, 2505), source="none")
    np.testing.assert_allclose(printed["thermal_up"]["values"], levels.in_band["thermal_up"], rtol=1e-5)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"source_elevation": 91}, "found source_elevation 91"),
        ({"source_elevation": float("nan")}, "found source_elevation nan"),
        ({"source": "moon"}, "allowed: the Sun, or limits"),
        ({"source": "lamp"}, "allowed: 'sun'"),
        ({"wavenumber": (900, 1000), "wavelength": (8, 9)}, "found both or neither"),
        ({"visibility_km": [1, 2]}, "visibility_km: found"),
        ({"state": 2}, "without a job"),
    ],
)
def test_fluxes_refuse(arguments, message):
    with pytest.raises(InputError, match=message):
        skyshine.mat.fluxes(**arguments)


def test_options_of_a_line_of_sight_are_refused_beside_fluxes():
    done = CliRunner().invoke(main, ["spectrum", "--fluxes", "--range", "5"])
    assert done.exit_code != 0 and "found --fluxes with --range" in str(done.output) + str(done.exception)
