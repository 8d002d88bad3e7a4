"""Few points for scattered light: they give the light of all, of the same source, down to none."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.line_of_sight import lines_of_sight
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.joined_paths import JoinedPaths
from skyshine.mat.quantities.line_sources import LineSources
from skyshine.mat.quantities.path_radiance import scattered_light
from skyshine.mat.quantities.scattering_points import ScatteringPoints
from skyshine.mat.radiometry.blackbody import SpectralResponse

RESPONSE = SpectralResponse.rectangular(3.97, 4.03)
ALTITUDE = np.array([10.0, 500.0, 3000.0, 10.0, 900.0, 50.0, 2.0, 8000.0])
ELEVATION = np.radians([5.0, -3.0, 40.0, 0.2, -20.0, 80.0, -0.05, -2.0])
LENGTH = np.array([3e3, 2e3, 2e4, 6e4, 1e3, 5e4, 1e3, 9e4])
SOURCES = LineSources.at(np.radians([2.0, 30.0, 70.0]), np.radians([5.0, 60.0, 150.0]))


@pytest.fixture(scope="module")
def air():
    band = points_of_band(AbsorptionTable.open(), RESPONSE)
    return BandAtmosphere.of(AtmosphericState.from_profile("midlatitude_summer"), band)


@pytest.fixture(scope="module")
def paths(air):
    return list(lines_of_sight(air.air, LENGTH[:, None] * np.array([0.0, 0.3, 1.0]), ALTITUDE, ELEVATION))


@pytest.fixture(scope="module")
def spectra(air, paths):
    return np.concatenate(
        [
            air.air.scattered_light.along(
                path.segments, path.segment_depths, SOURCES.to_source(path.ends), SOURCES.deflection(path.ends)
            )[0]
            for path in paths
        ]
    ).astype(float)


@pytest.mark.parametrize("faint", [1.0, 1e-7], ids=["sun", "moon"])
def test_few_points_give_the_light_of_all_along_whole_lines(air, paths, spectra, faint):
    """At each range and at its limit 0, of the Sun and of a source as faint as the Moon."""
    irradiance = faint * solar_irradiance(air.band.wavenumber)
    every = ScatteringPoints.every(air.air, air.band, irradiance)
    total = spectra @ every.weight
    few = every.fewest(spectra, 1e-3 * float(np.sqrt(np.mean(total**2))))
    assert few.index.size < 0.5 * every.index.size and np.all(few.weight >= 0)
    for path in paths:
        lines = JoinedPaths.of([path])
        whole, part = (scattered_light(air.air, air.band, lines, [SOURCES], points) for points in (every, few))
        assert part.along[path.node] == pytest.approx(whole.along[path.node], abs=0.02 * float(whole.along.max()))
        assert part.limit(0) == pytest.approx(whole.limit(0), rel=0.03)


def test_an_error_that_nothing_meets_keeps_all_points(air, spectra):
    every = ScatteringPoints.every(air.air, air.band, solar_irradiance(air.band.wavenumber))
    assert every.fewest(spectra, 0.0) is every


def test_without_light_or_lines_all_points_stay(air, spectra):
    dark = ScatteringPoints.every(air.air, air.band, np.zeros(air.band.weight.size))
    assert dark.fewest(spectra, 1.0) is dark
    lit = ScatteringPoints.every(air.air, air.band, solar_irradiance(air.band.wavenumber))
    assert lit.fewest(spectra[:0], 1.0) is lit and lit.fewest(spectra[:1], 1.0) is lit
