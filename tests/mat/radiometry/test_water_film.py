"""Reflectance under films of water against published numbers and against light counted bounce by bounce."""

import numpy as np
import pytest

from skyshine.mat.radiometry.water_film import (
    diffuse_reflectance,
    film_reflectance,
    film_shares,
    moist_reflectance,
)


def test_diffuse_reflectance_is_the_mean_of_fresnel():
    """0.0664 of water, 0.0918 of glass of 1.5 (Duntley's table), as integrals over the hemisphere are."""
    cosine = (np.arange(20000) + 0.5) / 20000
    for index in (1.1, 1.333, 1.5, 2.0):
        below = np.sqrt(1 - (1 - cosine**2) / index**2)
        parallel = ((index * cosine - below) / (index * cosine + below)) ** 2
        upright = ((cosine - index * below) / (cosine + index * below)) ** 2
        mean = np.mean((parallel + upright) * cosine)
        assert diffuse_reflectance(index) == pytest.approx(mean, rel=1e-5)
    assert diffuse_reflectance(1.5) == pytest.approx(0.0918, abs=1e-4)


def test_film_is_a_series_of_bounces():
    """Light enters, meets the ground, is thrown back at the water's face, again and again."""
    dry, index, thickness, wavelength = 0.4, 1.33 + 1e-5j, 2e-4, 1.0
    face = abs((index - 1) / (index + 1)) ** 2
    back = 1 - (1 - diffuse_reflectance(1.33)) / 1.33**2
    passed = np.exp(-8 * np.pi * 1e-5 * thickness / 1e-6)
    gain = (1 - diffuse_reflectance(2 / 1.33)) / (1 - diffuse_reflectance(2.0))
    ground = 1 - 0.6 * (0.4 * gain + 0.6)
    left, out = 1 - face, face
    for _ in range(200):
        left *= passed * ground
        out += left * (1 - back)
        left *= back
    assert film_reflectance([dry], [wavelength], [index], thickness)[0] == pytest.approx(out, rel=1e-9)


def test_bright_and_dark_ends_stay():
    """A surface that absorbs nothing stays white under clear water; one that absorbs all keeps the water's own face."""
    clear = [1.333 + 0j]
    assert film_reflectance([1.0], [0.5], clear, 1e-3)[0] == pytest.approx(1.0)
    assert film_reflectance([0.0], [0.5], clear, 1e-3)[0] == pytest.approx(0.0204, abs=1e-4)


def test_idso_loam():
    """Idso et al. (1975): smooth loam goes from an albedo of 0.30 dry to 0.14 wet; in sunlight without absorption in
    water, Lekner and Dorf's share of that is to some 0.19."""
    assert film_reflectance([0.30], [0.6], [1.333 + 0j], 1e-4)[0] == pytest.approx(0.18, abs=0.02)


def test_opaque_water_covers_what_lies_below():
    wet = film_reflectance([0.0, 0.5], [10.0, 10.0], [1.218 + 0.0508j] * 2, 1e-4)
    assert wet[0] == pytest.approx(wet[1], abs=1e-6)


def test_moisture_darkens_steadily_from_dry():
    index, um = [1.333 + 1e-7j], [0.8]
    levels = [float(moist_reflectance([0.35], um, index, moisture)[0]) for moisture in np.linspace(0, 0.6, 25)]
    assert levels[0] == pytest.approx(0.35) and levels[2] == pytest.approx(0.35)
    assert np.all(np.diff(levels) <= 1e-12) and levels[-1] > 0.2
    assert film_shares(0.3).sum() == pytest.approx(1.0)
    np.testing.assert_allclose(film_shares(0.3)[:2], np.exp(-1), rtol=1e-3)
