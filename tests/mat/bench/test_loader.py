"""The bench of the loader: its own reader and scipy's agree, in a table of any number of axes."""

import pytest

from skyshine.mat.bench.loader import bench_loader


@pytest.mark.parametrize("shape", [(5,), (3, 4), (2, 3, 2, 3, 2)])
def test_both_readers_agree_to_rounding(shape):
    result = bench_loader(shape, 500)
    assert result.shape == shape and 0 <= result.difference < 1e-12
    assert result.values_per_second > 0 and result.scipy_values_per_second > 0
