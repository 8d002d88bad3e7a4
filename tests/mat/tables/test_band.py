"""Normalisation of lobes by angle of incidence: its nodes, and table 1 of DSTO-TN-0193."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.radiometry.lobe import SOURCE_ANGLES
from skyshine.mat.tables.band import INCIDENCE_ANGLES, with_fine_normalisation
from skyshine.materials.library import load_library
from skyshine.schemas.hdf5 import Group

# Width of a lobe [degree] and its N_s, the mean over six angles, of table 1.
TABLE_1 = {25.0: 29.72, 60.0: 5.57, 180.0: 1.13}


@pytest.fixture(scope="module")
def fine():
    material = load_library()["asphalt_road"]
    return with_fine_normalisation(Group(), [replace(material, lobe_fwhm=width) for width in TABLE_1])


def test_nodes_reach_from_normal_to_grazing_incidence_and_gather_there():
    assert INCIDENCE_ANGLES[0] == 0.0 and INCIDENCE_ANGLES[-1] == 90.0
    step = np.diff(INCIDENCE_ANGLES[1:-1])
    np.testing.assert_allclose(step[1:20] / step[:19], (0.02 / 80.0) ** (1 / 47), rtol=2e-3)
    assert np.all(step > 0)


def test_the_mean_over_the_source_angles_is_that_of_table_1(fine):
    for row, printed in zip(fine.variables["normalisation_fine"].data, TABLE_1.values(), strict=True):
        assert np.interp(SOURCE_ANGLES, INCIDENCE_ANGLES, row).mean() == pytest.approx(printed, rel=5e-3)
