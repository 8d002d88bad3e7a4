"""Phase functions of droplets, drops and crystals: against Mie theory, published figures and their own moments."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.aerosol import MODELS, AerosolModel
from skyshine.mat.atmosphere.particles.aerosol_column import BOUNDARY_MODELS, Aerosol, boundary_model
from skyshine.mat.atmosphere.particles.angstrom import AngstromModel
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.particles.crystals import crystal_asymmetry, crystal_coalbedo
from skyshine.mat.atmosphere.particles.mie import phase_of_spheres, scattered_light
from skyshine.mat.atmosphere.particles.moments import MOMENTS
from skyshine.mat.atmosphere.particles.rain import RainLayer
from skyshine.mat.atmosphere.particles.tables import phase_table
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer import optics

HUMIDITY = np.array([50.0])
WATER_650 = 1.3314 + 1.5e-8j  # Hale and Querry 1973, 0.65 um
KINDS = ("water", "rain", "fog_advection", "fog_radiation")


def droplets(radius):
    return CloudLayer("water", 0.0, 1e3, radius, 1.0).model


def spheres(radius, effective, variance=0.1):
    """Number by radius of a gamma distribution of sizes."""
    return radius ** ((1 - 3 * variance) / variance) * np.exp(-radius / (effective * variance))


def test_amplitudes_of_bohren_and_huffman():
    """Appendix A: S11 over that straight ahead, every 9 degrees, of a sphere of 0.525 um radius, m = 1.55, at 0.6328
    um.
    """
    angle = np.radians(np.arange(0.0, 91.0, 9.0))
    (_, intensity) = scattered_light(np.array([2 * np.pi * 0.525 / 0.6328]), np.array([1.55 + 0j]), np.cos(angle))
    published = [1.0, 0.785390, 0.356897, 0.0766119, 0.0355355, 0.0701845]
    published += [0.0574313, 0.0219660, 0.0125959, 0.0173750, 0.0124601]
    np.testing.assert_allclose(intensity[0] / intensity[0, 0], published, rtol=2e-5)


def test_droplets_of_many_sizes_follow_mie_theory():
    """The table, read at its nodes, against the mean over spheres by direct integration on other nodes: within 4 % from
    the aureole to the glory, moments within 1e-3 up to the order of 32 streams.
    """
    radius = np.geomspace(0.2, 80, 3001)
    angle = np.radians([0.0, 0.5, 1, 2, 3, 5, 10, 30, 60, 90, 120, 138, 141, 145, 160, 175, 178, 180])
    efficiencies, intensity = scattered_light(2 * np.pi * radius / 0.65, np.full(radius.size, WATER_650), np.cos(angle))
    number = spheres(radius, 10.0)
    scattering = np.trapezoid(number * np.pi * radius**2 * efficiencies[1], radius)
    expected = 4 * np.pi * np.trapezoid(number * intensity.T, radius) * (0.65 / (2 * np.pi)) ** 2 / scattering
    found = droplets(10.0).phase_function(np.cos(angle), 1e4 / 0.65, HUMIDITY)[:, 0, 0]
    np.testing.assert_allclose(found, expected, rtol=0.04)
    assert np.median(np.abs(found / expected - 1)) < 0.005
    _, _, moments = phase_of_spheres(radius, number[None], WATER_650, 0.65, angle, MOMENTS)
    np.testing.assert_allclose(
        droplets(10.0).phase_moments(1e4 / 0.65, HUMIDITY)[:33, 0, 0], moments[0, :33], atol=1e-3
    )


def test_the_moments_of_a_state_are_those_of_mie_theory():
    """Droplets of 10 um at 0.65 um, whose forward peak is under a degree: moments to order 32 within 1e-3."""
    layer = CloudLayer("water", 500.0, 1500.0, 10.0, 5.0)
    state = AtmosphericState.from_profile("us_standard", aerosol=Aerosol("none"), clouds=[layer])
    _, moments, share = optics._mixed_phase(state, np.array([1e4 / 0.65]))
    radius = np.geomspace(0.1, 100, 2000)
    _, _, expected = phase_of_spheres(radius, spheres(radius, 10.0)[None], WATER_650, 0.65, np.array([0, np.pi]), 33)
    assert share.shape == (1, 1) and moments.shape[0] == MOMENTS
    np.testing.assert_allclose(moments[:33, 3, 0], expected[0], atol=1e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_tables_of_phase_functions_are_whole(kind):
    """Functions have the mean 1, moments begin with 1 and fall, the mean cosine of both is the same."""
    table = phase_table(kind)
    assert np.all(np.isfinite(table.phase)) and np.all(table.phase > 0)
    assert table.moments.shape[0] == MOMENTS and np.all(np.abs(table.moments) <= 1)
    np.testing.assert_allclose(table.moments[0], 1.0, rtol=1e-4)
    fine = np.radians(np.unique(np.append(np.geomspace(1e-3, 180, 4000), np.linspace(0, 180, 4001))))
    log_phase = np.array(
        [
            np.interp(fine, np.radians(table.angle), column)
            for column in np.log(table.phase.reshape(len(table.angle), -1)).T
        ]
    )
    measure = 0.5 * np.exp(log_phase) * np.sin(fine)
    mean = np.trapezoid(measure, fine)
    cosine = np.trapezoid(measure * np.cos(fine), fine)
    # Drops of millimetres have peaks narrower than any of the angles: there the moments alone are exact.
    narrow = 0.45 if kind == "rain" else 0.03
    assert np.all(np.abs(mean - 1) < narrow)
    expected = table.moments[1].ravel()
    np.testing.assert_allclose(cosine + (1 - mean), expected, atol=0.02)


@pytest.mark.parametrize("layer", [CloudLayer("ice", 9e3, 10e3, 30.0, 1.0), CloudLayer("water", 0.0, 1e3, 9.0, 1.0)])
def test_clouds_scatter_at_all_wavelengths(layer):
    """Also where ice refracts less than air, and far beyond the thermal infrared."""
    wavenumber = 1e4 / np.geomspace(0.2, 1000, 500)
    optics_of_layer = layer.model.optics(wavenumber, HUMIDITY)
    phase = layer.model.phase_function(np.cos(np.linspace(0, np.pi, 91)), wavenumber, HUMIDITY)
    assert np.all(np.isfinite(optics_of_layer.asymmetry)) and np.all(np.abs(optics_of_layer.asymmetry) < 1)
    assert np.all(np.isfinite(phase)) and np.all(phase > 0)
    assert np.all(np.abs(layer.model.phase_moments(wavenumber, HUMIDITY)) <= 1 + 1e-9)


@pytest.mark.parametrize("rate", [0.1, 5.0, 100.0])
def test_rain_scatters_as_large_drops(rate):
    """Half of the light that drops of millimetres scatter is diffracted straight ahead; what passes through them has
    the asymmetry of geometric optics, 0.76 to 0.78 at n = 1.33, and makes a rainbow at 138 degrees (van de Hulst 1957,
    sections 12 and 13).
    """
    model = RainLayer(rate, 2e3).model
    moments = model.phase_moments(1e4 / 0.55, HUMIDITY)[:, 0, 0]
    assert moments[1] == pytest.approx(0.5 * (1 + 0.77), abs=0.01)
    assert moments[-1] == pytest.approx(0.5, abs=0.03)
    phase = model.phase_function(np.cos(np.radians([100.0, 120.0, 138.0, 139.0])), 1e4 / 0.55, HUMIDITY)[:, 0, 0]
    assert max(phase[2:]) > 3 * phase[1] > 3 * 0.02 and phase[0] < 0.1


def test_clouds_have_rainbow_and_glory():
    """Droplets of 10 um at 0.55 um: a cloudbow near 140 degrees and a glory about 180, with a minimum in between."""
    at = np.radians([105.0, 120.0, 141.0, 160.0, 180.0])
    low, before, bow, between, glory = droplets(10.0).phase_function(np.cos(at), 1e4 / 0.55, HUMIDITY)[:, 0, 0]
    assert bow > 2 * before and before < 0.2 and glory > 1.5 * between and low < 0.1


def test_deirmendjian_cloud_c1():
    """Deirmendjian 1969, cloud C.1 (r^6 exp(-1.5 r)) at 0.7 um, m = 1.33: extinction 16.72 km^-1 at 100 cm^-3
    (16.33 at 0.45 um), asymmetry near 0.846.
    """
    radius = np.geomspace(0.05, 40, 2000)
    number = radius**6 * np.exp(-1.5 * radius)
    number *= 100 / np.trapezoid(number, radius)  # cm^-3; 100 um^2 cm^-3 are 1e-1 km^-1
    sections, _, _ = phase_of_spheres(radius, number[None], 1.33 + 0j, 0.70, np.array([0.0, np.pi]), 3)
    assert sections[0, 0] * 1e-3 == pytest.approx(16.7, rel=0.01)
    assert sections[1, 0] == pytest.approx(sections[0, 0], rel=1e-9)
    assert sections[2, 0] == pytest.approx(0.85, abs=0.01)


@pytest.mark.parametrize("name", ["fog_advection", "fog_radiation"])
def test_fogs_have_the_droplets_of_their_extinction(name):
    """The asymmetries that LOWTRAN7 tabulates come from the droplets whose phase functions are packaged."""
    model = AerosolModel.load(name)
    moments = model.phase_moments(1e4 / model.wavelength, HUMIDITY)[1, 0]
    np.testing.assert_allclose(moments, model.asymmetry[0], atol=4e-3)


@pytest.mark.parametrize("radius", [5.0, 20.0, 30.0, 60.0, 100.0])
@pytest.mark.parametrize("wavelength", [0.3, 0.65, 1.6, 2.2, 3.85, 10.6])
def test_crystals_scatter_without_a_halo(radius, wavelength):
    """The phase function is positive, has the moments that it states and falls all the way through the halos at 22 and
    46 degrees.
    """
    model = CloudLayer("ice", 9e3, 10e3, radius, 1.0).model
    fine = np.radians(np.unique(np.append(np.geomspace(1e-4, 180, 4000), np.linspace(0, 180, 2001))))
    phase = model.phase_function(np.cos(fine), 1e4 / wavelength, HUMIDITY)[:, 0, 0]
    moments = model.phase_moments(1e4 / wavelength, HUMIDITY)[:, 0, 0]
    legendre = np.polynomial.legendre.legvander(np.cos(fine), 8).T
    found = np.trapezoid(0.5 * phase * np.sin(fine) * legendre, fine)
    np.testing.assert_allclose(found, moments[:9], atol=5e-3)
    assert np.all(phase > 0) and moments[0] == pytest.approx(1.0, abs=1e-12)
    assert moments[1] == pytest.approx(model.optics(1e4 / wavelength, HUMIDITY).asymmetry[0, 0], abs=1e-9)
    angle = np.radians(np.linspace(2.0, 60.0, 200))
    assert np.all(np.diff(model.phase_function(np.cos(angle), 1e4 / wavelength, HUMIDITY)[:, 0, 0]) < 0)


def test_crystals_of_the_published_example():
    """Raisanen et al. 2015, at 1 um and a radius of 200 um (n = 1.3015 + 1.62e-6 i): equations 11 to 13 by hand."""
    size, index = 2 * np.pi * 200.0, 1.3015 + 1.62e-6j
    absorbing = size * 1.62e-6 * 1.3015**2
    assert absorbing == pytest.approx(3.448e-3, rel=1e-3)
    assert crystal_coalbedo(size, index) == pytest.approx(4.33e-3, rel=5e-3)
    assert crystal_asymmetry(size, index) == pytest.approx(0.7809, abs=5e-4)


@pytest.mark.parametrize("name", sorted({*BOUNDARY_MODELS, *MODELS}))
def test_moments_belong_to_the_phase_function(name):
    """Of every aerosol: the moments that it states are those of the function that it states, to 1 %."""
    model = boundary_model(name)
    wavenumber, humidity = 1e4 / np.array([0.3, 0.55, 1.06, 3.9, 10.6]), np.array([0.0, 75.0, 97.0])
    moments = model.phase_moments(wavenumber, humidity)
    assert moments.shape == (MOMENTS, 3, 5)
    fine = np.radians(np.unique(np.append(np.geomspace(1e-2, 180, 3000), np.linspace(0, 180, 3001))))
    phase = model.phase_function(np.cos(fine), wavenumber, humidity)
    measure = 0.5 * phase * np.sin(fine)[:, None, None]
    for order in (0, 1, 2, 5):
        legendre = np.polynomial.legendre.Legendre.basis(order)(np.cos(fine))
        found = np.trapezoid(measure * legendre[:, None, None], fine, axis=0)
        np.testing.assert_allclose(found, moments[order], atol=0.015)


def test_an_angstrom_exponent_leaves_the_moments():
    rural = AerosolModel.load("rural")
    np.testing.assert_array_equal(
        AngstromModel(rural, 1.3).phase_moments([1e4], HUMIDITY), rural.phase_moments([1e4], HUMIDITY)
    )


def test_moments_of_crystals_are_those_of_the_published_sum():
    """Raisanen et al. 2015, equation 31, at 0.65 um and 30 um, from the albedo and asymmetry of the tables."""
    model = CloudLayer("ice", 9e3, 10e3, 30.0, 1.0).model
    properties = model.optics(1e4 / 0.65, HUMIDITY)
    albedo, g = properties.single_scattering_albedo[0, 0], properties.asymmetry[0, 0]
    coalbedo = 1 - albedo
    diffraction, share = 1 - 0.6 / (2 * np.pi * 30 / 0.65), 1 / (2 * albedo)
    ray = (g - share * diffraction) / (1 - share)
    weight = 1 - 1.53 * max(0.77 - ray, 0.0) ** 1.2
    residual = {
        3: -0.13184 - 0.01741 * coalbedo + 0.16890 * g - 0.06365 * coalbedo * g,
        6: -0.32153 - 0.10691 * coalbedo + 0.41282 * g - 0.07934 * coalbedo * g,
    }
    moments = model.phase_moments(1e4 / 0.65, HUMIDITY)[:, 0, 0]
    for order, rest in residual.items():
        expected = share * diffraction**order + (1 - share) * weight * (ray / weight) ** order + rest
        assert moments[order] == pytest.approx(expected, abs=2e-4)
