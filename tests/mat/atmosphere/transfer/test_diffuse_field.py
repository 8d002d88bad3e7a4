"""What delta-M takes out of the phase function."""

from types import SimpleNamespace

import numpy as np
import pytest

from skyshine.mat.atmosphere.transfer.diffuse_field import delta_fraction, solved_moments


@pytest.mark.parametrize("nodes", [2, 4, 16])
@pytest.mark.parametrize("asymmetry", [0.0, 0.6, 0.85])
def test_of_henyey_and_greenstein_goes_straight_forward_the_power_of_as_many_moments_as_streams(nodes, asymmetry):
    """Wiscombe 1977: f is g to the number of streams, the first moment that a solution does not have."""
    moments = (asymmetry ** np.arange(65))[:, None, None]
    optics = SimpleNamespace(moments=moments, phase_share=np.ones((1, 1)))
    assert delta_fraction(optics, nodes) == pytest.approx(asymmetry ** (2 * nodes), rel=1e-12)
    assert solved_moments(optics, nodes)[:, 0, 0] == pytest.approx(asymmetry ** np.arange(2 * nodes))
