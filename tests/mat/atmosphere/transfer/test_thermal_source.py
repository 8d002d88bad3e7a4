"""The thermal source function of air with particles: equilibrium, bounds, limits."""

from dataclasses import replace

import numpy as np
import pytest
from light_parts import thermal_of, thermal_source

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


def by_direction(air):
    """The source function at the levels (N, X, P), and the cosines (X,) of its directions."""
    cosine = np.cos(np.linspace(0.01, np.pi - 0.01, 16))
    layers = range(air.state.altitude.size - 1)
    levels = [[thermal_source(air, layer, 0.0, c) for c in cosine] for layer in layers]
    return np.array([*levels, [thermal_source(air, layers[-1], 1.0, c) for c in cosine]]), cosine


def test_without_particles_the_source_is_the_black_body(synthetic_points, isothermal):
    clear = SpectralAir.of(isothermal(280.0), synthetic_points(EDGES, {"CO2": SECTIONS}))
    assert clear.thermal.field is None
    assert thermal_source(clear, 4, 0.0, 0.3) == pytest.approx(clear.optics.emission[4], rel=1e-8)


def test_nothing_is_brighter_than_the_enclosure(air):
    black, (source, _) = planck_wavenumber(902.5, 280.0), by_direction(air)
    assert np.all(np.isfinite(source)) and np.all(source >= 0)
    assert np.all(source <= black * (1 + 1e-6))
    assert np.all(source[:, 0] >= source[:, -1] - 1e-9 * black)  # upward and downward: space is dark


def test_deep_inside_opaque_air_the_source_is_the_black_body(air):
    black = planck_wavenumber(902.5, 280.0)
    source = by_direction(air)[0]
    assert source[:30, :, -1] == pytest.approx(np.full((30, 16), black), rel=1e-6)


def test_the_source_inside_a_layer_lies_between_those_at_its_levels(air):
    for layer, cosine in ((0, np.cos(0.7)), (3, -0.98), (5, 1.0)):
        below, middle, above = (thermal_source(air, layer, share, cosine) for share in (0.0, 0.5, 1.0))
        assert middle == pytest.approx(0.5 * (below + above), rel=0.02)
        assert np.all(middle >= np.minimum(below, above) * (1 - 2e-3))
        assert np.all(middle <= np.maximum(below, above) * (1 + 2e-3))


def along(air, field, altitude, elevation):
    """Light (K, P) of the segments of a ray through a field, the segments and their depths, all and delta-scaled."""
    rays = geometry.trace(air.shells, np.array([altitude]), np.radians([elevation]))
    segments = Segments.of(rays, 0)
    depths, scaled = Depths(segments.column(air.optics.extinction)), Depths(segments.column(field.scaled))
    return thermal_of(air.thermal, field, segments, depths), segments, depths, scaled


@pytest.mark.parametrize(("elevation", "of_side"), [(30.0, 1.0), (-30.0, 3.0)])
def test_light_scattered_straight_forward_is_that_at_the_far_ends(air, elevation, of_side):
    field, height = air.thermal.field, air.state.altitude[:, None, None] / 1000
    side = np.where(field.angles < np.pi / 2, 3.0, 1.0)[:, None]
    field = replace(field, source=np.zeros_like(field.source), straight=np.zeros_like(field.straight))
    field.straight[:] = (1 + height) * side
    found, segments, depths, scaled = along(air, field, 1310.0, elevation)
    left = np.exp(-scaled.per_segment) - np.exp(-depths.per_segment)
    wanted = depths.transmittance * left * (1 + segments.altitude[1:, None] / 1000) * of_side
    assert found == pytest.approx(wanted, rel=1e-6, abs=1e-12)
    assert np.max(wanted) > 1e-4


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
