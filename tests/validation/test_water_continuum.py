"""The water vapour continuum `lowtran7` against LOWTRAN7 itself: horizontal paths, its continuum alone.

At 296 and 260 K, the temperatures of its tables, both are the same. Between them LOWTRAN7 interpolates the self
continuum linearly in temperature, because it sums amounts along a path, and holds it outside; here it follows a power
of temperature, near the exponential of the model that the tables come from.
"""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.state.profiles import BOLTZMANN
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.bench import lowtran

pytestmark = pytest.mark.validation

BANDS = {"8-12 um": (830, 1250), "3-5 um": (2000, 3330)}
LENGTHS = (1e3, 5e3, 20e3)  # m


@pytest.mark.parametrize("band", BANDS)
@pytest.mark.parametrize(
    ("temperature", "h2o_fraction", "limit"),
    [(296.0, 0.02, 0.002), (260.0, 0.001, 0.001), (288.2, 0.0077, 0.025), (303.0, 0.03, 0.06)],
)
def test_transmittance_by_the_continuum_is_that_of_lowtran7(lowtran_program, band, temperature, h2o_fraction, limit):
    state = _isothermal_state(temperature, h2o_fraction)
    low, high = BANDS[band]
    points = AbsorptionTable.open(water_continuum="lowtran7").points(low, high)
    air = state.pressure[:1], state.temperature[:1], state.mole_fraction["H2O"][:1]
    section = points.cross_sections(*air, gases=["H2O_continuum"])["H2O_continuum"][0]
    errors = []
    for length in LENGTHS:
        peer = lowtran.run(lowtran_program, state, [lowtran.Sight(0.0, 0.0, length)], low, high, by_gas=True)
        theirs = np.interp(points.wavenumber, peer.wavenumber, peer.by_gas["H2O_continuum"][0])
        column = h2o_fraction * state.pressure[0] / (BOLTZMANN * temperature) * length
        errors.append(np.exp(-column * section) - theirs)
        print(
            f"\n{temperature:g} K, {h2o_fraction:g}, {band}, {length / 1e3:g} km: rms {_rms(errors[-1]):.5f}, largest"
            f" {np.abs(errors[-1]).max():.5f}, smallest transmittance {theirs.min():.3f}"
        )
    assert np.abs(errors).max() <= limit


def _isothermal_state(temperature, h2o_fraction):
    state = AtmosphericState.from_profile("us_standard", aerosol=Aerosol("none"))
    levels = {name: getattr(state, name)[::2] for name in ("altitude", "pressure")}  # LOWTRAN7 takes 34 levels
    fractions = {gas: values[::2] for gas, values in state.mole_fraction.items()}
    fractions["H2O"] = np.full_like(fractions["H2O"], h2o_fraction)
    return replace(state, **levels, temperature=np.full(levels["altitude"].size, temperature), mole_fraction=fractions)


def _rms(values):
    return float(np.sqrt(np.mean(np.square(values))))
