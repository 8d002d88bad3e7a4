"""Fields of scattered light between solved points of a band: as if solved at each, in air that absorbs in lines."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.line_of_sight import lines_of_sight
from skyshine.mat.measure.probes import OF_PATHS
from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.line_sources import LineSources
from skyshine.mat.radiometry.blackbody import SpectralResponse


@pytest.fixture(scope="module", params=["clear", "cloud"])
def air(request):
    """64 points of the water band at 0.94 um, under two elevations of the Sun."""
    clouds = [CloudLayer("water", 1e3, 2e3, 10.0, 3.0)] if request.param == "cloud" else []
    state = AtmosphericState.from_profile("midlatitude_summer", clouds=clouds, surface_albedo=0.3)
    band = points_of_band(AbsorptionTable.open(), SpectralResponse.rectangular(0.925, 0.955))
    index = np.arange(64)
    air = SpectralAir.of(state, band.points.subset(index), band.gases, band.weight[index])
    return replace(air, elevations=(10.0, 60.0), azimuthal=2, nodes=2, spherical=False)


def scattered(air):
    """Light along three lines of sight, (3, P), and sky light of the ground, (P,)."""
    ranges, up = np.full((3, 1), 1e5), np.radians([2.0, 30.0, 90.0])
    sources = LineSources.at(np.radians([60.0]), np.radians([40.0]))
    along = [
        air.scattered_light.along(
            path.segments, path.segment_depths, sources.to_source(path.ends), sources.deflection(path.ends)
        )[0, 0]
        for path in lines_of_sight(air, ranges, np.full(3, 10.0), up)
    ]
    return np.array(along), air.diffuse_light.sky(np.zeros(1), np.radians([60.0]))[0, 0]


def test_the_field_between_solved_points_is_nearly_their_own(air):
    (line, sky), (shared_line, shared_sky) = scattered(air), scattered(replace(air, every=4))
    assert sky.max() > 3 * sky.min()  # lines absorb most of it
    for own, shared in ((line, shared_line), (sky[None], shared_sky[None])):
        assert shared.mean(axis=-1) == pytest.approx(own.mean(axis=-1), rel=0.006)
        assert np.std(shared - own, axis=-1) == pytest.approx(
            0.0, abs=0.05 * own.mean()
        )  # air of one depth absorbs at other heights
    assert np.any(shared_sky != sky)


def test_between_two_solved_points_each_of_two_has_its_own_field(air):
    two = air.part(np.array([3, 40]))
    (line, sky), (same_line, same_sky) = scattered(two), scattered(replace(two, every=2))
    assert same_line == pytest.approx(line, rel=1e-5) and same_sky == pytest.approx(sky, rel=1e-5)


def test_tables_of_thermal_bands_in_clear_air_have_the_field_of_all_points():
    """Path radiance under a high and a low Sun, in kelvin of a black body at 300 K; not in short waves, in cloud or
    for fine tolerances.
    """
    clear = AtmosphericState.from_profile("midlatitude_summer", surface_albedo=0.1)
    cloudy = AtmosphericState.from_profile("us_standard", clouds=[CloudLayer("water", 1e3, 2e3, 10.0, 3.0)])
    responses = [SpectralResponse.rectangular(*ends) for ends in ((4.0, 4.02), (2.0, 2.01))]
    band, short = (points_of_band(AbsorptionTable.open(), response) for response in responses)
    atmosphere = BandAtmosphere.of(clear, band)
    tables = atmosphere.tabulated(0.3, "K")
    assert tables.air.every > 1 == BandAtmosphere.of(cloudy, band).tabulated(0.3, "K").air.every
    assert BandAtmosphere.of(clear, short).tabulated(0.3, "K").air.every == 1
    finer = ((0.2, "K"), (0.5, "%"), (1.0, "W m^-2 sr^-1"))
    assert all(atmosphere.tabulated(*tolerance).air.every == 1 for tolerance in finer)
    sunlight = solar_irradiance(band.wavenumber, band.width)
    paths = np.array([0.3, 5.0]), np.array([0.1, 0.1]), np.array([3.0, -1.0])
    suns = np.array([[50.0, 1.0], [50.0, 1.0]]), np.full((2, 2), 20.0)
    none = np.zeros(0, int)
    full, few = (
        each.along_lines(paths[0][:, None], *paths[1:], *suns, none, sunlight, quantities=OF_PATHS)
        for each in (atmosphere, tables)
    )
    kelvin = Scale.kelvin(responses[0])
    through = full.transmittance[:, :, None]
    error = kelvin.error("path_radiance_ratio", few.path_radiance_ratio, full.path_radiance_ratio, through, 1.0)
    assert 0 < np.abs(error).max() < 0.02
