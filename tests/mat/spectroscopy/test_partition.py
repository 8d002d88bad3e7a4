"""Partition sums and molar masses against published values."""

import numpy as np
import pytest

from skyshine.mat.spectroscopy.partition import REFERENCE_TEMPERATURE, molar_mass, partition_ratio, per_line

pytest.importorskip("hapi", reason="needs hitran-api")
H2O, CO2, CO, O2 = 1, 2, 5, 7


def test_the_ratio_is_one_at_the_reference_temperature():
    assert REFERENCE_TEMPERATURE == 296.0 and partition_ratio(CO2, 1, 296.0) == 1.0


@pytest.mark.parametrize("temperature", [150.0, 200.0, 250.0])
def test_a_linear_molecule_in_the_cold_follows_the_rigid_rotor(temperature):
    """Q = k T / (h c B) + 1/3 (Herzberg 1950); B of CO is 1.9225 cm^-1, and vibration adds less than 1e-4 at 296 K."""

    def rotor(kelvin):
        return kelvin / (1.438776877 * 1.9225) + 1 / 3

    assert partition_ratio(CO, 1, temperature) == pytest.approx(rotor(296.0) / rotor(temperature), rel=1e-3)


def test_a_nonlinear_molecule_goes_with_the_power_of_three_halves():
    assert partition_ratio(H2O, 1, 200.0) == pytest.approx((296 / 200) ** 1.5, rel=0.01)


def test_molar_masses_of_the_isotopologues():
    """g/mol, from the atomic masses 1.007825, 12, 13.003355, 15.994915, 17.999160 u (AME2020)."""
    found = [molar_mass(H2O, 1), molar_mass(CO2, 1), molar_mass(CO2, 2), molar_mass(CO2, 3), molar_mass(O2, 1)]
    assert found == pytest.approx([18.010565, 43.98983, 44.993185, 45.994075, 31.98983], rel=2e-6)


def test_each_line_has_the_value_of_its_isotopologue():
    lines = np.array([3, 1, 1, 2, 3])
    assert per_line(molar_mass, CO2, lines) == pytest.approx([45.9941, 43.9898, 43.9898, 44.9932, 45.9941], rel=1e-5)
    assert per_line(partition_ratio, CO2, np.ones(2, int), 250.0).tolist() == [partition_ratio(CO2, 1, 250.0)] * 2
