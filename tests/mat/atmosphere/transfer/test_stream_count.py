"""How many ordinates a state asks for: few in clear air, more the more light delta-M would cut off."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.particles.rain import RainLayer
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.stream_count import azimuthal_count, cut_depth, node_count

FEW = {
    "clear": {"aerosol": Aerosol("none")},
    "haze": {"aerosol": Aerosol("rural", visibility_km=23.0)},
    "thick haze": {"aerosol": Aerosol("rural", visibility_km=5.0)},
    "thin cloud": {"clouds": [CloudLayer("water", 1e3, 2e3, 10.0, 0.02)]},
}
MANY = {
    "fog": {"aerosol": Aerosol("fog_radiation")},
    "rain": {"rain": RainLayer(10.0, 3e3)},
    "water cloud": {"clouds": [CloudLayer("water", 1e3, 2e3, 10.0, 1.0)]},
    "cirrus": {"clouds": [CloudLayer("ice", 9.5e3, 11e3, 30.0, 0.5)]},
    "the thickest cloud": {"clouds": [CloudLayer("water", 1e3, 2e3, 10.0, 1e4)]},
}


def state_of(**about):
    return AtmosphericState.from_profile("midlatitude_summer", **about)


@pytest.mark.parametrize(("about", "nodes"), [*((a, 4) for a in FEW.values()), *((a, 6) for a in MANY.values())])
def test_clear_air_and_haze_ask_for_few_and_droplets_and_crystals_for_more(about, nodes):
    assert node_count(state_of(**about)) == nodes


def test_what_is_cut_off_grows_with_the_cloud_and_falls_with_the_ordinates():
    depths = [state_of(clouds=[CloudLayer("water", 1e3, 2e3, 10.0, depth)]) for depth in (0.1, 1.0, 10.0)]
    four, eight = (np.array([cut_depth(state, nodes) for state in depths]) for nodes in (4, 8))
    assert np.all(np.diff(four) > 0) and np.all(eight < four) and np.all(eight > 0)
    # Droplets of 10 um scatter half of their light into a diffraction peak, of which no solution keeps all.
    assert 0.3 < four[2] / 10.0 < 0.8
    assert cut_depth(state_of(aerosol=Aerosol("none")), 4) < 1e-2


def test_the_air_takes_what_its_state_asks_for_at_every_wavelength(synthetic_points):
    for low in (900.0, 15000.0):
        points = synthetic_points(np.array([low, low + 10]), {"CO2": [0.0]})
        for about, nodes in ((FEW["haze"], 4), (MANY["fog"], 6)):
            air = SpectralAir.of(state_of(**about), points)
            assert (air.nodes, air.azimuthal) == (nodes, azimuthal_count(nodes)) == (nodes, nodes + 2)
