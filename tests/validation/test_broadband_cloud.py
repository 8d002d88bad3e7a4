"""Broadband fluxes under cloud, rain and desert dust against all points of the table: the chosen points have seen only
fog for cloud.
"""

import numpy as np
import pytest

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.cloud import cloud_type
from skyshine.mat.atmosphere.particles.rain import RainLayer
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.spectra.fluxes import LONGWAVE, SHORTWAVE, broadband_fluxes, sky_emission, sunlight_shares
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir

pytestmark = pytest.mark.validation

ALTITUDE, ELEVATION, ALBEDO = np.array([0.0, 2000.0]), np.array([10.0, 50.0]), 0.2
STATES = {
    "stratus": {"clouds": ["stratus"]},
    "cirrus": {"clouds": ["cirrus"]},
    "rain": {"clouds": ["nimbostratus"], "rain": RainLayer(5.0, 2e3)},
    "desert": {"aerosol": Aerosol("desert", wind_speed=15.0)},
}


@pytest.mark.parametrize("name", list(STATES))
def test_few_points_agree_with_all_under(name):
    about = dict(STATES[name])
    about["clouds"] = [cloud_type(kind) for kind in about.get("clouds", [])]
    state = AtmosphericState.from_profile("midlatitude_summer", **about)
    few = broadband_fluxes(state, ALTITUDE, ELEVATION, ALBEDO)
    points = AbsorptionTable.open().points(*LONGWAVE)
    longwave = sky_emission(state, points, ALTITUDE) @ points.weight
    points = AbsorptionTable.open().points(*SHORTWAVE)
    low, high = points.interval_edges.T
    sun = points.weight * solar_irradiance(0.5 * (low + high), high - low)[points.interval]
    light = 0.0
    for part in np.array_split(np.arange(sun.size), 16):  # bounds memory
        air = SpectralAir.of(state, points.subset(part))
        light = light + np.array(sunlight_shares(air, ALTITUDE, ELEVATION, ALBEDO)) @ sun[part]
    error = few.longwave_down - longwave, few.direct_normal - light[0], few.diffuse - light[1]
    largest = [float(np.abs(one).max()) for one in error]
    print(f"\n{name}: longwave {largest[0]:.2f}, direct normal {largest[1]:.2f}, diffuse {largest[2]:.2f} W m-2")
    assert (
        largest[0] <= 1.0
        and np.all(np.abs(error[1]) <= 2 + 0.005 * light[0])
        and np.all(np.abs(error[2]) <= 2 + 0.005 * light[1])
    )
