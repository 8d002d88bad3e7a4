"""Normalisation of lobes by angle of incidence: its nodes, table 1 of DSTO-TN-0193, and the error that it states."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.radiometry.lobe import SOURCE_ANGLES, normalisation_to_grazing
from skyshine.mat.tables.band import INCIDENCE_ANGLES, with_fine_normalisation
from skyshine.materials.library import load_library
from skyshine.schemas.hdf5 import Group

# Width of a lobe [degree] and its N_s, the mean over six angles, of table 1.
TABLE_1 = {25.0: 29.72, 60.0: 5.57, 180.0: 1.13}


@pytest.fixture(scope="module")
def fine():
    material = load_library()["asphalt_road"]
    return with_fine_normalisation(Group(), [replace(material, lobe_fwhm=width) for width in TABLE_1], seed=3)


def test_nodes_reach_from_normal_to_grazing_incidence_and_gather_there():
    assert INCIDENCE_ANGLES[0] == 0.0 and INCIDENCE_ANGLES[-1] == 90.0
    step = np.diff(INCIDENCE_ANGLES[1:-1])
    np.testing.assert_allclose(step[1:20] / step[:19], (0.02 / 80.0) ** (1 / 47), rtol=2e-3)
    assert np.all(step > 0)


def test_the_mean_over_the_source_angles_is_that_of_table_1(fine):
    for row, printed in zip(fine.variables["normalisation_fine"].data, TABLE_1.values(), strict=True):
        assert np.interp(SOURCE_ANGLES, INCIDENCE_ANGLES, row).mean() == pytest.approx(printed, rel=5e-3)


def test_the_stated_error_is_that_of_linear_interpolation(fine):
    """The worst of random angles is about the worst of even ones, of the narrowest lobe, which varies fastest."""
    stated = fine.groups["accuracy"].variables
    width, row = min(TABLE_1), fine.variables["normalisation_fine"].data[0]
    angle = np.linspace(0.0, 90.0, 241)
    error = np.abs(np.interp(angle, INCIDENCE_ANGLES, row) - normalisation_to_grazing(width, angle))
    assert stated["maximum"].data[0] == pytest.approx(error.max(), rel=0.2)
    assert stated["rms"].data[0] < stated["p95"].data[0] < stated["maximum"].data[0]
