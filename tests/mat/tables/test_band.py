"""Normalisation of lobes by angle of incidence: table 1 of DSTO-TN-0193."""

from dataclasses import replace

import pytest

from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.sources import LONGEST_WAVE, solar_spectrum
from skyshine.mat.tables.band import band_group
from skyshine.materials.library import load_library

# Width of a lobe [degree] and its N_s, the mean over six angles, of table 1.
TABLE_1 = {25.0: 29.72, 60.0: 5.57, 180.0: 1.13}


def test_the_normalisation_of_a_band_is_that_of_table_1():
    material = load_library()["asphalt_road"]
    lobes = [replace(material, lobe_fwhm=width) for width in TABLE_1]
    band = band_group(SpectralResponse.rectangular(8.0, 12.0), lobes, solar_spectrum(LONGEST_WAVE)).variables
    assert band["normalisation"].data == pytest.approx(list(TABLE_1.values()), rel=5e-3)
    assert band["normalisation_by_angle"].data.mean(axis=1) == pytest.approx(band["normalisation"].data)
