"""Box means against those of scipy, and the light of windows against that of their pixels."""

import numpy as np
import pytest
from scipy.ndimage import uniform_filter

from skyshine.tmm.features.colour import DistinctColours
from skyshine.tmm.features.textured import RADII, LightPlanes, box_means, light_planes
from skyshine.tmm.images.texture import Texture


@pytest.mark.parametrize("shape", [(1, 1), (3, 50), (50, 3), (90, 71)])
@pytest.mark.parametrize("step", [1, 2, 3])
def test_box_means_are_those_of_scipy(shape, step):
    plane = np.random.default_rng(0).random(shape, dtype=np.float32) * 100
    for radius, mean in zip(RADII, box_means(plane, RADII, step), strict=True):
        expected = uniform_filter(plane.astype(float), 2 * radius + 1, mode="reflect")[::step, ::step]
        np.testing.assert_allclose(mean, expected, rtol=1e-6, atol=1e-5)


def test_means_of_what_is_far_brighter_beside_keep_their_digits():
    plane = np.full((60, 60), 1e-3, np.float32)
    plane[:20] = 1e6
    (mean,) = box_means(plane, (2,))
    np.testing.assert_allclose(mean[30:], 1e-3, rtol=1e-4)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32])
def test_light_of_a_window_is_that_of_its_pixels(kind):
    random = np.random.default_rng(1)
    pixels = random.random((20, 30, 3)) if kind is np.float32 else random.integers(0, np.iinfo(kind).max, (20, 30, 3))
    encoding = "linear" if kind is np.float32 else "srgb"
    texture = Texture(pixels.astype(kind), np.ones((20, 30), bool), encoding)
    lab, linear, valid = LightPlanes(texture, DistinctColours(texture)).window(slice(3, 11), slice(5, 29))
    whole = light_planes(texture.pixels[3:11, 5:29].reshape(-1, 3), encoding)
    np.testing.assert_allclose(lab.reshape(3, -1), whole[0], rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(linear.reshape(3, -1), whole[1], rtol=1e-5, atol=1e-6)
    assert valid.all() and lab.shape == (3, 8, 24)
