"""Optical properties at levels: molecular scattering against published values, phase functions, sums."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.particles.moments import moment_weights
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer import optics


@pytest.mark.parametrize("micron", [0.25, 0.3, 0.4, 0.55, 0.7, 0.85])
def test_rayleigh_cross_section_of_bodhaine(micron):
    # Bodhaine et al. 1999, equation 29: their own fit at 360 ppmv of CO2, good to 0.01 % from 0.25 to 0.85 um; 1e-28
    # cm2.
    fit = (1.0455996 - 341.29061 / micron**2 - 0.90230850 * micron**2) / (
        1 + 0.0027059889 / micron**2 - 85.968563 * micron**2
    )
    section, _ = optics.rayleigh_scattering(np.array([1e4 / micron]), 0.036)
    assert section[0] == pytest.approx(fit * 1e-32, rel=1e-4, abs=0)


def test_carbon_dioxide_alone_depolarises_as_measured():
    # King factor 1.15 (Bates 1984, Planet. Space Sci. 32, 785): depolarisation 0.0814.
    _, anisotropy = optics.rayleigh_scattering(np.array([1e4 / 0.55]), 1e9)
    assert 2 * anisotropy[0] / (1 + anisotropy[0]) == pytest.approx(0.0814, abs=1e-4)


def test_the_gases_of_dry_air_make_up_the_whole():
    """With the 360 ppmv of CO2 of Bodhaine et al."""
    percent = optics._KING_NITROGEN + optics._KING_OXYGEN + optics._ARGON_PERCENT + 0.036
    assert percent == pytest.approx(100.0, abs=1e-9)


def test_carbon_dioxide_refracts_more_than_air_as_measured():
    """Refractivities at 0 degree C and 1 atm for sodium light: 4.498e-4 of CO2, 2.926e-4 of air (CRC Handbook)."""

    def refraction(co2_percent):
        section, anisotropy = optics.rayleigh_scattering(np.array([1e4 / 0.5893]), co2_percent)
        depolarisation = 2 * anisotropy / (1 + anisotropy)
        return np.sqrt(section * (6 - 7 * depolarisation) / (6 + 3 * depolarisation))[0]

    assert refraction(100.0) / refraction(0.03) == pytest.approx(4.498 / 2.926, rel=3e-3)


def test_rayleigh_optical_depth_of_the_air():
    # Bodhaine et al. 1999, section 4: 0.0973 at 0.55 um for 1013.25 hPa at 45 degrees latitude (other authors 0.0971 to
    # 0.0976).
    state = AtmosphericState.from_profile("us_standard")
    section, _ = optics.rayleigh_scattering(np.array([1e4 / 0.55]), 0.036)
    assert section[0] * state._column(state.number_density, 0.0) == pytest.approx(0.0973, rel=5e-3)


def test_rayleigh_scattering_stays_positive_from_ultraviolet_to_far_infrared():
    section, anisotropy = optics.rayleigh_scattering(1e4 / np.geomspace(0.3, 30.0, 50), 0.042)
    assert np.all(section > 0) and np.all(np.diff(section) < 0)
    assert np.all((anisotropy > 0.01) & (anisotropy < 0.03))


@pytest.mark.parametrize("anisotropy", [0.0, 0.0148, 0.03])
def test_molecular_phase_function_has_mean_one(anisotropy):
    cosine, weight = np.polynomial.legendre.leggauss(8)
    assert optics.rayleigh_phase(cosine, anisotropy) @ weight / 2 == pytest.approx(1.0, rel=1e-12)


def test_particle_phase_functions_have_mean_one(synthetic_points):
    state = AtmosphericState.from_profile("midlatitude_summer")
    points = synthetic_points(np.array([800.0, 805.0, 1200.0, 2500.0]), {"CO2": np.zeros(3)})
    phase = optics.spectral_optics(state, points).phase
    angle = optics.PHASE_ANGLES
    mean = np.trapezoid(phase * np.sin(angle)[:, None, None], angle, axis=0) / 2
    assert np.all(np.abs(mean - 1) < 5e-3)
    assert np.all(phase > 0)


def test_extinction_is_the_sum_of_its_parts_and_emission_the_black_bodys(synthetic_points):
    state = AtmosphericState.from_profile("tropical", gas_amounts=GasAmounts(ppm={"CO2": 400}))
    points = synthetic_points(np.array([900.0, 905.0, 910.0]), {"H2O": [1e-28, 2e-28], "CO2": [3e-27, 0.0]})
    found = optics.spectral_optics(state, points)
    parts = sum(found.absorption.values()) + found.rayleigh + found.aerosol_extinction
    assert found.extinction == pytest.approx(parts, rel=1e-12, abs=0)
    assert found.absorption["CO2"][0] == pytest.approx([3e-27 * 400e-6, 0.0], rel=1e-9, abs=0)
    assert np.all(found.aerosol_scattering < found.aerosol_extinction)
    # Planck's law with the radiation constants of CODATA 2018.
    assert found.emission[0, 0] == pytest.approx(
        1.191042972e-8 * 902.5**3 / np.expm1(1.438776877 * 902.5 / state.temperature[0])
    )


def test_gases_can_be_left_out(synthetic_points):
    state = AtmosphericState.from_profile("tropical")
    points = synthetic_points(np.array([900.0, 905.0]), {"H2O": [1e-28], "CO2": [3e-27], "XY9": [1.0]})
    assert set(optics.spectral_optics(state, points).absorption) == {"H2O", "CO2"}
    assert set(optics.spectral_optics(state, points, gases=("CO2",)).absorption) == {"CO2"}


def test_phase_wavelength_weights_add_up():
    nodes, share = optics._phase_wavelengths(np.linspace(2000.0, 3333.0, 40))
    assert share.sum(axis=0) == pytest.approx(np.ones(40))
    assert (1e4 / nodes) @ share == pytest.approx(1e4 / np.linspace(2000.0, 3333.0, 40))


def test_an_even_phase_function_is_one():
    np.testing.assert_allclose(optics.normalised(np.ones(optics.PHASE_ANGLES.size)), 1.0, rtol=1e-8)


def test_light_that_a_phase_function_misses_stands_in_its_forward_peak():
    phase = optics.normalised(np.full(optics.PHASE_ANGLES.size, 0.9))
    np.testing.assert_allclose(phase[1:], 0.9, rtol=1e-12)
    angle = np.linspace(0.0, np.pi, 36001)
    mean = np.trapezoid(np.interp(angle, optics.PHASE_ANGLES, phase) * np.sin(angle), angle) / 2
    assert mean == pytest.approx(1.0, rel=1e-4)


@pytest.mark.parametrize("asymmetry", [-0.3, 0.0, 0.8])
def test_moments_of_the_phase_function_of_henyey_and_greenstein_are_powers(asymmetry):
    cosine = np.cos(optics.PHASE_ANGLES)
    phase = (1 - asymmetry**2) / (1 + asymmetry**2 - 2 * asymmetry * cosine) ** 1.5
    moments = moment_weights(optics.PHASE_ANGLES, 8) @ phase
    np.testing.assert_allclose(moments, asymmetry ** np.arange(8.0), atol=2e-4)


@pytest.fixture
def clouds(synthetic_points):
    """Water at 1 to 2 km and ice at 8 to 10 km, in air of 360 ppmv of CO2 without other particles."""
    layers = [CloudLayer("water", 1e3, 2e3, 8.0, 5.0), CloudLayer("ice", 8e3, 10e3, 30.0, 1.0)]
    state = AtmosphericState.from_profile(
        "us_standard", clouds=layers, aerosol=Aerosol("none"), gas_amounts=GasAmounts(ppm={"CO2": 360})
    )
    points = synthetic_points(np.array([900.0, 905.0, 910.0]), {"CO2": np.zeros(2)})
    return optics.spectral_optics(state, points)


def test_the_mean_cosine_of_particles_is_that_of_their_phase_function(clouds):
    filled = np.all(clouds.aerosol_scattering > 0, axis=1)
    cosine = np.einsum("nc,cp->np", clouds.moments[1], clouds.phase_share)
    np.testing.assert_allclose(cosine[filled], clouds.asymmetry[filled], atol=2e-3)
    assert np.all(clouds.asymmetry[~filled] == 0) and np.ptp(clouds.asymmetry[filled]) > 0.02


def test_levels_without_particles_scatter_as_the_nearest_with_some(clouds):
    filled = np.flatnonzero(np.all(clouds.aerosol_scattering > 0, axis=1))
    assert np.array_equal(clouds.phase[:, 0], clouds.phase[:, filled[0]])
    assert np.array_equal(clouds.phase[:, -1], clouds.phase[:, filled[-1]])
    assert np.array_equal(clouds.moments[:, -1], clouds.moments[:, filled[-1]])
    assert not np.allclose(clouds.phase[:, 0], clouds.phase[:, -1])


def test_molecules_of_a_state_scatter_with_its_carbon_dioxide(clouds):
    section, anisotropy = optics.rayleigh_scattering(clouds.wavenumber, 0.036)
    np.testing.assert_allclose(clouds.rayleigh[0], section, rtol=1e-10)
    np.testing.assert_allclose(clouds.rayleigh_anisotropy, anisotropy, rtol=1e-10)
