"""Light along sampled lines, segment by segment: the same as along the whole line and up to each of its ranges."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.sample import Sample
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.segments import Depths
from skyshine.mat.quantities.grid import PathGrid

GRID = PathGrid([0.001, 1.0, 20.0], [0.002, 2.0], [-20.0, 0.0, 60.0], [3.0, 50.0], [0.0, 180.0])


@pytest.fixture(scope="module")
def air():
    points = AbsorptionTable.open().points(2500.0, 2530.0)
    return SpectralAir.of(AtmosphericState.from_profile("midlatitude_summer"), points)


@pytest.fixture(scope="module")
def lines(air):
    return Sample.for_fit(air.shells, GRID, 6, np.random.default_rng(3)).lines


def test_segments_add_up_to_the_light_of_double_precision_at_each_range(air, lines):
    single_extinction = air.optics.extinction.astype(np.float32)
    for line in lines:
        depths = Depths(line.segments.column(single_extinction))
        single = air.scattered_light.of_segments(line.segments, depths, line.to_source, line.deflection)
        for end in line.node:
            near = line.segments.first(int(end))
            depths = Depths(near.column(air.optics.extinction))
            ends = slice(None, end + 1)
            whole = air.scattered_light.along(near, depths, line.to_source[ends], line.deflection[ends])[0][0]
            np.testing.assert_allclose(single[:end].sum(axis=0), whole, rtol=2e-5)
