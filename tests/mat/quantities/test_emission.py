"""Transmittance weighted by what surfaces emit: closed forms, the classic beta* as a special case, extremes, classes of
materials.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.emission import EmissionClasses, beta_star_table, emission_weights
from skyshine.mat.quantities.formulas import BETA_CAP_KM, mean_transmittance
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import SpectralResponse, planck_wavenumber

GRID = PathGrid(
    [0.0, 1e-6, 0.001, 1.0, 10.0, 300.0, 36000.0],
    [0.0, 0.3, 12.0, 100.0, 36000.0],
    [-90.0, -8.0, -1.0, 0.0, 1.0, 90.0],
    [0.0],
    [0.0],
)


@pytest.fixture(scope="module")
def band():
    response = SpectralResponse.rectangular(4.17, 4.24)  # carbon dioxide: opaque within metres, and clear beside it
    return band_points(AbsorptionTable.open().points(*response.wavenumber_range), response)


@pytest.fixture(scope="module")
def atmosphere(band):
    return BandAtmosphere.of(
        AtmosphericState.from_profile("us_standard", gas_amounts=GasAmounts(ppm={"CO2": 420})), band
    )


def two_points(wavenumber=(2000.0, 3000.0)):
    """A band of two spectral points, 1 and 3 um wide."""
    width = np.array([1.0, 3.0])
    return SimpleNamespace(
        wavenumber=np.array(wavenumber), weight=width, radiance_weight=width * np.square(wavenumber) * 1e-4
    )


def test_through_grey_air_every_surface_is_seen_alike():
    weights = emission_weights(two_points(), np.array([[0.1, 0.7], [0.0, 0.0], [1.0, 1.0]]), 300.0)
    depth = np.array([0.0, 1e-12, 0.3, 50.0, 2e5])
    np.testing.assert_allclose(
        mean_transmittance(np.repeat(depth[:, None], 2, axis=1), weights)[0],
        -np.repeat(depth[:, None], 3, axis=1),
        rtol=1e-12,
    )


def test_a_step_of_emissivity_is_the_integral_by_hand():
    """(5): of light emitted by 0.9 at 5 um, which the air absorbs, and by 0.2 at 3.3 um, which it does not."""
    band = two_points()
    emitted = np.array([0.9, 0.2]) * planck_wavenumber(band.wavenumber, 320.0) * band.radiance_weight
    weights = emission_weights(band, np.array([[0.1, 0.8]]), 320.0)
    tau = np.exp(mean_transmittance(np.array([[2.0, 0.01]]), weights)[0])[0, 0]
    assert tau == pytest.approx(emitted @ np.exp([-2.0, -0.01]) / emitted.sum(), rel=1e-13)
    assert tau < 0.5 * (np.exp(-2.0) + 3 * np.exp(-0.01)) / 4  # the flat mean


def test_a_mirror_counts_as_black():
    dark, black = emission_weights(two_points(), np.array([[1.0, 1.0], [0.0, 0.0]]), 250.0)
    np.testing.assert_array_equal(dark, black)


def test_where_a_surface_emits_nothing_at_the_clear_points_logarithms_stay_exact():
    weights = np.array([[0.0, 1.0], [0.5, 0.5], [1.0, 0.0]])
    found, _ = mean_transmittance(np.array([[1.0, 9e4], [1e-18, 1e-18]]), weights)
    np.testing.assert_allclose(found[0], [-9e4, -1.0 + np.log(0.5), -1.0], rtol=1e-12)
    np.testing.assert_allclose(found[1], -1e-18, rtol=1e-6)


def test_with_the_weights_of_the_band_alone_it_is_the_classic_beta_star(atmosphere):
    """From range 0 to 36,000 km, from the ground to a geostationary orbit, behind the ground too."""
    weight = atmosphere.band.weight / atmosphere.band.weight.sum()
    classic = atmosphere.table(GRID, np.zeros(weight.size), wanted=("beta_star",))
    beta, valid = beta_star_table(atmosphere.air, GRID, weight[None])
    np.testing.assert_array_equal(valid, classic.valid)
    np.testing.assert_allclose(beta[0], classic.beta_star, rtol=1e-9)
    assert not valid.all() and (classic.transmittance[valid] < 1e-3).any() and (beta == BETA_CAP_KM).any()


def test_extremes_are_finite_and_have_their_limits(atmosphere):
    band = atmosphere.band
    only_opaque = np.where(
        (band.wavenumber > 2310) & (band.wavenumber < 2380), 0.0, 1.0
    )  # reflects all but the strongest absorption
    weights = emission_weights(band, np.stack([only_opaque, 1 - only_opaque]), 300.0)
    beta, valid = beta_star_table(atmosphere.air, GRID, weights)
    assert np.all(np.isfinite(beta)) and np.all(beta > 0) and np.all(beta <= BETA_CAP_KM)
    low = beta[:, :, 0, 3]  # level, on the ground
    np.testing.assert_allclose(low[:, 0], low[:, 1], rtol=5e-3)  # a millimetre absorbs thousandths
    tau = np.exp(-5.5 * GRID.range_km[:, None, None] / beta)
    assert np.all(tau[0, 3:5][valid[3:5]] <= tau[1, 3:5][valid[3:5]])  # the strongest absorption lets least through
    assert np.all(np.diff(tau[:, :, 1, 5], axis=1) <= 1e-12)  # upwards, less and less over range


def test_classes_hold_their_bound_and_are_numbered_in_order():
    generator = np.random.default_rng(6)
    centres = np.array([0.2, 0.5, 0.21])
    through = centres[[1, 0, 1, 2, 0, 1]] + generator.uniform(-1e-3, 1e-3, (50, 6))
    classes = EmissionClasses.of(through, 4e-3)
    assert classes.number.tolist() == [1, 2, 1, 3, 2, 1] and classes.count == 3
    means = classes.means(through.T)
    difference = np.abs(through - means[classes.number - 1].T).max(axis=0)
    np.testing.assert_allclose(classes.difference, difference)
    assert classes.difference.max() <= 4e-3
    assert EmissionClasses.of(through, 0.5).count == 1
    assert EmissionClasses.of(through, 1e-9).number.tolist() == [1, 2, 3, 4, 5, 6]


def test_one_material_and_no_path_are_classes_too():
    assert EmissionClasses.of(np.full((3, 1), 0.4), 1e-3).number.tolist() == [1]
    assert EmissionClasses.of(np.zeros((0, 4)), 1e-3).number.tolist() == [1, 1, 1, 1]
