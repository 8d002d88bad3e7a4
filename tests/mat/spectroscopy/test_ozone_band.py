"""Ozone at 9.6 um in the packaged table, ground to space in the US Standard atmosphere, interval by interval."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.state.state import AtmosphericState


@pytest.fixture(scope="module")
def transmittance():
    """By lower edge of the interval, cm^-1."""
    state = AtmosphericState.from_profile("us_standard", aerosol=Aerosol("none"))
    edge = np.concatenate([np.arange(0, 30e3, 500.0), np.arange(30e3, 60e3, 2e3)])
    middle = 0.5 * (edge[1:] + edge[:-1])
    pressure, temperature = state.pressure_at(middle), state.temperature_at(middle)
    column = state.mole_fraction_at("O3", middle) * pressure / (1.380649e-23 * temperature) * np.diff(edge)
    points = AbsorptionTable.open().points(980.0, 1150.0)
    section = points.cross_sections(pressure, temperature, np.zeros(pressure.size), gases=["O3"])["O3"]
    through = np.exp(-column @ section)
    return {
        round(low): points.weight[points.interval == k] @ through[points.interval == k] / (high - low)
        for k, (low, high) in enumerate(points.interval_edges)
    }


def test_the_branches_of_v3_have_a_gap_between_them(transmittance):
    gap = transmittance[1040]
    assert gap > max(transmittance[low] for low in (1025, 1030, 1035, 1045, 1050, 1055)) + 0.1
    p_branch, r_branch = transmittance[1020], transmittance[1055]
    assert 0.15 < r_branch < p_branch < 0.55


def test_the_r_branch_ends_in_a_steep_head(transmittance):
    head = [transmittance[low] for low in (1055, 1060, 1065, 1070)]
    assert np.all(np.diff(head) > 0.1)


def test_no_staircase_of_15_wavenumbers_is_left(transmittance):
    values = np.array([transmittance[low] for low in range(985, 1075, 5)])
    steps = np.abs(np.diff(values))
    assert np.sum(steps < 0.005) <= 1


def test_v1_has_its_own_branches_beyond(transmittance):
    middle, r_branch = transmittance[1110], transmittance[1125]
    assert r_branch < middle - 0.005


def test_the_table_says_that_the_lines_were_generated():
    texts = AbsorptionTable.open().provenance("O3"), AbsorptionTable.open().provenance("N2O")
    for (low, high), found in zip(((980.0, 1085.0), (1240.0, 1320.0)), texts, strict=True):
        inside = [text for first, last, text in found if first < high and last > low]
        assert len(inside) == 1
        assert inside[0].startswith("lines generated from published constants")
