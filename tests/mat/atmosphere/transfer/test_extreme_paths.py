"""Tables at the edges of what there is: every direction, thin and opaque air, black and white ground, day and night."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.geometry import trace
from skyshine.mat.atmosphere.transfer.segments import Segments
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import SpectralResponse, band_radiance

RESPONSE = SpectralResponse.rectangular(3.95, 4.05)
LIMB = -8.6  # degree; from 100 km this line of sight passes some 28 km above the ground
GRID = PathGrid(
    range_km=[0.001, 1.0, 400.0, 3000.0],
    altitude_km=[0.0, 2.0, 100.0],
    elevation_deg=[-90.0, -20.0, LIMB, -1.0, 0.0, 1.0, 90.0],
    source_elevation_deg=[-40.0, -0.5, 0.0, 90.0],
    source_azimuth_deg=[0.0, 180.0],
)


@pytest.fixture(scope="module")
def band():
    return some_of(points_of_band(AbsorptionTable.open(), RESPONSE), 5)


def some_of(band, step):
    """Some of the points of a band, with their own weights."""
    points = band.points.subset(np.arange(0, band.weight.size, step))
    return replace(band, points=points, weight=band.weight[::step])


def saturated(state):
    low = state.altitude < 10e3
    wet = np.where(low, saturation(state) / state.pressure, state.mole_fraction["H2O"])
    humid = replace(state, mole_fraction=state.mole_fraction | {"H2O": wet})
    assert np.all(humid.relative_humidity[low] > 0.95 * humid.relative_humidity[low].max())
    return humid


def saturation(state):
    """Vapour pressure over water, Pa (Magnus: World Meteorological Organization 2018, Guide to Instruments, annex
    4.B).
    """
    celsius = state.temperature - 273.15
    return 611.2 * np.exp(17.62 * celsius / (243.12 + celsius))


STATES = {
    "clear": {"aerosol": Aerosol("none")},
    "fog": {"aerosol": Aerosol(visibility_km=0.1)},
    "clean": {"aerosol": Aerosol(visibility_km=300.0)},
    "black ground": {"surface_albedo": 0.0},
    "white ground": {"surface_albedo": 1.0},
}


def made(name):
    if name == "saturated":
        return saturated(AtmosphericState.from_profile("tropical"))
    if name == "optical depth 1e4":
        state = AtmosphericState.from_profile("us_standard", aerosol=Aerosol(visibility_km=1.0))
        thick = tuple(replace(part, extinction_550=part.extinction_550 * 3e4) for part in state.aerosols)
        return replace(state, aerosols=thick)
    return AtmosphericState.from_profile("midlatitude_summer", **STATES[name])


@pytest.mark.parametrize("name", [*STATES, "saturated", "optical depth 1e4"])
def test_extremes_are_finite_and_bounded(band, name):
    state = made(name)
    whole = band.weight.sum()
    band = some_of(band, 6) if name in ("fog", "optical depth 1e4") else band  # each takes many directions
    sun = solar_irradiance(band.wavenumber)
    atmosphere = BandAtmosphere.of(state, band)
    if name == "optical depth 1e4":
        zenith = Segments.of(trace(atmosphere.air.shells, np.zeros(1), np.array([np.pi / 2])), 0)
        assert zenith.column(atmosphere.air.optics.extinction).sum(axis=0).max() > 1e4
    table = atmosphere.table(GRID, sun)
    for values in (table.beta_star, table.path_radiance_ratio, table.ambient, table.direct, table.transmittance):
        assert np.all(np.isfinite(values)) and np.all(values >= 0)
    assert np.all(table.transmittance <= 1 + 1e-12)
    assert np.all(np.diff(table.transmittance, axis=0) <= 1e-12)
    # Paths weight the points by their transmittance: the mean is below the largest.
    top = np.max(sun * band.wavenumber**2 * 1e-4) * band.weight.sum() / np.pi
    assert np.all(table.direct <= top * (1 + 1e-6))
    hottest = 1.001 * band_radiance(RESPONSE, max(state.temperature.max(), state.surface_temperature))
    hottest *= band.weight.sum() / whole
    # The sky scatters down no more than white ground under a bright sky can return, and emits no more than the hottest
    # air.
    assert np.all(table.ambient <= 2 * top + hottest)
    assert np.all(table.direct[:, :2, :4, 0] == 0)  # the Sun far below the horizon
    night = table.path_radiance_ratio[:, 0, :, 0]
    assert np.all(night <= hottest * (1 + 1e-6))


def test_isothermal_air_shows_its_temperature_along_every_path(band, isothermal):
    state = isothermal(270.0)
    state = replace(state, surface_temperature=270.0)
    table = BandAtmosphere.of(state, band).table(GRID, np.zeros(band.weight.size))
    air = BandAtmosphere.of(state, band).air
    # The blackbody radiance of the points, each weighted with what it absorbs, divided by what the band absorbs.
    for place, altitude in enumerate(GRID.altitude_km * 1e3):
        rays = trace(
            air.shells, np.full(7, altitude), np.radians(GRID.elevation_deg), np.tile(GRID.range_km * 1e3, (7, 1))
        )
        for row in range(7):
            segments = Segments.of(rays, row)
            if not segments.index.size:
                continue
            depth = np.cumsum(segments.column(air.optics.extinction), axis=0)
            black = air.optics.emission[0]
            for number, distance in enumerate(np.minimum(GRID.range_km * 1e3, rays.end[row])):
                node = min(int(np.searchsorted(segments.distance, distance)), segments.index.size)
                if node == 0:
                    continue
                absorbed = -np.expm1(-depth[node - 1])
                expected = (absorbed * black) @ band.radiance_weight / (absorbed @ band.weight / band.weight.sum())
                # Behind the ground it goes on with the mean of the last air before it.
                close = 1e-6 if table.valid[number, place, row] else 0.01
                assert table.path_radiance_ratio[number, place, row] == pytest.approx(expected, rel=close)


def test_transmittance_is_the_same_from_either_end(band):
    state = AtmosphericState.from_profile("midlatitude_summer", aerosol=Aerosol(visibility_km=23.0))
    air = BandAtmosphere.of(state, band).air
    # Back to the ground at the horizon: 1e-8 m of altitude moves the end by a third of a metre.
    for altitude, elevation, distance, tolerance in (
        (2e3, -1.0, 37e3, 1e-6),
        (100e3, LIMB, 1500e3, 1e-6),
        (0.0, 0.0, 100e3, 1e-4),
        (0.0, 90.0, 30e3, 1e-6),
        (5e3, -89.0, 1.0, 1e-6),
    ):
        there = trace(air.shells, np.array([altitude]), np.radians([elevation]), np.array([[distance]]))
        end = int(np.searchsorted(there.distance[0], distance))
        turned = there.direction[0, end] - there.central_angle[0, end] - np.pi / 2
        back = trace(air.shells, there.altitude[:, end], np.array([turned]), np.array([[distance]]))
        depths = []
        for rays in (there, back):
            segments = Segments.of(rays, 0)
            count = min(int(np.searchsorted(segments.distance, distance * (1 - 1e-12))), segments.index.size)
            depths.append(segments.first(count).column(air.optics.extinction).sum(axis=0))
        assert np.exp(-depths[1]) == pytest.approx(np.exp(-depths[0]), rel=tolerance, abs=1e-12)
