"""Bulk theory over the sea against published results of COARE 3.5, and its limits."""

import numpy as np
import pytest

from skyshine.mat.surface.sea_surface import sea_surface, specific_humidity
from skyshine.mat.surface.similarity import heat_profile, momentum_profile
from skyshine.mat.surface.vapour import saturation_pressure

# Input and output of NOAA PSL's COARE 3.5 (repository NOAA-PSL/COARE-algorithm, Python/COARE3.5, test_35_data.txt and
# test_35_output_py_082020.txt, MIT licence), rows with the wind between the least and the strongest; the last three of
# pyCOARE/coare, tests/data/c35_test_expected.csv, those without waves. Wind m/s, air C, humidity %, pressure hPa, water
# with its cool skin taken off C, height m, depth m; u* m/s, T* K, q* kg/kg, L m.
CASES = [
    ((0.5, 27.1, 81.4, 1008, 29.38974949, 16, 600), (0.0354996, -0.12659583, -0.00041414, -0.47776008)),
    ((1.6, 28.1, 76.36, 1008, 29.05548186, 16, 600), (0.06160827, -0.03829582, -0.0003159, -3.03362834)),
    ((2.5, 28.2, 75.92, 1008, 28.87820329, 16, 600), (0.08552319, -0.02298341, -0.00027907, -7.58477315)),
    ((3.9, 27.5, 70.1, 1008, 28.74598915, 16, 600), (0.12785553, -0.04641949, -0.00035065, -11.34586864)),
    ((5.8, 26.7, 78.85, 1008, 29.01120805, 16, 600), (0.19212233, -0.08537175, -0.00029397, -20.33275306)),
    ((9.9, 24.7, 90.3, 1008, 28.97597298, 16, 600), (0.36540665, -0.13140943, -0.00022548, -58.97488178)),
    ((3.0, 5, 70, 1008, 4.99598156, 9, 500), (0.09295378, 0.00352896, -5.8191669e-05, -96.81088405)),
    ((4.0, 10, 75, 1010, 9.98198273, 10, 600), (0.12181260, 0.00434812, -6.5638919e-05, -153.5629227)),
    ((5.0, 15, 80, 1012, 14.9702252, 11, 700), (0.15272945, 0.00506841, -6.9851013e-05, -237.9948614)),
]


def surface(wind, air, humidity, pressure, water, height, depth=600.0):
    vapour = humidity / 100 * float(saturation_pressure(air + 273.15))
    return sea_surface(
        water + 273.15,
        air + 273.15,
        specific_humidity(vapour, 100.0 * pressure),
        wind,
        100.0 * pressure,
        wind_height=height,
        air_height=height,
        layer_depth=depth,
    )


@pytest.mark.parametrize(("conditions", "scales"), CASES)
def test_scales_are_those_of_coare(conditions, scales):
    sea = surface(*conditions)
    ours = (sea.friction_velocity, sea.temperature_scale, sea.humidity_scale, 1 / sea.inverse_length)
    for value, published, tolerance in zip(ours, scales, (0.01, 0.015, 0.01, 0.03), strict=True):
        assert value == pytest.approx(published, rel=tolerance)


def test_drag_rises_with_wind_as_measured():
    """Edson et al. 2013, figure 6: the neutral drag coefficient is near 1.1e-3 at 7 and 2.2e-3 at 20 m/s."""
    for wind, published in ((7.0, 1.1e-3), (20.0, 2.2e-3)):
        assert (surface(wind, 15, 80, 1013, 15, 10).friction_velocity / wind) ** 2 == pytest.approx(published, rel=0.12)


def test_profiles_lead_from_the_water_to_the_measurement():
    for water, air, wind in ((18, 15, 7), (15, 18, 7), (15, 15, 1), (25, 5, 3), (5, 25, 3)):
        sea = surface(wind, air, 80, 1013, water, 10)
        temperature, humidity = sea.air([sea.heat_roughness, 10.0])
        assert temperature == pytest.approx([water + 273.15, air + 273.15], abs=0.01)
        assert humidity[0] == pytest.approx(0.98 * 0.622 * saturation_pressure(water + 273.15) / 101300, rel=0.02)
        vapour = 0.8 * float(saturation_pressure(air + 273.15))
        assert humidity[1] == pytest.approx(specific_humidity(vapour, 101300.0), rel=1e-3)
        assert sea.wind_at(10.0) == pytest.approx(wind, rel=1e-3)


def test_functions_of_stability_have_their_published_slopes():
    """1 + 5 z/L in slightly stable air (Dyer 1974), 1 - 15/4 and 1 - 15/2 z/L in slightly unstable (Kansas)."""
    step = 1e-4
    assert [float(psi(step)) / step for psi in (momentum_profile, heat_profile)] == pytest.approx(
        [-5.2, -5.0], rel=1e-2
    )
    slopes = [float(psi(-step)) / -step for psi in (momentum_profile, heat_profile)]
    assert slopes == pytest.approx([-15 / 4, -15 / 2], rel=1e-2)
    zeta = np.array([-1e-9, 1e-9])
    assert momentum_profile(zeta) == pytest.approx([0, 0], abs=1e-7)
    assert heat_profile(zeta) == pytest.approx([0, 0], abs=1e-7)


def test_any_weather_gives_finite_scales_and_bounded_air():
    generator = np.random.default_rng(3)
    for _ in range(300):
        water, air = generator.uniform(270.15, 315.15), generator.uniform(240, 320)
        wind, height = generator.choice([0.0, 0.1, 1.0, 8.0, 60.0]), generator.choice([0.1, 2.0, 10.0, 200.0])
        air_height = generator.choice([2.0, 10.0])
        sea = sea_surface(water, air, generator.uniform(0, 0.03), wind, 1e5, wind_height=height, air_height=air_height)
        # Profiles are for heights up to the Obukhov length, or where the air is known.
        highest = max(min(50.0, 1 / sea.inverse_length if sea.inverse_length > 0 else 50.0), air_height)
        temperature, humidity = sea.air(np.geomspace(1e-6, highest, 9))
        assert np.all(np.isfinite([*temperature, *humidity, sea.inverse_length])) and sea.friction_velocity > 0
        beyond = 2 + 0.6 * abs(water - air)
        assert np.all(np.abs(temperature - 0.5 * (water + air)) < 0.5 * abs(water - air) + beyond)
        assert np.all((humidity >= 0) & (humidity < 0.15))
