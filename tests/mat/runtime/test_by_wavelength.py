"""Integrals over the wavelengths of a band, against sums written out."""

from types import SimpleNamespace

import numpy as np
import pytest

from skyshine.mat.runtime.by_wavelength import emitted_share, reflected

# Two materials at three wavelengths.
REFLECTANCE = np.array([[0.1, 0.2, 0.4], [0.0, 0.5, 1.0]])
EMISSION = np.array([[0.2, 0.3, 0.5], [0.5, 0.25, 0.25]])
SPECTRA = SimpleNamespace(reflectance=REFLECTANCE, emission=EMISSION)
THROUGH = np.array([0.9, 0.5, 0.1])


def test_surfaces_emit_what_they_do_not_reflect_and_paths_let_through():
    by_hand = [0.9 * 0.2 * 0.9 + 0.8 * 0.3 * 0.5 + 0.6 * 0.5 * 0.1, 0.5 * 0.9 + 0.5 * 0.25 * 0.5 + 0.0]
    assert emitted_share(SPECTRA, THROUGH) == pytest.approx(by_hand)


def test_surfaces_reflect_each_wavelength_by_its_reflectance():
    light = np.array([2.0, 1.0, 0.5])
    assert reflected(SPECTRA, light) == pytest.approx([0.2 + 0.2 + 0.2, 0.0 + 0.5 + 0.5])
    assert np.all(reflected(SPECTRA, -light) == 0)  # no light is below 0
