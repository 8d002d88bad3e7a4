"""Light on surfaces as a sum of few spectra."""

import numpy as np
import pytest

from skyshine.mat.quantities.channels.surface_light import LightParts

WAVES = np.linspace(0, 1, 40)
WEIGHT = np.full(40, 0.5)
THROUGH = np.exp(-np.outer(np.linspace(0, 3, 20), 1 + WAVES))


def light_of(count):
    """Light (count, 40) of smooth spectra."""
    return np.array([np.exp(-3 * WAVES / (number + 1)) for number in range(count)])


@pytest.mark.parametrize("allowed", [1.0, 1e-2, 1e-4, 1e-6])
def test_each_light_is_within_what_is_allowed(allowed):
    spectral = light_of(30)
    parts = LightParts.of(spectral, WEIGHT, THROUGH, allowed)
    exact = (spectral * WEIGHT) @ THROUGH.T
    np.testing.assert_allclose(parts.value.T @ (THROUGH @ parts.factor).T, exact, rtol=0, atol=allowed)
    assert len(parts.value) <= len(LightParts.of(spectral, WEIGHT, THROUGH, allowed / 10).value)


def test_as_many_parts_as_spectra_are_independent():
    spectral = np.outer([1.0, 2.0, 3.0], WAVES) + np.outer([1.0, 0.0, 5.0], np.ones(40))
    assert len(LightParts.of(spectral, WEIGHT, THROUGH, 1e-12).value) == 2


def test_shape_is_kept_and_darkness_is_dark():
    parts = LightParts.of(light_of(6).reshape(2, 3, 40), WEIGHT, THROUGH, 1e-3)
    assert parts.value.shape[1:] == (2, 3) and parts.factor.shape == (40, len(parts.value))
    dark = LightParts.of(np.zeros((2, 3, 40)), WEIGHT, THROUGH, 1e-3)
    assert dark.value.shape == (1, 2, 3) and not dark.value.any() and np.all(np.isfinite(dark.factor))
