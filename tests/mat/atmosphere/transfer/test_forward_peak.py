"""Repeated scattering in the forward peak: closed forms of small angles, energy, limits of depth, bands."""

import numpy as np
import pytest
from light_parts import scattered_once, without_peak
from numpy.polynomial.legendre import legvander
from numpy_light import peak_change, peak_depth

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.particles.moments import moment_weights
from skyshine.mat.atmosphere.transfer import forward_peak, geometry
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.source_paths import SourcePaths

EDGES = np.array([15380.0, 15390.0])  # 0.65 um
NEAR = np.radians([0.0, 1.0, 2.5, 8.0])


@pytest.fixture(scope="module")
def air(synthetic_points, isothermal):
    def make(sections=(0.0,), **settings):
        settings = {"aerosol": Aerosol("none"), **settings}
        return SpectralAir.of(isothermal(**settings), synthetic_points(EDGES, {"CO2": list(sections)}))

    return make


@pytest.fixture(scope="module")
def fog(air):
    return air(aerosol=Aerosol("fog_radiation"))


@pytest.fixture(scope="module")
def cloud(air):
    return air(clouds=[CloudLayer("water", 1e3, 2e3, 10.0, 3.0)])


def path(air, altitude, elevation, source, azimuth):
    rays = geometry.trace(air.shells, np.array([altitude]), np.array([elevation]))
    segments = Segments.of(rays, 0)
    ends = segments.ends
    sources = np.broadcast_to(source, np.shape(azimuth)), np.asarray(azimuth)
    angles = [f(rays, *sources)[0, ends] for f in (geometry.source_cosine, geometry.scattering_cosine)]
    return segments, Depths(segments.column(air.optics.extinction)), *angles


def peak_of(air):
    """Moments over the fraction, as far as the angles resolve them, of the lowest level, and the fraction."""
    fraction = air.delta_fraction[0, 0]
    moments = moment_weights(PHASE_ANGLES, PHASE_ANGLES.size) @ air.optics.phase[:, 0, 0] / fraction
    moments[: 2 * air.nodes] = 1.0
    return moments, fraction


@pytest.mark.parametrize("depth", [0.1, 1.0, 10.0])
def test_orders_of_a_peak_are_convolutions_by_the_law_of_poisson(fog, depth):
    """The sum over orders, term by term, of a peak that the moments resolve."""
    moments, _ = peak_of(fog)
    share, orders = np.exp(-depth), np.zeros_like(moments)
    for order in range(1, 80):
        share *= depth / order
        orders += share * moments**order
    degrees = forward_peak._DEGREES[:13]
    legendre = legvander(np.cos(np.radians(degrees)), moments.size - 1) * (2 * np.arange(moments.size) + 1)
    expected = legendre @ (orders / depth - moments)
    found = np.array([np.interp(depth, forward_peak._DEPTHS, row) for row in fog.forward_peak.table[0, 0, :13]])
    # Against the light at 0: the angles of the phase function are half a degree apart.
    assert found == pytest.approx(expected, abs=1e-2 * legendre[0] @ moments)


def test_the_peak_keeps_the_light_that_it_scattered(fog):
    """Over the solid angle of the peak, the change is the difference of light scattered at all, and once per depth."""
    degrees, table = forward_peak._DEGREES, fog.forward_peak.table[0, 0].astype(float)
    fine = np.radians(np.linspace(0, 24, 4801))
    values = np.array([np.interp(np.degrees(fine), degrees, column) for column in table.T])
    change = 0.5 * np.trapezoid(values * np.sin(fine), fine, axis=1)
    for depth in (0.1, 1.0, 3.0):
        found = np.interp(depth, forward_peak._DEPTHS, change)
        assert found == pytest.approx(-np.expm1(-depth) / depth - 1, abs=0.04)


def test_light_in_a_core_goes_straight_on():
    """A peak that is all core stays itself: no wide light, and its own share is that of light scattered at all."""
    phase = np.zeros((PHASE_ANGLES.size, 1))
    phase[0] = 1e5
    without, core = forward_peak._without_core(phase)
    assert without.max() == 0 and core == pytest.approx(1e5 * moment_weights(PHASE_ANGLES, 1)[0, 0])
    assert forward_peak._orders(np.ones(())) == pytest.approx(-np.expm1(-forward_peak._DEPTHS) / forward_peak._DEPTHS)
    assert forward_peak._orders(np.zeros(())) == pytest.approx(np.exp(-forward_peak._DEPTHS))
    step = 1e-5
    slope = (forward_peak._orders(np.array(0.5 + step)) - forward_peak._orders(np.array(0.5 - step))) / (2 * step)
    assert forward_peak._rise(np.array(0.5)) == pytest.approx(slope, rel=1e-6)


def test_smooth_peaks_have_no_core_and_diffraction_by_drops_does(air, fog):
    from skyshine.mat.atmosphere.particles.rain import RainLayer

    assert forward_peak._without_core(fog.optics.phase)[1].max() < 1e-6
    rain = air(rain=RainLayer(10.0, 3e3))
    assert forward_peak._without_core(rain.optics.phase)[1].max() == pytest.approx(0.5, abs=0.05)


def test_thin_air_and_air_without_particles_change_nothing(air):
    for clear in (air(), air(clouds=[CloudLayer("water", 1e3, 2e3, 10.0, 1e-4)])):
        segments, depths, to_source, deflection = path(clear, 0.0, 0.5, 0.5, np.zeros(1))
        light = clear.scattered_light.along(segments, depths, to_source, deflection)
        assert np.all(light > 0)
        assert np.array_equal(light, without_peak(clear).along(segments, depths, to_source, deflection))


def test_sources_far_from_the_line_are_left_as_they_are(fog):
    line = path(fog, 0.0, 0.5, 0.5, np.radians([0.0, 20.0, 60.0, 180.0]))
    light, plain = (part.along(*line)[0, :, 0] for part in (fog.scattered_light, without_peak(fog)))
    assert np.flatnonzero(light != plain).tolist() == [0, 1]
    table = fog.forward_peak.table
    assert np.all(np.isfinite(table)) and np.all(table[:, :, -1] == 0) and np.any(table[:, :, 0] < 0)


def test_the_correction_begins_without_a_step_where_there_is_enough_of_the_peak(air):
    """Light of a cloud that gets thicker, over its depth, near a source at the zenith: below 0.25 %, then smoothly."""
    light = []
    for depth in (4e-3, 0.02, 0.03, 0.04, 0.06, 0.1):
        thin = air(clouds=[CloudLayer("water", 1e3, 2e3, 10.0, depth)])
        line = path(thin, 0.0, 1.5, [1.5], [0.02])
        whole, plain = (part.along(*line)[0, 0, 0] for part in (thin.scattered_light, without_peak(thin)))
        light.append(whole / plain)
    assert light[0] == 1.0 and light[-1] < 0.99
    assert np.all(np.diff(light) <= 0) and np.all(np.diff(light) > -0.015)


def test_a_few_points_are_enough_for_the_peak_of_a_wide_band(isothermal, monkeypatch):
    table = AbsorptionTable.open().points(2000.0, 3300.0)
    points, lights, few = table.subset(np.arange(0, table.weight.size, 40)), [], []
    for step in (forward_peak._STEP, 1.0005):
        monkeypatch.setattr(forward_peak, "_STEP", step)
        foggy = SpectralAir.of(isothermal(aerosol=Aerosol("fog_radiation")), points)
        line = path(foggy, 0.0, 0.6, 0.6, NEAR)
        clear = np.zeros_like(foggy.optics.extinction)  # nothing is lost on the way
        paths = SourcePaths.of(foggy.source_rays, clear)
        changed, plain = (
            scattered_once(foggy, paths=paths, scaled=clear, peak=peak).along(*line)[0]
            for peak in (foggy.forward_peak, None)
        )
        lights.append(changed / plain.max(axis=0))
        few.append(foggy.forward_peak.few.size)
        assert np.abs(changed / plain - 1).max() > 0.05
    assert few[0] < 32 and few[1] > 80
    assert np.abs(lights[0] - lights[1]).max() < 5e-3


@pytest.mark.parametrize(("altitude", "optical_depth"), [(1.5e3, 1e-2), (0.0, 1e4), (1.5e3, 1e4), (1.2e4, 1e4)])
def test_light_is_finite_and_not_negative_in_any_depth(air, altitude, optical_depth):
    thick = air((0.0, 1e-26), clouds=[CloudLayer("water", 1e3, 2e3, 10.0, optical_depth)])
    for elevation, source in ((0.6, 0.6), (-0.02, -0.02), (-0.6, -0.6)):  # the last two: the Earth hides the source
        segments, depths, to_source, deflection = path(thick, altitude, elevation, source, NEAR)
        if not segments.index.size:
            continue
        light = thick.scattered_light.along(segments, depths, to_source, deflection)[0]
        along = thick.scattered_light.in_band(segments, depths, to_source, deflection, np.ones(2))
        assert np.all(np.isfinite(light)) and np.all(light >= 0)
        assert np.all(np.isfinite(along)) and np.all(np.diff(along, axis=0) >= 0)


def test_the_band_and_its_points_agree_up_to_each_range(cloud):
    segments, depths, to_source, deflection = path(cloud, 0.0, 0.6, 0.6, NEAR)
    along = cloud.scattered_light.in_band(segments, depths, to_source, deflection, np.ones(1))
    for count in (3, segments.index.size // 2, segments.index.size):
        near, ends = segments.first(count), slice(None, count + 1)
        part = Depths(near.column(cloud.optics.extinction))
        light = cloud.scattered_light.along(near, part, to_source[ends], deflection[ends])[0][:, 0]
        assert along[count] == pytest.approx(light, rel=3e-3, abs=1e-9)


def test_the_deeper_the_fog_the_more_of_its_peak_is_spread(air):
    """The light next to the source falls below that of first order, further the deeper the fog."""
    changes = []
    for visibility in (5.0, 0.5, 0.1):
        foggy = air(aerosol=Aerosol("fog_radiation", visibility_km=visibility))
        line = path(foggy, 0.0, 1.2, 1.2, NEAR[:1])
        light, plain = (scattered_once(foggy, peak=peak).along(*line)[0, 0, 0] for peak in (foggy.forward_peak, None))
        changes.append(light / plain - 1)
    assert 0 > changes[0] > changes[1] > changes[2]


def test_depth_of_the_peak_is_that_from_the_source_by_the_place_to_the_observer(fog):
    """Towards a source at the zenith both parts are the whole column, wherever the place, and the change is that of
    the table at this depth.
    """
    segments, depths, *angles = path(fog, 0.0, np.pi / 2, [np.pi / 2], [0.0])
    whole = segments.column(fog.optics.aerosol_scattering * fog.delta_fraction).sum(axis=0)
    assert whole.min() > 0.1
    seen = peak_depth(fog.forward_peak, segments, depths, angles[0])
    assert seen == pytest.approx(np.broadcast_to(whole, seen.shape), rel=0.02)
    near = np.ones((segments.index.size, 1), bool)
    change = peak_change(fog.forward_peak, segments, depths, *angles, near)[0, 0, 0]
    table = np.interp(whole[0], forward_peak._DEPTHS, fog.forward_peak.table[0, 0, 0])
    assert change == pytest.approx(table * segments.column(fog.forward_peak.scattering)[0, 0], rel=0.02)


def test_a_peak_as_wide_as_that_of_droplets_at_four_microns_is_followed_to_twenty_degrees(
    synthetic_points, isothermal, monkeypatch
):
    state = isothermal(aerosol=Aerosol("none"), clouds=[CloudLayer("water", 1e3, 2e3, 10.0, 3.0)])
    air = SpectralAir.of(state, synthetic_points(np.array([2597.0, 2598.0]), {"CO2": [0.0]}))
    at, deep = (forward_peak._DEGREES == 18).nonzero()[0][0], np.searchsorted(forward_peak._DEPTHS, 1.0)
    found = air.forward_peak.table[0, :, at, deep]
    monkeypatch.setattr(forward_peak, "_taper", np.ones_like)
    whole = SpectralAir.of(state, synthetic_points(np.array([2597.0, 2598.0]), {"CO2": [0.0]})).forward_peak.table
    assert found == pytest.approx(whole[0, :, at, deep], rel=1e-6)
    once = air.optics.phase[2 * 18, :, 0] / air.delta_fraction[:, 0]
    assert np.abs(found / once).max() > 0.02
