"""Mie theory against published values and limits."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.mie import sphere_efficiencies


# Wiscombe 1979, NCAR/TN-140+STR, test cases of MIEV: extinction, scattering, asymmetry.
@pytest.mark.parametrize(
    ("size", "index", "extinction", "scattering", "asymmetry"),
    [
        (1.0, 1.33 + 1e-5j, 0.093952, 0.093923, 0.184517),
        (100.0, 1.33 + 1e-5j, 2.101321, 2.096594, 0.868959),
        (10000.0, 1.33 + 1e-5j, 2.004089, 1.723857, 0.907840),
        (0.055, 1.5 + 1j, 0.101491, 1.131687e-5, 0.000491),
        (100.0, 1.5 + 1j, 2.097502, 1.283697, 0.850252),
        (100.0, 10 + 10j, 2.071124, 1.836785, 0.556215),
        (10.0, 1.5 + 0j, 2.881999, 2.881999, 0.742913),
    ],
)
def test_published_efficiencies(size, index, extinction, scattering, asymmetry):
    found = sphere_efficiencies(size, index)
    assert found[0] == pytest.approx(extinction, rel=5e-6)
    assert found[1] == pytest.approx(scattering, rel=5e-6, abs=0)
    assert found[2] == pytest.approx(asymmetry, abs=1e-6)


def test_small_spheres_scatter_as_dipoles():
    x, m = 1e-3, 1.5 + 0.1j
    polarisability = (m**2 - 1) / (m**2 + 2)
    extinction, scattering, _ = sphere_efficiencies(x, m)
    assert scattering == pytest.approx(8 / 3 * x**4 * abs(polarisability) ** 2, rel=1e-4, abs=0)
    assert extinction == pytest.approx(4 * x * polarisability.imag, rel=1e-4, abs=0)


def test_large_black_spheres_take_away_twice_their_shadow():
    extinction, scattering, _ = sphere_efficiencies(np.array([5e3, 8e4]), 1.3 + 0.3j)
    assert extinction == pytest.approx(2.0, rel=0.01) and np.all(scattering > 1.0)
