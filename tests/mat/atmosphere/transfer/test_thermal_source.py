"""The thermal source function of air with particles: equilibrium, bounds, limits."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.transfer import geometry, thermal_source
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
    assert np.array_equal(clear.thermal.mean, clear.optics.emission)
    assert np.all(clear.thermal.tilt == 0)


def test_nothing_is_brighter_than_the_enclosure(air):
    black = planck_wavenumber(902.5, 280.0)
    rising, falling = air.thermal.mean + air.thermal.tilt, air.thermal.mean - air.thermal.tilt
    for source in (rising, falling):
        assert np.all(np.isfinite(source)) and np.all(source >= 0)
        assert np.all(source <= black * (1 + 1e-9))
    assert np.all(rising >= falling - 1e-12 * black)  # space is dark


def test_deep_inside_opaque_air_the_source_is_the_black_body(air):
    black = planck_wavenumber(902.5, 280.0)
    assert air.thermal.mean[:30, -1] == pytest.approx(np.full(30, black), rel=1e-6)
    assert np.abs(air.thermal.tilt[:30, -1]).max() < 1e-6 * black


def test_layers_keep_their_energy(air):
    reflection, transmission, upward, downward = thermal_source._layers(air.shells, air.optics)
    assert np.all((reflection >= 0) & (transmission >= 0) & (reflection + transmission <= 1 + 1e-12))
    # In equilibrium a layer of one temperature emits what it absorbs (Kirchhoff).
    emitted = np.pi * planck_wavenumber(902.5, 280.0) * (1 - reflection - transmission)
    for side in (upward, downward):
        assert side == pytest.approx(emitted, rel=1e-6, abs=1e-12)


def test_thin_layers_meet_the_closed_form_without_a_seam(synthetic_points, isothermal):
    state = isothermal(280.0, aerosol=Aerosol("rural"))
    state = replace(state, temperature=np.linspace(290.0, 210.0, state.altitude.size))
    air = SpectralAir.of(state, synthetic_points(EDGES, {"CO2": np.geomspace(1e-30, 1e-20, 400)}))
    for flux in thermal_source._fluxes(state, air.shells, air.optics):
        near_ground = flux[1]
        step = np.abs(np.diff(np.log(near_ground)))
        assert step.max() < 0.1  # absorption grows by 6 % from one to the next
        assert np.all(np.isfinite(near_ground))


def test_particles_dim_the_sky_little_and_path_radiance_stays_below_the_black_body(air):
    black = planck_wavenumber(902.5, 280.0)
    rays = geometry.trace(air.shells, np.array([0.0, 0.0, 5e3]), np.radians([90.0, 3.0, -80.0]))
    for row in range(3):
        segments = Segments.of(rays, row)
        depth = segments.column(air.optics.extinction)
        radiance = air.thermal_radiance(segments, Depths(depth)).sum(axis=0)
        assert np.all(radiance <= -np.expm1(-depth.sum(axis=0)) * black * (1 + 1e-9))
        assert np.all(radiance > 0)


@pytest.mark.parametrize("cosine", [-1.0, -0.5, 0.0, 0.3, 1.0])
def test_tilt_weight_is_odd_and_bounded(cosine):
    assert thermal_source.tilt_weight(cosine) == -thermal_source.tilt_weight(-cosine)
    assert abs(thermal_source.tilt_weight(cosine)) <= 1
