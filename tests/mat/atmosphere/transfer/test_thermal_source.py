"""The thermal source function of air with particles: equilibrium, bounds, limits."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.transfer import geometry
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.radiometry.blackbody import planck_wavenumber

EDGES = np.array([900.0, 905.0])
SECTIONS = np.array([0.0, 1e-32, 1e-28, 1e-26, 1e-25, 1e-24, 1e-22, 1e-20])


@pytest.fixture(scope="module")
def air(synthetic_points, isothermal):
    state = replace(isothermal(280.0, aerosol=Aerosol("rural", visibility_km=2.0)), surface_temperature=280.0)
    return SpectralAir.of(state, synthetic_points(EDGES, {"CO2": SECTIONS}))


def test_without_particles_the_source_is_the_black_body(synthetic_points, isothermal):
    clear = SpectralAir.of(isothermal(280.0), synthetic_points(EDGES, {"CO2": SECTIONS}))
    assert clear.thermal.isotropic
    assert np.array_equal(clear.thermal.by_direction[:, 0], clear.optics.emission)


def test_nothing_is_brighter_than_the_enclosure(air):
    black, source = planck_wavenumber(902.5, 280.0), air.thermal.by_direction
    assert np.all(np.isfinite(source)) and np.all(source >= 0)
    assert np.all(source <= black * (1 + 1e-6))
    assert np.all(source[:, 0] >= source[:, -1] - 1e-9 * black)  # upward and downward: space is dark


def test_deep_inside_opaque_air_the_source_is_the_black_body(air):
    black = planck_wavenumber(902.5, 280.0)
    assert air.thermal.by_direction[:30, :, -1] == pytest.approx(np.full((30, 16), black), rel=1e-6)


def test_the_source_between_directions_and_levels_is_linear(air):
    table = air.thermal.by_direction
    angle = np.linspace(0, np.pi, 16)
    for layer, share, cosine in ((0, 0.25, np.cos(0.7)), (3, 0.6, -0.98), (5, 0.0, 1.0), (5, 1.0, -1.0)):
        level = table[layer] * (1 - share) + table[layer + 1] * share + air.thermal.shift[layer]
        place = np.arccos(cosine)
        wanted = [np.interp(place, angle, level[:, p]) for p in range(level.shape[1])]
        assert air.thermal.at(layer, share, cosine) == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize("elevation", [-90.0, -30.0, 20.0])
def test_air_and_ground_of_one_temperature_below_it_look_as_their_emissivity(synthetic_points, isothermal, elevation):
    """Opaque haze of one temperature over a black ground: the view down is a black body but for the dark of space."""
    state = replace(isothermal(280.0, aerosol=Aerosol("fog_advection")), surface_temperature=280.0, surface_albedo=0.0)
    air = SpectralAir.of(state, synthetic_points(EDGES, {"CO2": SECTIONS[-1:]}))
    rays = geometry.trace(air.shells, np.array([10.0]), np.radians([elevation]))
    segments = Segments.of(rays, 0)
    depths = Depths(segments.column(air.optics.extinction))
    seen = air.thermal_radiance(segments, depths).sum(axis=0)
    black = planck_wavenumber(902.5, 280.0)
    assert seen + np.exp(-depths.cumulative[-1]) * black == pytest.approx(black, rel=1e-4)


def test_particles_dim_the_sky_little_and_path_radiance_stays_below_the_black_body(air):
    black = planck_wavenumber(902.5, 280.0)
    rays = geometry.trace(air.shells, np.array([0.0, 0.0, 5e3]), np.radians([90.0, 3.0, -80.0]))
    for row in range(3):
        segments = Segments.of(rays, row)
        depth = segments.column(air.optics.extinction)
        radiance = air.thermal_radiance(segments, Depths(depth)).sum(axis=0)
        assert np.all(radiance <= -np.expm1(-depth.sum(axis=0)) * black * (1 + 1e-9))
        assert np.all(radiance > 0)
