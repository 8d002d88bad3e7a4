"""The nodes of the cross sections reach over all air that a state may hold."""

import numpy as np

from skyshine.mat.spectroscopy.nodes import H2O_FRACTION, HUMID_PRESSURE, PRESSURE, TEMPERATURE


def test_nodes_increase_and_reach_the_extremes():
    """Records of the ground: 1,084 hPa (Agata, reduced to sea level), 330 K (Death Valley), 60 hPa of vapour."""
    for nodes in (PRESSURE, TEMPERATURE, H2O_FRACTION):
        assert np.all(np.diff(nodes) > 0)
    assert PRESSURE[-1] > 1.084e5 and PRESSURE[0] <= 0.03 and TEMPERATURE[-1] > 330 and TEMPERATURE[0] <= 150
    assert H2O_FRACTION[0] == 0 and H2O_FRACTION[-1] >= 6e3 / 101325


def test_even_steps_of_temperature_in_the_logarithm_and_close_pressures_in_dense_air():
    ratio = TEMPERATURE[1:] / TEMPERATURE[:-1]
    assert ratio.max() / ratio.min() < 1.06
    dense = PRESSURE > 10e2
    assert np.all(PRESSURE[dense][1:] / PRESSURE[dense][:-1] < np.exp(0.6))


def test_humid_nodes_begin_at_25_hectopascal():
    assert PRESSURE[HUMID_PRESSURE] == 2500.0
