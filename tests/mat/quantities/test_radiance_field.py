"""Radiance around a point by direction: samples of cells, and the light of a sky against its flux."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.sky import sky_irradiance
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.radiance_field import Directions, GroundReflection, RadianceField, cell_phases
from skyshine.mat.radiometry.blackbody import SpectralResponse

UP = np.array([0.0, 0.0, 1.0])


def test_samples_lie_evenly_over_their_cells():
    """The azimuths of all cells together are equally spaced over half a turn, and each cell's heights between its
    edges; half a step lies outside both ends.
    """
    directions = Directions.of(4, 3)
    x, y, z = np.moveaxis(directions.samples, -1, 0)
    azimuth = np.unique(np.round(np.arctan2(y, x), 9))
    np.testing.assert_allclose(azimuth, np.pi * (np.arange(azimuth.size) + 0.5) / azimuth.size, atol=1e-8)
    for row, (lower, upper) in enumerate(directions.edges):
        height = np.unique(np.round(z[row], 9))
        share = (np.arange(height.size) + 0.5) / height.size
        np.testing.assert_allclose(height, lower + (upper - lower) * share, atol=1e-8)


@pytest.mark.parametrize("elevation", [20.0, 60.0])
def test_the_light_of_the_sky_is_its_flux(synthetic_points, elevation):
    """Light of the source over the cells of the upper hemisphere, times their cosine, is the irradiance that the
    quadrature of `sky_irradiance` gives.
    """
    edges = np.array([2400.0, 2600.0])
    points = synthetic_points(edges, {"CO2": np.array([3e-28, 3e-27])})
    state = AtmosphericState.from_profile("midlatitude_summer", surface_albedo=0.3)
    band = band_points(points, SpectralResponse.rectangular(1e4 / edges[1], 1e4 / edges[0]))
    air, source = BandAtmosphere.of(state, band).air, np.radians([elevation])
    air.prepare()
    directions = Directions.of(12, 6)
    reflection = GroundReflection.of(air, source)
    phases = cell_phases(air, directions, source)
    field = RadianceField.at(air, 0.0, source, reflection, directions, phases)
    weights = directions.irradiance_weights(UP)
    assert not weights[:12].any()
    irradiance = np.einsum("da,dap->p", weights, field.scattered[:, 0])
    expected = sky_irradiance(air, np.zeros(1), source).scattered[0, 0]
    assert expected.min() > 0
    np.testing.assert_allclose(irradiance, expected, rtol=0.02)
