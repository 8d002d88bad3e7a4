"""The bound of scattered light against the whole computation, in air drawn at random over all that a job may ask
for.
"""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol_column import BOUNDARY_MODELS, STRATOSPHERES, Aerosol
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.particles.rain import RainLayer
from skyshine.mat.atmosphere.sources.lunar import lunar_irradiance
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.profiles import PROFILES
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.bounds import Scattering
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import SpectralResponse

pytestmark = pytest.mark.validation
CASES = 60


def drawn(generator):
    """A state; ice cloud where it is cold, water cloud where it is not."""
    chance = generator.random
    clouds = []
    if chance() < 0.3:
        base = generator.uniform(9e3, 11e3)
        clouds.append(
            CloudLayer(
                "ice",
                base,
                base + generator.uniform(100, 2e3),
                generator.uniform(10, 90),
                10 ** generator.uniform(-6, 1),
            )
        )
    name = str(generator.choice(sorted(PROFILES)))
    if chance() < 0.3 and "winter" not in name:
        base = generator.uniform(0, 1e3)
        clouds.append(
            CloudLayer(
                "water",
                base,
                base + generator.uniform(50, 800),
                generator.uniform(4, 20),
                10 ** generator.uniform(-5, 2),
            )
        )
    return AtmosphericState.from_profile(
        name,
        aerosol=Aerosol(
            str(generator.choice([*BOUNDARY_MODELS, "none"])),
            visibility_km=10 ** generator.uniform(-1, 2.47),
            stratosphere=str(generator.choice(list(STRATOSPHERES))),
        ),
        surface_albedo=float(generator.choice([0.0, generator.random(), 0.95])),
        surface_altitude=float(generator.choice([0.0, 2100.0])),
        gas_amounts=GasAmounts(scale={"H2O": float(generator.choice([0.01, 1.0]))}),
        clouds=clouds,
        rain=RainLayer(10 ** generator.uniform(-1, 2), 2e3) if chance() < 0.15 and not clouds else None,
    )


@pytest.mark.parametrize("seed", range(CASES))
def test_light_of_the_sky_stays_below_its_bound(seed):
    generator = np.random.default_rng(seed)
    state = drawn(generator)
    low = generator.uniform(0.4, 13.0)
    response = SpectralResponse.rectangular(low, low + 4e-4 * low**2)
    points = points_of_band(AbsorptionTable.open(), response)
    ground = state.surface_altitude * 1e-3
    grid = PathGrid(
        np.unique([0.0, *10 ** generator.uniform(-2, 4, 5)]),
        np.unique(ground + 10 ** generator.uniform(-3, 3, 4)),
        np.unique([0.0, *generator.uniform(-90, 90, 6)]),
        np.unique(generator.uniform(-15, 90, 6)),
        [0.0, 3.0, 60.0, 180.0],
    )
    moonlit = generator.random() < 0.3
    light = (
        lunar_irradiance(points.wavenumber, 40.0, 3.844e8, 1.0, True).total
        if moonlit
        else solar_irradiance(points.wavenumber)
    )
    air = BandAtmosphere.of(state, points)
    whole, dark = air.table(grid, light), replace(air, air=replace(air.air, scatters=False)).table(grid, light)
    through = whole.transmittance[..., None]
    path = np.abs(whole.path_radiance_ratio - dark.path_radiance_ratio) * (1 - through)[..., None]
    largest = max(path.max(), (np.abs(whole.ambient - dark.ambient) * through).max())
    bound = Scattering.of(air.air).radiance(light, points.radiance_weight)
    print(f"\n{low:.2f} um, {state.name}: bound over largest {bound / largest:.3g}")
    assert 0 < largest <= bound
