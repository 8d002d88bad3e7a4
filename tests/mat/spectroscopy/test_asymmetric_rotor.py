"""Levels and moments of an asymmetric rotor, against measured frequencies and limits that are known exactly."""

import numpy as np
import pytest

from mat.maintain.lines.rotors.asymmetric import (
    Moment,
    VibrationalState,
    angular_momentum,
    direction_cosines,
    levels,
    moments,
)
from mat.maintain.lines.rotors.ozone import GROUND, state

GHZ = 29.9792458  # of 1 cm^-1
# Rotational lines of ozone, GHz (JPL catalogue, tag 48004).
MICROWAVE = [
    ((1, 1, 1), (0, 0, 0), 118.364),
    ((2, 1, 1), (2, 0, 2), 96.228),
    ((4, 1, 3), (4, 0, 4), 101.737),
    ((6, 1, 5), (6, 0, 6), 110.836),
    ((8, 1, 7), (8, 0, 8), 124.087),
    ((10, 1, 9), (10, 0, 10), 142.175),
    ((16, 1, 15), (16, 0, 16), 231.281),
]


def energy(j, ka, kc):
    found = levels((GROUND,), j)
    return found.energy[(found.ka == ka) & (found.kc == kc)].item()


@pytest.mark.parametrize(("upper", "lower", "frequency"), MICROWAVE)
def test_microwave_lines_of_ozone(upper, lower, frequency):
    assert (energy(*upper) - energy(*lower)) * GHZ == pytest.approx(frequency, abs=0.002)


def test_a_symmetric_top_has_levels_in_closed_form():
    a, b = 3.0, 0.5
    top = VibrationalState("000", 10.0, (a, b, b), (1e-4, 2e-6, 3e-7, 0.0, 0.0))
    j = 7
    found = levels((top,), j)
    square, k = j * (j + 1), found.ka
    expected = 10 + b * square + (a - b) * k**2 - 3e-7 * square**2 - 2e-6 * square * k**2 - 1e-4 * k**4
    assert found.energy == pytest.approx(expected, abs=1e-9)
    assert k.tolist() == list(range(1, 8))  # 7 is odd: K = 0 is forbidden


def test_nuclear_spin_leaves_half_of_the_levels():
    for j in range(6):
        even, odd = levels((GROUND,), j), levels((state("001"),), j)
        assert even.energy.size + odd.energy.size == 2 * j + 1
        assert np.all((even.ka + even.kc) % 2 == 0)
        assert np.all((odd.ka + odd.kc) % 2 == 1)


def test_coupling_repels_levels_and_keeps_their_sum():
    pair = state("100"), state("001")
    for j in (3, 12):
        apart, coupled = levels(pair, j, 0.0), levels(pair, j, 0.47)
        assert coupled.energy.sum() == pytest.approx(apart.energy.sum(), abs=1e-7)
        gap = [one.energy[one.state == 0].mean() - one.energy[one.state == 1].mean() for one in (apart, coupled)]
        # Of second order, by h^2 <Jy^2> over their distance, which shrinks as K grows.
        assert gap[1] - gap[0] == pytest.approx(2 * 0.47**2 * (j * (j + 1) / 3) / gap[0], rel=0.3)


def test_angular_momentum_commutes_as_it_must():
    for j, upper in ((4, 5), (5, 5), (5, 4)):
        phi_x, phi_z = direction_cosines(j, upper)
        jx, i_jy, jz = angular_momentum(j)
        ux, ui_jy, uz = angular_momentum(upper)
        assert ux @ phi_x == pytest.approx(phi_x @ jx, abs=1e-12)
        assert uz @ phi_z == pytest.approx(phi_z @ jz, abs=1e-12)
        assert ui_jy @ phi_z - phi_z @ i_jy == pytest.approx(phi_x, abs=1e-12)
        assert ux @ ux - ui_jy @ ui_jy + uz @ uz == pytest.approx(upper * (upper + 1) * np.eye(2 * upper + 1))


@pytest.mark.parametrize("moment", [Moment(x=0.3), Moment(z=0.7)])
def test_line_strengths_of_a_level_sum_to_the_moment(moment):
    lower = levels((GROUND,), 10)
    upper_state = state("010") if moment.x else state("001")
    squares = [moments(lower, levels((upper_state,), j), (moment,)) ** 2 for j in (9, 10, 11)]
    assert np.concatenate(squares).sum(axis=0) == pytest.approx(21 * (moment.x**2 + moment.z**2))
