"""Discrete ordinates: energy, limits of optical depth, the cut into layers."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.transfer import ordinates

SUN = np.array([0.2, 0.6, 1.0])


def slab(depth, single_scattering_albedo=1.0, asymmetry=0.0, albedo=0.0, layers=4):
    """Rising, falling and direct flux (layers + 1, sources) of a slab with Henyey and Greenstein's phase function."""
    layer = np.full((layers, 1), depth / layers)
    scattering = layer[..., None] * single_scattering_albedo * asymmetry ** np.arange(ordinates.MOMENTS)
    beam = (np.arange(layers, -1, -1) * depth / layers)[:, None, None] / SUN
    rising, falling = (ordinates.flux(part)[:, 0] for part in ordinates.radiances(layer, scattering, beam, SUN, albedo))
    return rising, falling, SUN * np.exp(-beam[:, 0])


@pytest.mark.parametrize("depth", [0.0, 1e-12, 1e-3, 0.1, 1.0, 10.0, 100.0, 1e4])
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


def test_a_thin_layer_scatters_isotropic_light_half_up():
    rising, falling, _ = slab(1e-6, 0.7)
    assert rising[-1] == pytest.approx(np.full(3, 0.35e-6), rel=1e-4)
    assert falling[0] == pytest.approx(np.full(3, 0.35e-6), rel=1e-4)
