"""Colour, shadow and texture features against numbers known elsewhere."""

import numpy as np
import pvlib
import pytest
from scipy.special import erf
from skimage.color import rgb2lab

from skyshine.tmm.features import textured
from skyshine.tmm.features.colour import ndvi, to_coordinates, to_lab, to_linear
from skyshine.tmm.features.textured import features, in_other_light, in_shadow, names
from skyshine.tmm.mapping.ways import _quantities


def test_srgb_is_linearised_as_the_standard_says():
    # IEC 61966-2-1: 1/12.92 below 0.04045, a power of 2.4 above; 188 is middle grey.
    linear = to_linear(np.array([[0, 10, 11], [128, 188, 255]], np.uint8), "srgb")
    np.testing.assert_allclose(linear, [[0, 0.0030353, 0.0033465], [0.2158605, 0.5028865, 1]], rtol=2e-5)


def test_lab_is_that_of_scikit_image():
    """Of all greys, where the straight part near black begins at 9, and of random colours."""
    random = np.random.default_rng(0).integers(0, 256, (2000, 3))
    colours = np.concatenate([np.repeat(np.arange(256), 3).reshape(-1, 3), random]).astype(np.uint8)
    np.testing.assert_allclose(to_lab(colours, "srgb"), rgb2lab(colours), atol=1e-9)
    assert to_lab(colours[:0], "srgb").shape == (0, 3)


@pytest.mark.parametrize(
    "colour, expected", [((50, 100, 50), 0.5), ((0, 90, 0), 2), ((90, 0, 90), -1), ((70, 70, 70), 0)]
)
def test_excess_green_is_twice_green_less_red_and_blue(colour, expected):
    # Woebbecke et al. 1995: 2 g - r - b of the chromaticities.
    found = _quantities("excess_green", np.array([colour], np.uint8), "srgb")["excess_green"]
    assert found == pytest.approx(expected)


def test_excess_green_of_black_is_nothing():
    assert _quantities("excess_green", np.zeros((1, 3), np.uint8), "srgb")["excess_green"] == 0


def test_hue_and_chroma_are_the_polar_form_of_a_and_b():
    # The sRGB primaries have the hues 40.0, 136.0 and 306.3 degree and the chromas 104.6, 119.8 and 133.8 in CIELAB.
    quantities = _quantities("hue", 255 * np.eye(3, dtype=np.uint8), "srgb")
    np.testing.assert_allclose(quantities["hue"], [40.0, 136.0, 306.3], atol=0.1)
    np.testing.assert_allclose(quantities["chroma"], [104.6, 119.8, 133.8], atol=0.1)
    np.testing.assert_allclose(quantities["lightness"], [53.24, 87.73, 32.30], atol=0.02)


def test_channels_count_from_0_to_1():
    quantities = _quantities("red", np.array([[255, 51, 0, 102]], np.uint8), "srgb")
    assert {name: float(values[0]) for name, values in quantities.items()} == pytest.approx(
        {"red": 1, "green": 0.2, "blue": 0, "near_infrared": 0.4}
    )


def test_ndvi_by_hand():
    colours = np.array([[50, 0, 0, 200], [200, 9, 9, 50], [0, 5, 5, 0], [7, 0, 0, 7]], np.uint8)
    np.testing.assert_allclose(ndvi(colours), [0.6, -0.6, 0, 0])
    assert to_coordinates(colours, "srgb")[0, 3] == pytest.approx(60)


def _features(light: np.ndarray) -> dict[str, np.ndarray]:
    """Features of a window of grey light (h, w)."""
    linear = np.stack([light] * 3).astype(np.float32)
    lab = np.stack([100 * light, 0 * light, 0 * light]).astype(np.float32)
    return dict(zip(names(), features(lab, linear, np.ones(light.shape, bool)), strict=True))


def test_gradient_of_light_that_grows_by_a_tenth_a_column():
    columns = np.exp(0.1 * np.arange(60)) * 0.01 - 0.004  # the logarithm is taken of light + 0.004
    ramp = _features(np.broadcast_to(columns, (60, 60)).copy())
    middle = np.s_[25:35, 25:35]
    # Squared slope 0.01, with 1e-4 added under the logarithm; all of it in one direction.
    np.testing.assert_allclose(ramp["log_gradient_4"][middle], 0.5 * np.log(0.01 + 1e-4), atol=1e-3)
    np.testing.assert_allclose(ramp["coherence_4"][middle], 0.01 / (0.01 + 1e-4), atol=1e-3)
    np.testing.assert_allclose(ramp["log_gradient_12"][30, 30], 0.5 * np.log(0.01 + 1e-4), atol=1e-3)


def test_a_gradient_across_rows_and_columns_is_as_coherent_as_one_across_columns():
    rows, columns = np.indices((60, 60))
    ramp = _features(0.01 * np.exp(0.05 * (rows + columns)) - 0.004)
    energy = 2 * 0.05**2  # all of it in one direction, the diagonal
    np.testing.assert_allclose(ramp["coherence_4"][30, 30], energy / (energy + 1e-4), atol=1e-3)


def test_deviation_of_a_chequerboard():
    board = np.indices((60, 60)).sum(axis=0) % 2
    values = _features(np.where(board, np.exp(0.5), np.exp(-0.5)) - 0.004)
    # Half of the texels at +0.5 and half at -0.5 (13 and 12 of 25): a variance of 0.25, of which 1 / 625 is the mean's.
    np.testing.assert_allclose(values["log_deviation_2"][30, 30], 0.5 * np.log(0.25 - 0.25 / 625 + 1e-4), atol=1e-3)
    # Steps of one texel cancel in central differences.
    assert values["log_gradient_4"][30, 30] == pytest.approx(0.5 * np.log(1e-4), abs=0.01)


def test_chromaticities_are_logarithms_of_ratios_to_green():
    linear = np.stack([np.full((50, 50), value) for value in (0.796, 0.196, 0.046)]).astype(np.float32)
    values = dict(zip(names(), features(np.zeros_like(linear), linear, np.ones((50, 50), bool)), strict=True))
    # With the 0.004 that is added: 0.8, 0.2 and 0.05.
    assert values["log_R/G_6"][25, 25] == pytest.approx(np.log(4), abs=1e-4)
    assert values["log_B/G_6"][25, 25] == pytest.approx(-np.log(4), abs=1e-4)


def test_boxes_average_over_the_radius_in_their_name():
    spot = np.zeros((80, 80))
    spot[40, 40] = 1.0
    values = _features(spot)
    for radius in (2, 6, 16):
        assert values[f"L_{radius}"][40, 40] == pytest.approx(100 / (2 * radius + 1) ** 2, rel=1e-3)
        assert values[f"L_{radius}"][40, 40 + radius] > 0 and values[f"L_{radius}"][40, 41 + radius] == pytest.approx(
            0, abs=1e-4
        )


def test_other_light_changes_exposure_more_than_tint():
    random, white = np.random.default_rng(0), np.ones((1, 1, 3), np.float32)
    gains = np.log(np.stack([in_other_light(white, random)[0, 0] for _ in range(4000)]))
    # Standard deviations of 0.14 of all channels together, 0.03 and 0.05 of red and blue against green.
    assert gains[:, 1].std() == pytest.approx(0.14, rel=0.05)
    assert (gains[:, 0] - gains[:, 1]).std() == pytest.approx(0.03, rel=0.05)
    assert (gains[:, 2] - gains[:, 1]).std() == pytest.approx(0.05, rel=0.05)


def _shadow(seed: int, side: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Light (h, w, 3) of a white window with shadows, and the mask of them."""
    return in_shadow(np.full((side, side, 3), 255, np.uint8), "srgb", np.random.default_rng(seed))


def test_shadows_leave_the_skylight_of_a_clear_day():
    """Diffuse over global irradiance of SPCTRAL2 (Bird and Riordan 1986) under a Sun at 45 degree in air of turbidity
    0.2, at the dominant wavelengths of the sRGB primaries; from shadow to shadow by a quarter.
    """
    air = {"surface_pressure": 101325.0, "relative_airmass": pvlib.atmosphere.get_relative_airmass(45.0)}
    clear = pvlib.spectrum.spectrl2(
        45.0, 45.0, 0.0, 0.2, **air, precipitable_water=1.5, ozone=0.31, aerosol_turbidity_500nm=0.2, dayofyear=100
    )
    diffuse, direct = np.ravel(clear["dhi"]), np.ravel(clear["poa_direct"])
    expected = np.interp([612.0, 549.0, 464.0], clear["wavelength"], diffuse / (diffuse + direct))
    darkest = np.log([_shadow(seed)[0].min(axis=(0, 1)) for seed in range(300)])
    np.testing.assert_allclose(np.exp(darkest.mean(axis=0)), expected, rtol=0.1)
    np.testing.assert_allclose(darkest.std(axis=0), 0.25, rtol=0.1)


@pytest.mark.parametrize("seed", [0, 1])
def test_half_of_a_window_has_less_than_half_of_the_direct_light(seed):
    light, shadow = _shadow(seed, 90)
    direct = (light - light.min(axis=(0, 1))) / np.ptp(light, axis=(0, 1))
    clear_cut = np.abs(direct[..., 0] - 0.5) > 1e-3
    np.testing.assert_array_equal(shadow[clear_cut], direct[clear_cut, 0] < 0.5)
    assert shadow.mean() == pytest.approx(0.5, abs=1e-3)


def test_penumbras_cover_a_sixteenth_of_a_window(monkeypatch):
    """Light fades from 88 to 12 % over 0.15 standard deviations of normal noise, about its median."""
    monkeypatch.setattr(textured, "BLOB", 0.5)
    light, _ = _shadow(0, 400)
    direct = (light[..., 0] - light[..., 0].min()) / np.ptp(light[..., 0])
    edge = 1 / (1 + np.exp(2))
    assert np.mean((direct > edge) & (direct < 1 - edge)) == pytest.approx(erf(0.075 / np.sqrt(2)), rel=0.06)
