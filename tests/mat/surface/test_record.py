"""The forcing of a record: radiation on its plane, humidity, steps."""

import numpy as np
import pytest

from skyshine.mat.surface.column import from_record
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.record import Record, record_forcing, sky_longwave, standard_pressure
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack
from skyshine.schemas.errors import InputError

SIGMA = 5.670374419e-8


def record(**changes):
    values = {
        "sw_down": np.zeros(4),
        "lw_down": np.full(4, SIGMA * 285.0**4),
        "air_temperature": np.full(4, 285.0),
        "relative_humidity": np.full(4, 60.0),
        "wind_speed": np.full(4, 2.0),
        "pressure": np.full(4, 9e4),
    }
    return Record.of(3600.0 * np.arange(4), values | changes)


@pytest.mark.parametrize("slope, view", [(0.0, 1.0), (60.0, 0.75), (90.0, 0.5), (180.0, 0.0)])
def test_a_plane_sees_sky_and_ground_by_its_slope(slope, view):
    """Both at 285 K: (1 + cos slope) / 2 of sigma T^4 from the sky, the rest from the ground, always the whole."""
    light = (np.zeros(4), np.zeros(4), np.zeros(4))
    forcing = record_forcing(record(), light, slope)
    assert forcing.longwave_sky == pytest.approx(view * SIGMA * 285.0**4)
    assert forcing.longwave_sky + forcing.longwave_ground == pytest.approx(SIGMA * 285.0**4)
    assert forcing.cos_slope[0, 0] == pytest.approx(2 * view - 1)


def test_humidity_is_that_over_water():
    """60 % at 11.85 C: 0.6 x 1388 Pa (IAPWS)."""
    light = (np.zeros(4), np.zeros(4), np.zeros(4))
    assert record_forcing(record(), light, 0.0).vapour_pressure == pytest.approx(0.6 * 1388.0, rel=3e-3)


def test_rain_is_by_the_second():
    """18 mm/h are 0.005 kg m^-2 s^-1."""
    light = (np.zeros(4), np.zeros(4), np.zeros(4))
    assert record_forcing(record(rain=np.full(4, 18.0)), light, 0.0).rain == pytest.approx(0.005)


def test_light_goes_to_its_own_parts():
    direct, diffuse, reflected = np.full(4, 3.0), np.full(4, 2.0), np.full(4, 1.0)
    forcing = record_forcing(record(), (direct, diffuse, reflected), 30.0)
    assert (forcing.shortwave_direct[0, 0], forcing.shortwave_diffuse[0, 0]) == (3.0, 2.0)
    assert forcing.shortwave_reflected[0, 0] == 1.0


def test_offsets_at_night_and_supersaturation_are_cut():
    given = record(sw_down=np.array([-4.0, 10.0, 500.0, 0.0]), relative_humidity=np.array([50.0, 103.0, 100.0, 99.0]))
    assert list(given.values["sw_down"]) == [0.0, 10.0, 500.0, 0.0]
    assert list(given.values["relative_humidity"]) == [50.0, 100.0, 100.0, 99.0]


def test_a_refined_record_keeps_its_readings_and_its_period():
    given = record(sw_down=np.array([0.0, 100.0, 300.0, 100.0]))
    fine = given.refined(4)
    assert fine.period == given.period == 4 * 3600.0 and fine.steps == 16
    assert fine.values["sw_down"][::4] == pytest.approx(given.values["sw_down"])
    assert fine.values["sw_down"][[2, 6, 14]] == pytest.approx([50.0, 200.0, 50.0])
    assert np.all(np.diff(fine.times) == np.timedelta64(900_000, "ms"))


@pytest.mark.parametrize(
    "kelvin, vapour, emissivity", [(293.15, 1400.0, 0.80492), (273.15, 300.0, 0.71071), (303.15, 3000.0, 0.88358)]
)
def test_longwave_of_a_clear_sky_is_prata_s(kelvin, vapour, emissivity):
    """1 - (1 + w) exp(-sqrt(1.2 + 3 w)) with w = 46.5 e / T, e in hPa, by hand; under full cloud 0.84 + 0.16 of it."""
    air, pressure = np.array([kelvin]), np.array([vapour])
    black = SIGMA * kelvin**4
    assert sky_longwave(air, pressure, np.zeros(1)) == pytest.approx(emissivity * black, rel=5e-4)
    assert sky_longwave(air, pressure, np.ones(1)) == pytest.approx((0.84 + 0.16 * emissivity) * black, rel=5e-4)


def test_what_was_not_measured_is_said():
    """ISO 2533: 794.95 hPa at 2000 m."""
    values = record().values
    bare = {name: values[name] for name in ("sw_down", "air_temperature", "relative_humidity", "wind_speed")}
    found = Record.of(3600.0 * np.arange(4), bare, 2000.0)
    assert found.values["pressure"] == pytest.approx(79495.0, rel=1e-4)
    assert np.all(found.values["lw_down"] > 200)
    assert found.notes == (
        "no pressure: 795 hPa is taken, that of ISO 2533 at 2000 m",
        "no lw_down: that of the air near the ground under a clear sky is taken (Prata 1996)",
    )
    cloudy = Record.of(3600.0 * np.arange(4), bare | {"cloud_fraction": np.full(4, 0.5)})
    assert np.all(cloudy.values["lw_down"] > found.values["lw_down"]) and "cloud_fraction" not in cloudy.values
    assert "under its cloud_fraction" in cloudy.notes[1]
    assert record().notes == () and found.refined(2).notes == found.notes


def test_pressure_that_a_record_lacks_is_that_of_iso_2533_or_is_asked_for():
    """Tables of ISO 2533 by geopotential altitude [hPa]: 0.25 % of gravity between it and a height of 20 km stays."""
    for kilometres, hectopascal in ((0, 1013.25), (5, 540.20), (11, 226.32), (15, 120.45), (20, 54.75)):
        assert standard_pressure(1e3 * kilometres) == pytest.approx(100 * hectopascal, rel=1e-3)
    with pytest.raises(InputError, match="found no pressure at 50 km; allowed: without it to 20 km"):
        standard_pressure(50e3)


def test_sunlit_surface_without_air_radiates_what_it_absorbs():
    """A perfect insulator in steady light under space: (a S / e sigma)^(1/4)."""
    seconds = 3600.0 * np.arange(24)
    values = {"sw_down": 1000.0, "lw_down": 20.0, "air_temperature": 300.0, "relative_humidity": 0.0}
    values |= {"wind_speed": 5.0, "pressure": 0.0}
    record = Record.of(seconds, {name: np.full(24, value) for name, value in values.items()})
    stack = ThermalStack(Layer(1e-3, 1.0, 1000.0, 1000.0), (Layer(0.1, 1.0, 1.0, 1000.0),) * 2, Back("adiabatic"))
    surface = SurfaceProperties(0.01, 1.0, 0.0, False, False)
    material = SurfaceMaterial("plate", stack, surface, 0.5, 0.9)
    column = from_record(material, record, 0.0, 0.0, None, 0.2)
    expected = ((0.5 * 1000 + 0.9 * 20) / (0.9 * 5.670374e-8)) ** 0.25
    np.testing.assert_allclose(column.temperature, expected, atol=0.02)
