"""The rows that an interval's points reproduce: emission of slabs in closed form, candidates over all absorption."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.gases.path_states import planck_ratio, slab_emission
from skyshine.mat.spectroscopy.intervals import _stratified


def test_planck_ratio_is_that_of_the_law():
    """Against the warmest: 15 um at 250 and 300 K; the Rayleigh-Jeans limit is the ratio of temperatures."""
    found = planck_ratio(666.7, np.array([300.0, 250.0]))
    expected = np.expm1(1.438776877 * 666.7 / 300) / np.expm1(1.438776877 * 666.7 / 250)
    assert found == pytest.approx([1.0, expected], rel=1e-6)
    assert planck_ratio(1e-3, np.array([200.0, 300.0])) == pytest.approx([2 / 3, 1.0], rel=1e-5)


def test_slabs_of_one_temperature_emit_their_absorptance():
    depth = np.array([[0.1, 3.0, 0.0], [0.2, 50.0, 0.0]], np.float32)
    assert slab_emission(depth, np.ones(3)) == pytest.approx(1 - np.exp(-depth.sum(axis=0)), rel=1e-6)


def test_the_nearest_slab_hides_those_behind_it():
    """Opaque near slab between levels of 0.4 and 0.6; transparent near slab before an opaque one of 0.6 and 0.8."""
    depth = np.array([[60.0, 0.0], [60.0, 60.0]], np.float32)
    assert slab_emission(depth, np.array([0.4, 0.6, 0.8])) == pytest.approx([0.5, 0.7], rel=1e-6)


def test_fewer_slabs_than_layers_end_at_the_top_of_the_levels():
    depth = np.array([[60.0]], np.float32)
    assert slab_emission(depth, np.array([9.0, 9.0, 0.4, 0.6])) == pytest.approx([0.5], rel=1e-6)


def test_few_wavenumbers_are_all_candidates():
    assert _stratified(np.ones((3, 40), np.float32), 40, seed=1).tolist() == list(range(40))


def test_candidates_spread_over_absorption_not_over_wavenumber():
    """One wavenumber in a hundred lies in a line."""
    draw = np.random.default_rng(3)
    transmittance = np.where(np.arange(20_000) % 100 == 0, 0.01, 0.9) + draw.uniform(0, 0.05, 20_000)
    mixture = np.stack([transmittance, transmittance**4]).astype(np.float32)
    chosen = _stratified(mixture, 1000, seed=5)
    assert np.array_equal(chosen, np.unique(chosen)) and chosen.size <= 1002
    assert {int(np.argmin(transmittance)), int(np.argmax(transmittance))} <= set(chosen.tolist())
    # Every tenth of the order of absorption holds a tenth of the candidates.
    rank = np.argsort(np.argsort(transmittance))[chosen]
    assert np.histogram(rank, 10, (0, 20_000))[0] == pytest.approx(np.full(10, chosen.size / 10), rel=0.1)
    assert np.array_equal(chosen, _stratified(mixture, 1000, seed=5))
    assert not np.array_equal(chosen, _stratified(mixture, 1000, seed=6))
