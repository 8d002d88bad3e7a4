"""Layers joined by adding, and orders of scattering: energy, equilibrium, limits of depth, the cut into layers."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.transfer import adding, scattering_orders
from skyshine.mat.atmosphere.transfer.ordinates import ordinates

SUN = np.array([0.2, 0.6, 1.0])
DIRECTIONS = ordinates(4)
FLAT = ordinates(4, 1)
DEPTHS = [0.0, 1e-12, 1e-3, 0.1, 1.0, 10.0, 100.0, 1e4]


def layers(depth, single, asymmetry, count):
    """Optical depths and weighted moments of equal layers with Henyey and Greenstein's phase function."""
    weighted = min(single, 1 - 1e-12) * DIRECTIONS.factor * asymmetry ** np.arange(DIRECTIONS.moments)
    return np.full((count, 1), depth / count), np.broadcast_to(weighted[:, None], (count, weighted.size, 1))


def slab(depth, single=1.0, asymmetry=0.0, albedo=0.0, count=4, solver=adding):
    """Rising, falling and direct flux (count + 1, sources) of a slab."""
    beam = (np.arange(count, -1, -1) * depth / count)[:, None, None] / SUN[:, None]
    field = solver.sunlight(DIRECTIONS, *layers(depth, single, asymmetry, count), beam, SUN, np.array([albedo]))
    rising, falling = (DIRECTIONS.flux(part)[..., 0] for part in field)
    return rising, falling, SUN * np.exp(-beam[..., 0])


def warm(depth, single, asymmetry, emission, ground, albedo=0.0, solver=adding):
    """Radiances (levels, nodes) rising and falling in a slab with blackbody radiances at its levels, over a ground."""
    emission = np.asarray(emission, dtype=float)
    slabs = layers(depth, single, asymmetry, emission.size - 1)
    field = solver.thermal(FLAT, *slabs, emission[:, None], np.array([ground]), np.array([albedo]))
    return [part[:, 0, :, 0, 0] for part in field]


@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("asymmetry", [-0.3, 0.0, 0.7])
@pytest.mark.parametrize("albedo", [0.0, 1.0])
def test_pure_scattering_keeps_all_energy(depth, asymmetry, albedo):
    rising, falling, direct = slab(depth, asymmetry=asymmetry, albedo=albedo)
    net = (direct + falling - rising) / SUN
    assert net == pytest.approx(np.broadcast_to(net[-1], net.shape), abs=1e-3)
    assert rising[0] == pytest.approx(albedo * (direct + falling)[0], rel=1e-9, abs=1e-12)
    assert np.all(rising > -1e-12) and np.all(falling > -1e-12)


def test_the_cut_into_layers_does_not_matter():
    for one, many in zip(slab(2.0, 0.9, 0.6, 0.2, 1), slab(2.0, 0.9, 0.6, 0.2, 40), strict=True):
        assert one[[0, -1]] == pytest.approx(many[[0, -1]], rel=1e-9)
    one, many = (warm(2.0, 0.9, 0.6, np.linspace(300.0, 200.0, n + 1), 310.0, 0.2) for n in (1, 40))
    for few, fine in zip(one, many, strict=True):
        assert few[[0, -1]] == pytest.approx(fine[[0, -1]], rel=1e-9)


def test_a_thin_layer_scatters_isotropic_light_half_up():
    rising, falling, _ = slab(1e-6, 0.7)
    assert rising[-1] == pytest.approx(np.full(3, 0.35e-6), rel=1e-4)
    assert falling[0] == pytest.approx(np.full(3, 0.35e-6), rel=1e-4)


@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("single", [0.0, 0.5, 0.99, 1.0])
@pytest.mark.parametrize("count", [1, 5])
def test_what_enters_and_leaves_air_of_one_temperature_obeys_kirchhoff(depth, single, count):
    """Emission and reflection of a slab add up: with the light of a black ground all around, all is black."""
    rising, falling = warm(depth, single, 0.8, np.full(count + 1, 2.5), 2.5)
    lit = adding.thermal(
        FLAT, *layers(depth, single, 0.8, count), np.zeros((count + 1, 1)), np.array([2.5]), np.zeros(1)
    )
    emitted = rising[-1] - lit[0][-1, 0, :, 0, 0]  # upward, without the ground's light
    downward = falling[0]
    # A slab is the same from both sides: what it sends up from inside and what it sends down, less the ground's
    # light that it reflects, are one.
    assert emitted == pytest.approx(downward - lit[1][0, 0, :, 0, 0], rel=1e-6, abs=1e-9)
    transmitted, reflected = lit[0][-1, 0, :, 0, 0], lit[1][0, 0, :, 0, 0]
    assert emitted + transmitted + reflected == pytest.approx(np.full(4, 2.5), rel=1e-6)


@pytest.mark.parametrize("asymmetry", [0.0, 0.85])
def test_deep_inside_light_diffuses_along_the_gradient(asymmetry):
    """Radiance B + cosine dB/dtau / (1 - albedo g): the particular solution, far from both ends."""
    emission = np.linspace(5.0, 1.0, 41)
    rising, falling = warm(4000.0, 0.9, asymmetry, emission, 5.0)
    slope = 4.0 / 4000.0 / (1 - 0.9 * asymmetry)
    # But for the quadrature of the highest moment.
    assert rising[20] - falling[20] == pytest.approx(2 * FLAT.node * slope, rel=0.01 if asymmetry else 1e-6)
    assert 0.5 * (rising[20] + falling[20]) == pytest.approx(np.full(4, emission[20]), rel=1e-9)


def test_an_inversion_is_seen_from_both_sides():
    emission = [1.0, 4.0, 1.0]
    rising, falling = warm(60.0, 0.3, 0.5, emission, 0.0)
    assert rising[-1] == pytest.approx(falling[0], rel=1e-6)
    assert np.all(rising[1] < 4.0) and np.all(rising[-1] > 0.8)


@pytest.mark.parametrize("single", [0.0, 0.6])
def test_thin_layers_meet_the_closed_form_without_a_seam(single):
    depths = np.geomspace(3e-5, 3e-4, 60)
    top = np.array([warm(depth, single, 0.5, [3.0, 2.0], 0.0)[0][-1] for depth in depths])
    steps = np.diff(np.log(top), axis=0)
    assert np.ptp(steps, axis=0) == pytest.approx(np.zeros(4), abs=2e-4)  # each is about 0.039
    assert steps.mean(axis=0) == pytest.approx(np.full(4, np.log(10) / 59), rel=5e-3)


@pytest.mark.parametrize("albedo", [0.0, 0.6])
@pytest.mark.parametrize("absorbing", [0.0, 5.0, 1e3])
def test_orders_of_scattering_agree_with_adding(albedo, absorbing):
    depth, scattered = 0.2 + absorbing, 0.2
    case = depth, scattered / depth, 0.7
    exact, orders = slab(*case, albedo, 60), slab(*case, albedo, 60, solver=scattering_orders)
    for one, other in zip(exact, orders, strict=True):
        assert other == pytest.approx(one, rel=1e-3, abs=1e-3 * exact[0].max())
    emission = np.linspace(3.0, 2.0, 61)
    for one, other in zip(
        warm(*case, emission, 3.3, albedo), warm(*case, emission, 3.3, albedo, scattering_orders), strict=True
    ):
        assert other == pytest.approx(one, rel=1e-3, abs=1e-9)


def test_each_point_has_its_own_albedo():
    depth, weighted = layers(0.5, 0.9, 0.5, 3)
    both = np.tile(depth, 2), np.tile(weighted, 2)
    emission = np.linspace(3.0, 2.0, 4)[:, None]
    for solver in (adding, scattering_orders):
        together = solver.thermal(FLAT, *both, np.tile(emission, 2), np.array([2.0, 1.0]), np.array([0.1, 0.8]))
        for point, (ground, albedo) in enumerate([(2.0, 0.1), (1.0, 0.8)]):
            alone = solver.thermal(FLAT, depth, weighted, emission, np.array([ground]), np.array([albedo]))
            for one, other in zip(together, alone, strict=True):
                assert one[..., point] == pytest.approx(other[..., 0], rel=1e-4)
