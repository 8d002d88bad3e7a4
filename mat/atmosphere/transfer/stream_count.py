"""How many discrete ordinates the particles of a state ask for.

Delta-M lets the moments of the phase function beyond those of the solution go straight forward. What it cuts off
matters where much light is scattered so: among droplets, crystals and dense haze, not in clear air. The number is that
of the state, whatever the wavelength, so that all its bands and spectra share one field. Errors against ordinates and
seconds: `tests/bench/atmosphere.py`, and `tests/validation/test_transfer_disort.py`.
"""

from __future__ import annotations

import numpy as np
import scipy

from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.diffuse_field import NODES
from skyshine.schemas.arrays import Floats

# Nodes of each hemisphere where delta-M cuts off more than `_THICK` of `NODES`.
MANY = 6
# Vertical depth of scattering, at 0.55 um.
_THICK = 0.1
_REFERENCE = np.array([1e4 / 0.55])  # cm^-1


def node_count(state: AtmosphericState) -> int:
    """Nodes of each hemisphere for a state.

    Examples
    --------
    >>> from skyshine.mat.atmosphere.particles.cloud import CloudLayer
    >>> node_count(AtmosphericState.from_profile("us_standard"))
    4
    >>> cloud = CloudLayer("water", 1e3, 2e3, 10.0, 3.0)
    >>> node_count(AtmosphericState.from_profile("us_standard", clouds=[cloud]))
    6
    """
    return MANY if cut_depth(state, NODES) > _THICK else NODES


def azimuthal_count(nodes: int) -> int:
    """Azimuthal moments of the light that go with nodes of a hemisphere."""
    return nodes + 2


def cut_depth(state: AtmosphericState, nodes: int) -> float:
    """Vertical optical depth of the scattering at 0.55 um that delta-M takes for straight forward."""
    if not state.particles:
        return 0.0
    humidity = state.relative_humidity
    per_metre: Floats = np.zeros(state.altitude.size)
    for component in state.particles:
        optics = component.model.optics(_REFERENCE, humidity)
        scattering = (optics.extinction * optics.single_scattering_albedo)[:, 0]
        moment = component.model.phase_moments(_REFERENCE, humidity)[2 * nodes, :, 0]
        per_metre += component.extinction_550 * scattering * np.clip(moment, 0.0, None)
    return float(scipy.integrate.trapezoid(per_metre, state.altitude))
