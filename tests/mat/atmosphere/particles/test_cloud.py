"""Cloud and rain: published optical figures, closed forms, bounds in the extremes."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles import cloud, rain
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.cloud import CloudLayer, cloud_type
from skyshine.mat.atmosphere.particles.particles import HenyeyGreensteinModel
from skyshine.mat.atmosphere.particles.rain import RainLayer
from skyshine.mat.atmosphere.spectra.spectrum import line_spectrum
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.state import AerosolComponent, AtmosphericState
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.schemas.errors import InputError

EDGES = np.array([900.0, 905.0])
STRATUS = CloudLayer("water", 600.0, 1400.0, 8.0, 20.0)


def look(state, points, altitude, elevation, distance=np.inf, source=0.7, light=0.0):
    return line_spectrum(
        state,
        points,
        np.full(points.wavenumber.size, light),
        altitude=altitude,
        elevation=np.radians(elevation),
        distance=distance,
        source_elevation=source,
        source_azimuth=1.0,
    )


@pytest.fixture
def thin_air(synthetic_points):
    return synthetic_points(EDGES, {"CO2": np.array([1e-30, 1e-27])})


@pytest.fixture
def isothermal_cloud(isothermal):
    """Factory: an isothermal state with particles that absorb, scatter or both."""
    from dataclasses import replace

    def make(albedo, optical_depth=3.0, **settings):
        state = isothermal(280.0, clouds=[STRATUS], **settings)
        (component,) = state.hydrometeors
        wavelength = np.array([0.2, 1e3])
        model = HenyeyGreensteinModel("grey", wavelength, np.ones(2), np.full(2, 1 - albedo), np.full(2, 0.85))
        amount = component.extinction_550 * optical_depth / STRATUS.optical_depth
        return replace(state, hydrometeors=(AerosolComponent(model, amount),))

    return make


# Droplets of 10 um: extinction 3 Q / (4 rho r) with Q = 2.1; asymmetry 0.86 to 0.87 in the visible; extinction at 11 um
# 0.6 to 0.8 of the visible, less than half of it scattering (Hu and Stamnes 1993, J. Climate 6, 728).
def test_water_droplets():
    layer = CloudLayer.of_water_path("water", 500.0, 1000.0, 10.0, 0.1)
    assert layer.optical_depth == pytest.approx(0.75 * 2.1 * 0.1 / (997 * 10e-6), rel=0.01)
    assert layer.water_path == pytest.approx(0.1)
    optics = layer.model.optics(1e4 / np.array([0.55, 11.0]), np.array([50.0]))
    assert optics.extinction[0, 0] == pytest.approx(1.0) and 0.6 < optics.extinction[0, 1] < 0.8
    assert optics.single_scattering_albedo[0, 0] > 0.999998 and 0.4 < optics.single_scattering_albedo[0, 1] < 0.5
    assert optics.asymmetry[0, 0] == pytest.approx(0.862, abs=0.005)


def test_ice_crystals_scatter_sunlight_less_forward_than_spheres():
    layer = CloudLayer.of_water_path("ice", 9e3, 10e3, 30.0, 0.02)
    assert layer.optical_depth == pytest.approx(0.75 * 2.05 * 0.02 / (918 * 30e-6), rel=0.02)
    optics = layer.model.optics(1e4 / np.array([0.55, 3.0, 10.8, 12.0]), np.array([50.0]))
    assert optics.asymmetry[0, 0] == pytest.approx(0.76, abs=0.02)
    assert np.all(optics.asymmetry[0, 1:] > 0.85)
    # Split-window signature of cirrus (Inoue 1985): ice absorbs more at 12 than at 10.8 um.
    small = CloudLayer("ice", 9e3, 10e3, 10.0, 1.0).model.optics(1e4 / np.array([10.8, 12.0]), np.array([50.0]))
    absorption = small.extinction * (1 - small.single_scattering_albedo)
    assert absorption[0, 1] > 1.2 * absorption[0, 0]


@pytest.mark.parametrize(
    "layer", [cloud_type(name) for name in cloud.TYPES] + [CloudLayer("water", 0.0, 200.0, 5.0, 1e4)]
)
def test_the_layer_holds_its_optical_depth(layer):
    state = AtmosphericState.from_profile("midlatitude_summer", aerosol=Aerosol("none"), clouds=[layer])
    from skyshine.mat.atmosphere.transfer.geometry import Shells
    from skyshine.mat.atmosphere.transfer.layer_columns import vertical_column

    shells = Shells.of(state.altitude, state.number_density, 900.0)
    per_molecule = (state.hydrometeors[0].extinction_550 / state.number_density)[:, None]
    assert vertical_column(shells, per_molecule).sum() == pytest.approx(layer.optical_depth, rel=2e-3)
    assert np.all(state.hydrometeors[0].extinction_550[state.altitude > layer.top + 1] == 0)


@pytest.mark.parametrize(
    ("layer", "edge"),
    [
        (CloudLayer("water", 600.0, 1400.0, 8.0, 20.0), 10.0),  # 5 % of it would be 40 m
        (CloudLayer("ice", 9e3, 9.1e3, 30.0, 0.5), 5.0),
        (CloudLayer("water", 0.0, 60.0, 8.0, 3.0), 3.0),  # fog stands on the ground and has no lower edge
    ],
)
def test_a_cloud_is_even_between_its_edges_and_ends_there(layer, edge):
    """At its base and top a cloud begins and ends within 10 m or 5 % of its thickness, whichever is less, and its
    optical depth is the integral over height.
    """
    height = np.linspace(max(layer.base - 50.0, 0.0), layer.top + 50.0, 200001)
    extinction = layer.extinction_550(height)
    assert np.trapezoid(extinction, height) == pytest.approx(layer.optical_depth, rel=1e-5)
    low = layer.base + edge if layer.base > 0 else 0.0
    inside = (height >= low) & (height <= layer.top - edge)
    assert extinction[inside] == pytest.approx(extinction.max()) and extinction[inside].size > 1000
    assert np.all(extinction[(height < layer.base) | (height > layer.top)] == 0)
    assert layer.extinction_550(layer.top - edge / 2) == pytest.approx(extinction.max() / 2)
    if layer.base > 0:
        assert layer.extinction_550(layer.base + edge / 2) == pytest.approx(extinction.max() / 2)
    else:
        assert layer.extinction_550(0.0) == pytest.approx(extinction.max())
    assert {layer.base, layer.top, layer.top - edge} <= set(layer.edges)


# Extinction at 0.55 um [km^-1] of the manual of MODTRAN (Berk et al. 1989, GL-TR-89-0122), which took over these
# clouds.
@pytest.mark.parametrize(
    ("name", "extinction"),
    [
        ("cumulus", 92.6),
        ("altostratus", 128.1),
        ("stratus", 56.9),
        ("stratocumulus", 38.7),
        ("nimbostratus", 92.0),
        ("cirrus", 0.14),
    ],
)
def test_types_of_cloud(name, extinction):
    layer = cloud_type(name)
    assert 1e3 * layer.optical_depth / (layer.top - layer.base) == pytest.approx(extinction, rel=0.01)
    assert name in cloud.TYPES and set(cloud.cloud_types()) == set(cloud.TYPES)


# LOWTRAN7, FUNCTION TNRAIN: pi N0 / A^3 km^-1 with N0 = 8000, A = 41 R^-0.21; drops are large, so that Mie theory
# agrees within 3 %.
@pytest.mark.parametrize("rate", [0.1, 1.0, 12.5, 100.0])
def test_rain_extinction_of_lowtran7(rate):
    layer = RainLayer(rate, 2e3)
    expected = np.pi * 8000 / (41 * rate**-0.21) ** 3 * 1e-3
    assert layer.extinction_550(0.0) == pytest.approx(expected, rel=0.02)
    optics = layer.model.optics(1e4 / np.array([0.55, 4.0, 10.0]), np.array([50.0]))
    assert optics.extinction[0] == pytest.approx(1.0, rel=0.04)
    # Drops of millimetres are black in the infrared: half of the extinction is diffraction.
    assert (
        optics.single_scattering_albedo[0, 1:] == pytest.approx(0.52, abs=0.04)
        and optics.single_scattering_albedo[0, 0] > 0.999
    )


@pytest.mark.parametrize(
    ("altitude", "elevation"), [(300, 90), (300, 5), (1000, 20), (1000, 0), (1000, -90), (3000, -5), (3000, -90)]
)
def test_isothermal_air_with_black_cloud_glows_as_one_minus_transmittance(
    isothermal_cloud, thin_air, altitude, elevation
):
    state = isothermal_cloud(0.0)
    found = look(state, thin_air, altitude, elevation)
    expected = (1 - found.transmittance) * planck_wavenumber(902.5, 280.0)
    # Emission is at the middle of the interval; 1e-6 of the blackbody.
    assert found.path_thermal == pytest.approx(expected, abs=1e-6 * planck_wavenumber(902.5, 280.0))


@pytest.mark.parametrize("albedo", [0.5, 1.0])
def test_nothing_changes_inside_an_isothermal_enclosure(isothermal_cloud, synthetic_points, albedo):
    """Above, a wall of opaque gas; below, ground of the same temperature: whatever scatters, radiance is that of a
    black body.
    """
    points = synthetic_points(EDGES, {"H2O": np.array([1e-23, 1e-23])})
    state = isothermal_cloud(albedo, surface_temperature=280.0, surface_albedo=0.3)
    state.mole_fraction["H2O"] = np.where(state.altitude > 2e3, 1e-2, 0.0)
    blackbody = planck_wavenumber(902.5, 280.0)
    for altitude, elevation in ((100.0, 90.0), (1000.0, 30.0), (1000.0, 0.0)):
        found = look(state, points, altitude, elevation)
        assert found.path_thermal + 0 == pytest.approx(blackbody * (1 - found.transmittance), rel=2e-3)
    down = look(state, points, 1900.0, -90.0)
    # The path's own radiance and what the ground sends through it: emission and reflected sky.
    ground = (1 - 0.3) * blackbody + 0.3 * down.sky_irradiance / np.pi
    assert down.path_thermal + down.transmittance * ground == pytest.approx(blackbody, rel=1e-2)


@pytest.mark.parametrize(
    ("layer", "albedo"),
    [(CloudLayer("water", 600.0, 1400.0, 8.0, 1e4), 1.0), (CloudLayer("ice", 8e3, 9e3, 30.0, 1e4), 0.0)],
)
@pytest.mark.validation  # 7 and 11 s; opaque haze: test_extreme_paths.py
def test_a_cloud_of_optical_depth_ten_thousand(thin_air, layer, albedo):
    state = AtmosphericState.from_profile(
        "midlatitude_summer",
        clouds=[layer],
        rain=RainLayer(100.0, 600.0),
        aerosol=Aerosol(visibility_km=0.1),
        surface_albedo=albedo,
    )
    inside = 0.5 * (layer.base + layer.top)
    warmest = planck_wavenumber(902.5, state.temperature.max())
    for altitude, elevation in ((0.0, 90.0), (inside, 0.0), (12e3, -60.0)):
        found = look(state, thin_air, altitude, elevation, light=1.0)
        for values in (
            found.transmittance,
            found.path_thermal,
            found.path_scattered,
            found.sky_irradiance,
            found.direct_irradiance,
        ):
            assert np.all(np.isfinite(values)) and np.all(values >= 0)
        assert np.all(found.path_thermal <= warmest * 1.001)
    # From far above, the temperature of the cloud's top, or of the haze over it; inside, that of the place.
    above = look(state, thin_air, 12e3, -90.0).path_thermal[0]
    coldest, warmest = (planck_wavenumber(902.5, float(state.temperature_at(layer.top + dz))) for dz in (3e3, 0.0))
    assert coldest < above < warmest
    within = look(state, thin_air, inside, 0.0).path_thermal[0]
    assert within == pytest.approx(planck_wavenumber(902.5, float(state.temperature_at(inside))), rel=0.01)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: CloudLayer("watr", 0.0, 1e3, 10.0, 1.0), "did you mean 'water'"),
        (lambda: CloudLayer("water", 1e3, 900.0, 10.0, 1.0), "give a base of at least 0 and a top"),
        (lambda: CloudLayer("water", 0.0, 1e3, 50.0, 1.0), "effective radius 50 um of water is outside 2 to 30"),
        (lambda: CloudLayer("ice", 0.0, 1e3, 50.0, float("nan")), "optical depth nan"),
        (lambda: cloud_type("stratos"), "did you mean 'stratus'"),
        (lambda: RainLayer(0.0, 1e3), "rain rate 0 mm/h is outside"),
        (lambda: RainLayer(5.0, 1.0), "is outside 0.02 to 15 km"),
    ],
)
def test_bad_layers_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_droplets_do_not_freeze_and_crystals_do_not_melt():
    for profile, layer, message in (
        ("midlatitude_summer", CloudLayer("ice", 0.0, 1e3, 30.0, 1.0), "melts above 273.15 K"),
        ("midlatitude_summer", CloudLayer("water", 11e3, 12e3, 10.0, 1.0), "is frozen below 233.15 K"),
    ):
        with pytest.raises(InputError, match=message):
            AtmosphericState.from_profile(profile, clouds=[layer])


def test_air_in_water_cloud_is_saturated():
    state = AtmosphericState.from_profile("midlatitude_winter", clouds=[STRATUS])
    inside = (state.altitude > STRATUS.base + 11) & (state.altitude < STRATUS.top - 11)
    assert state.relative_humidity[inside] == pytest.approx(100.0) and np.all(state.relative_humidity[~inside][:2] < 99)
    dry = AtmosphericState.from_profile(
        "midlatitude_winter", clouds=[STRATUS], gas_amounts=GasAmounts(water_column=3.0)
    )
    assert dry.precipitable_water(0.0) == pytest.approx(3.0, rel=1e-9)


def test_rain_falls_below_its_top_only():
    layer = rain.RainLayer(10.0, 1500.0)
    assert layer.extinction_550(np.array([0.0, 1489.0])) == pytest.approx(layer.extinction_550(500.0))
    assert np.all(layer.extinction_550(np.array([1500.0, 5e3])) == 0)


@pytest.mark.parametrize("asymmetry", [0.0, 0.85, 0.95, 0.987, 0.999])
def test_narrow_forward_peaks_lose_no_light(asymmetry):
    from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES, normalised

    cosine = np.cos(PHASE_ANGLES)
    exact = (1 - asymmetry**2) / (1 + asymmetry**2 - 2 * asymmetry * cosine) ** 1.5
    phase = normalised(exact)
    fine = np.linspace(0, np.pi, 200 * 360 + 1)
    mean = 0.5 * np.trapezoid(np.interp(fine, PHASE_ANGLES, phase) * np.sin(fine), fine)
    assert mean == pytest.approx(1.0, abs=1e-4) and np.all(phase >= 0) and np.argmax(phase) == 0
    if asymmetry < 0.95:
        assert phase[1:] == pytest.approx(exact[1:], rel=1e-3)
