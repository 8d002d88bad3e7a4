"""Aerosols of known sizes and refractive indices: against closed forms and packaged models, and what is refused."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles import size_distribution
from skyshine.mat.atmosphere.particles.aerosol_layer import AerosolLayer
from skyshine.mat.atmosphere.particles.aerosol_table import parse_extinction_profile, parse_refractive_index
from skyshine.mat.atmosphere.particles.particles import HenyeyGreensteinModel
from skyshine.mat.atmosphere.particles.size_distribution import LogNormalMode, RefractiveIndex, sphere_mixture
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.schemas.errors import InputError

HUMIDITY = np.array([50.0])


@pytest.fixture(scope="module", autouse=True)
def few_wavelengths():
    """Mie theory at those that are looked at, and around them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(size_distribution, "_WAVELENGTHS", np.array([0.25, 0.3, 0.44, 0.55, 0.87, 1, 2, 4, 10, 40]))
        yield


def constant(n, k):
    return RefractiveIndex((0.2, 40.0), (n, n), (k, k))


GREY = HenyeyGreensteinModel("grey", np.array([0.2, 40.0]), np.ones(2), np.zeros(2), np.full(2, 0.7))


@pytest.fixture(scope="module")
def small():
    """Spheres much smaller than the wavelength."""
    return sphere_mixture("small", (LogNormalMode(0.004, 1.2, 1.0, constant(1.5, 0.01)),))


def test_small_spheres_scatter_and_absorb_as_dipoles(small):
    """Scattering falls with the fourth power of the wavelength, absorption with the first; light goes forward and back
    alike.
    """
    wavenumber = 1e4 / np.array([2.0, 4.0])
    optics = small.optics(wavenumber, HUMIDITY)
    scattered = (optics.extinction * optics.single_scattering_albedo)[0]
    absorbed = optics.extinction[0] - scattered
    assert scattered[0] / scattered[1] == pytest.approx(16.0, rel=0.01)
    assert absorbed[0] / absorbed[1] == pytest.approx(2.0, rel=0.01)
    phase = small.phase_function([1.0, 0.0, -1.0], wavenumber, HUMIDITY)[:, 0, 0]
    np.testing.assert_allclose(phase, [1.5, 0.75, 1.5], rtol=5e-3)
    np.testing.assert_allclose(small.phase_moments(wavenumber, HUMIDITY)[:3, 0, 0], [1, 0, 0.1], atol=5e-3)


def test_large_spheres_take_away_twice_their_shadow_at_all_wavelengths():
    coarse = sphere_mixture("coarse", (LogNormalMode(8.0, 1.3, 1.0, constant(1.5, 0.01)),))
    optics = coarse.optics(1e4 / np.array([0.3, 0.55, 1.0]), HUMIDITY)
    np.testing.assert_allclose(optics.extinction[0], 1.0, atol=0.05)
    assert coarse.phase_moments([1e4], HUMIDITY)[1, 0, 0] == pytest.approx(optics.asymmetry[0, 2], abs=1e-3)


def test_two_modes_add_up(small):
    """One mode twice is that mode; of two modes of the same number the larger spheres decide."""
    mode = LogNormalMode(0.15, 1.6, 1.0, constant(1.45, 0.005))
    one, twice = sphere_mixture("one", (mode,)), sphere_mixture("twice", (mode, mode))
    tiny = LogNormalMode(0.004, 1.2, 1.0, constant(1.5, 0.01))
    both = sphere_mixture("both", (mode, tiny))
    for other in (twice, both):
        np.testing.assert_allclose(
            one.optics([1e4], HUMIDITY).extinction, other.optics([1e4], HUMIDITY).extinction, rtol=1e-4
        )
    assert np.all(one.asymmetry <= 1) and small.name == "small"


def test_the_angstrom_exponent_of_accumulation_mode_is_that_of_sun_photometers():
    """Urban and smoke particles of 0.14 um median volume radius have exponents of 1.2 to 2.5 (Dubovik et al. 2002, J.
    Atmos. Sci. 59, 590, table 1).
    """
    log_sd = np.log(1.5)
    median = 0.14 * np.exp(-3 * log_sd**2)
    model = sphere_mixture("smoke", (LogNormalMode(median, 1.5, 1.0, constant(1.5, 0.0094)),))
    extinction = model.optics(1e4 / np.array([0.44, 0.87]), HUMIDITY).extinction[0]
    assert 1.2 < np.log(extinction[0] / extinction[1]) / np.log(0.87 / 0.44) < 2.5


@pytest.mark.parametrize(
    "layer",
    [
        AerosolLayer.even(GREY, 2e3, 4e3, 0.3),
        AerosolLayer.even(GREY, 0.0, 500.0, 0.3),
        AerosolLayer.exponential(GREY, 1.5e3, 0.3),
        AerosolLayer.exponential(GREY, 60.0, 0.3),
        AerosolLayer.measured(GREY, np.array([1e3, 2e3]), np.array([1e-4, 2e-4]), 0.3),
    ],
)
def test_a_layer_holds_its_optical_depth(layer):
    plain = AtmosphericState.from_profile("us_standard", surface_altitude=300.0)
    state = AtmosphericState.from_profile("us_standard", surface_altitude=300.0, aerosol_layers=[layer])
    before = plain.aerosol_optical_depth(550.0, 300.0)
    assert state.aerosol_optical_depth(550.0, 300.0) - before == pytest.approx(0.3, abs=2e-3)
    # Levels of the plain state lie elsewhere; above the layer nothing is added.
    top = 300.0 + layer.height[-1] + 1.0
    assert state.aerosol_optical_depth(550.0, top) == pytest.approx(
        plain.aerosol_optical_depth(550.0, top), rel=0.02, abs=1e-4
    )


def test_a_measured_profile_gives_its_own_amount():
    height, extinction = parse_extinction_profile("height[km],extinction[km^-1]\n0,0.2\n1,0.2\n2,0\n", "p.csv")
    layer = AerosolLayer.measured(GREY, height, extinction, None)
    plain = AtmosphericState.from_profile("us_standard")
    state = AtmosphericState.from_profile("us_standard", aerosol_layers=[layer])
    added = state.aerosol_optical_depth(550.0, 0.0) - plain.aerosol_optical_depth(550.0, 0.0)
    assert added == pytest.approx(0.3, rel=0.01)
    assert layer.extinction_550([500.0, 1500.0, 2500.0]) == pytest.approx([2e-4, 1e-4, 0.0])


def test_an_even_layer_is_even_and_ends():
    layer = AerosolLayer.even(GREY, 2e3, 4e3, 0.3)
    assert layer.extinction_550([1e3, 1999.0, 3e3, 4001.0]) == pytest.approx([0, 0, 1, 0])
    assert {2e3, 4e3} <= set(layer.edges)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: AerosolLayer.even(GREY, 2e3, 2010.0, 0.1), "give a bottom of at least 0 and a top at least 0.02 km"),
        (lambda: AerosolLayer.even(GREY, 0.0, 90e3, 0.1), "at most 80 km"),
        (lambda: AerosolLayer.even(GREY, 0.0, 1e3, 101.0), "optical depth 101"),
        (lambda: AerosolLayer.exponential(GREY, 10.0, 0.1), "scale height 0.01 km"),
        (lambda: LogNormalMode(50.0, 1.5, 1.0, constant(1.5, 0)), "median radius 50 is outside 0.001 to 20"),
        (lambda: LogNormalMode(0.1, 1.0, 1.0, constant(1.5, 0)), "geometric standard deviation 1 is outside"),
        (lambda: LogNormalMode(0.1, 1.5, 0.0, constant(1.5, 0)), "number 0 of a mode"),
    ],
)
def test_layers_and_modes_out_of_range_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


INDEX = "wavelength[um],real,imaginary\n0.25,1.5,0.01\n5,1.4,0.1\n40,1.8,0.5\n"
PROFILE = "height[km],extinction[km^-1]\n0,0.1\n1,0.05\n3,0\n"


def test_a_refractive_index_is_read():
    index = parse_refractive_index(INDEX, "n.csv")
    np.testing.assert_allclose(index.at(np.array([0.25, 5.0, 40.0])), [1.5 + 0.01j, 1.4 + 0.1j, 1.8 + 0.5j])
    assert index.at(np.array([np.sqrt(0.25 * 5)])) == pytest.approx(1.45 + 1j * np.sqrt(0.001))


@pytest.mark.parametrize(
    ("parse", "text", "message"),
    [
        (parse_refractive_index, INDEX.replace("real", "n"), r"t.csv:1:\d+: found the column 'n'"),
        (parse_refractive_index, INDEX.replace("0.25,", "0.5,"), r"t.csv:2:1: found wavelengths from 0.5 to 40 um"),
        (parse_refractive_index, INDEX.replace("1.4,", "0,"), r"t.csv:3:3: found 0; allowed: above 0, up to 10"),
        (parse_refractive_index, INDEX.replace("0.1\n", "-1\n"), r"t.csv:3:7: found -1; allowed: 0 to 10"),
        (parse_extinction_profile, PROFILE.replace("[km^-1]", "[m^-1]"), r"t.csv:1:12: found the unit 'm\^-1' of ext"),
        (parse_extinction_profile, PROFILE.replace("1,", "0,", 1).replace("0,0.1", "0.5,0.1"), r"t.csv:3:1: found 0 "),
        (parse_extinction_profile, PROFILE.replace("3,0", "90,0"), r"t.csv:4:1: found 90; allowed: 0 to 80"),
        (parse_extinction_profile, PROFILE.replace("0.05", "-1"), r"t.csv:3:3: found -1; allowed: at least 0"),
        (parse_extinction_profile, "height[km],extinction[km^-1]\n0,0\n1,0\n", r"t.csv:2:3: found no extinction"),
    ],
)
def test_a_table_that_does_not_fit_is_refused_at_its_place(parse, text, message):
    with pytest.raises(InputError) as caught:
        parse(text, "t.csv")
    import re

    assert re.search(message, str(caught.value)), str(caught.value)
