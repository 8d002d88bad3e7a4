"""The five-axis table: what is copied, what is solved, what it says of itself."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.surface import table as module
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.solver import TOLERANCE
from skyshine.mat.surface.table import rounded, temperature_table
from skyshine.mat.surface.weather import from_hours
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack
from skyshine.schemas.errors import InputError

SOIL = Layer(0.2, 0.8, 1600.0, 1200.0)
STACK = ThermalStack(Layer(2e-3, 0.8, 1600.0, 1200.0), (SOIL, SOIL), Back("fixed"))
DRY = SurfaceProperties(0.005, 0.0, 0.0, False, False)
HOURS = np.arange(0, 24, 3.0)


def soil(name="soil", absorptance=0.8):
    return SurfaceMaterial(name, STACK, DRY, absorptance, 0.95)


@pytest.fixture(scope="module")
def table(sun_path, weather, sky):
    materials = [soil(), soil("pale", 0.4), soil("twin")]
    return temperature_table(
        materials, sun_path, weather, sky, [0.0, 1500.0], [0.0, 90.0, 180.0, 270.0], [0, 45, 180], HOURS
    )


def test_every_column_is_solved_and_says_how(table):
    assert table.temperature.shape == (3, 2, 4, 3, 8)
    assert np.all((table.temperature > 250) & (table.temperature < 345))
    assert table.residual.shape == (3, 2, 4, 3)
    assert np.all(table.residual <= TOLERANCE) and np.all(np.abs(table.energy_closure) <= TOLERANCE)
    assert np.all(table.bound_excess <= 0.1)
    assert np.all(table.iterations >= 1)
    assert table.method_names.startswith("0 spectral, 1 spectral_newton")


def test_level_surfaces_face_no_azimuth(table):
    for slope in (0, 2):
        assert np.all(table.temperature[:, :, :1, slope] == table.temperature[:, :, :, slope])


def test_twins_are_equal_and_darker_is_warmer(table):
    assert np.array_equal(table.temperature[0], table.temperature[2])
    assert np.all(table.temperature[0, :, :, :2] > table.temperature[1, :, :, :2] - 1e-3)
    assert np.all(table.temperature[0, 0, 0, 0, 4] > table.temperature[1, 0, 0, 0, 4] + 5)


def test_slopes_follow_the_sun(table):
    """North of the tropics: the east face leads in the morning, the west face in the afternoon, south beats north."""
    north, east, south, west = table.temperature[0, 0, :, 1]
    assert east[3] > west[3] + 10 and west[5] > east[5] + 5
    assert south[4] > north[4] + 5


def test_time_is_periodic_and_smooth_between_solver_times(sun_path, weather, sky):
    """A quarter of an hour after noon lies 1e-3 K above the line between the solver's times, as in finer steps."""
    axes = [soil()], sun_path, weather, sky, [0.0], [0.0], [0.0], [0.0, 24.0, 12.0, 12.125, 12.25]
    coarse, fine = (temperature_table(*axes, steps=steps).temperature[0, 0, 0, 0] for steps in (96, 576))
    assert coarse[0] == coarse[1]
    bends = [values[3] - 0.5 * (values[2] + values[4]) for values in (coarse, fine)]
    assert bends[0] == pytest.approx(bends[1], abs=1e-3) and bends[1] > 1e-3


def test_more_steps_change_little(sun_path, weather, sky):
    axes = ([0.0], [90.0], [0.0, 90.0], HOURS)
    coarse, fine = (
        temperature_table([soil()], sun_path, weather, sky, *axes, steps=steps).temperature for steps in (96, 288)
    )
    assert np.abs(coarse - fine).max() < 0.3


@pytest.mark.parametrize(
    "change, message",
    [
        ({"slopes": [200.0]}, "the slope axis: found .200.0.; allowed"),
        ({"times": []}, "the time axis"),
        ({"materials": []}, "no altitude or no material"),
    ],
)
def test_wrong_axes_are_refused(sun_path, weather, sky, change, message):
    axes = {"materials": [soil()], "altitudes": [0.0], "azimuths": [0.0], "slopes": [0.0], "times": [0.0]} | change
    with pytest.raises(InputError, match=message):
        temperature_table(
            axes["materials"],
            sun_path,
            weather,
            sky,
            axes["altitudes"],
            axes["azimuths"],
            axes["slopes"],
            axes["times"],
        )


def test_azimuths_are_those_of_the_compass(sun_path, weather, sky):
    """-90 is 270, west; a wall that faces the afternoon's Sun is warmer at 17 h than one that faces the morning's."""
    temperatures = temperature_table([soil()], sun_path, weather, sky, [0.0], [-90.0, 270.0, 90.0], [90.0], [17.0])
    west, same, east = temperatures.temperature[0, 0, :, 0, 0]
    assert west == same and west > east + 5


def test_every_altitude_and_plane_has_its_own_column(sun_path, weather, sky):
    """A table of many columns holds what tables of one column hold."""
    altitudes, azimuths, slopes = [0.0, 1500.0], [0.0, 180.0], [0.0, 60.0]
    whole = temperature_table([soil()], sun_path, weather, sky, altitudes, azimuths, slopes, HOURS).temperature[0]
    for a, altitude in enumerate(altitudes):
        for z, azimuth in enumerate(azimuths):
            for s, slope in enumerate(slopes):
                single = temperature_table([soil()], sun_path, weather, sky, [altitude], [azimuth], [slope], HOURS)
                assert whole[a, z, s] == pytest.approx(single.temperature[0, 0, 0, 0], abs=2e-3)


def test_limits_of_the_axes_are_allowed_and_what_lies_beyond_is_not(sun_path, weather, sky):
    def build(slope=0.0, azimuth=0.0, time=0.0):
        return temperature_table([soil()], sun_path, weather, sky, [0.0], [azimuth], [slope], [time])

    for change in ({"slope": 180.0}, {"azimuth": -360.0}, {"azimuth": 360.0}, {"time": 24.0}):
        build(**change)
    for change in ({"slope": -1.0}, {"azimuth": 361.0}, {"azimuth": -361.0}, {"time": 24.5}, {"time": -1.0}):
        with pytest.raises(InputError, match="allowed: one or more values"):
            build(**change)


def test_a_table_reaches_below_sea_level(sun_path, sky):
    """Ground at the Dead Sea beside ground at sea level: solved, within its bounds, and warmer at night by its air."""
    altitude = np.linspace(-430.0, 3570.0, 9)
    low = replace(sky, altitude=altitude, pressure=101325 * np.exp(-altitude / 8000))
    air = from_hours(-430.0, np.arange(24.0), np.full(24, 303.0), 30.0, 2.0, 0.0)
    temperatures = temperature_table([soil()], sun_path, air, low, [-430.0, 0.0], [0.0], [0.0, 90.0], HOURS)
    assert np.all(temperatures.residual <= TOLERANCE) and np.all(temperatures.bound_excess <= 0.1)
    night = temperatures.temperature[0, :, 0, 0, 1]
    assert 1.0 < night[0] - night[1] < 6.0


def test_altitudes_with_days_before_are_those_of_each_alone(sun_path, weather, sky):
    """They are solved one after the other; twins and given temperatures stand at all of them."""
    colder = replace(weather, air_temperature=weather.air_temperature - 8.0, wind_speed=weather.wind_speed + 4.0)
    after = replace(weather, before=((sun_path, colder), (sun_path, colder)))
    materials, ticks = [soil(), soil("twin"), soil("given")], []
    place = ([0.0, 90.0], [0.0, 60.0], HOURS)
    table = temperature_table(
        materials, sun_path, after, sky, [0.0, 800.0], *place, prescribed={"given": 300.0}, progress=ticks.append
    )
    for number, altitude in enumerate((0.0, 800.0)):
        alone = temperature_table([soil()], sun_path, after, sky, [altitude], *place)
        for name in ("temperature", "residual", "method"):
            assert np.array_equal(getattr(table, name)[0, number], getattr(alone, name)[0, 0])
    assert np.array_equal(table.temperature[0], table.temperature[1]) and np.all(table.temperature[2] == 300.0)
    without = temperature_table([soil()], sun_path, weather, sky, [0.0, 800.0], *place)
    assert (without.temperature[0] - table.temperature[0])[..., 0].min() > 0.5
    assert sum(ticks) == pytest.approx(len(materials))


def test_a_table_in_parts_is_the_table_at_once(sun_path, weather, sky, monkeypatch):
    axes = [soil()], sun_path, weather, sky, [0.0, 500.0, 1000.0], [0.0, 90.0], [0.0, 90.0], HOURS
    whole, shares = temperature_table(*axes), []
    monkeypatch.setattr(module, "_COLUMNS", 1)
    parts = temperature_table(*axes, progress=shares.append)
    assert parts.temperature == pytest.approx(whole.temperature, abs=2e-3)
    assert len(shares) == 3 and sum(shares) == pytest.approx(1.0)


@pytest.mark.parametrize(("tolerance", "parts"), [(None, 32), (0.5, 16), (0.3, 32), (0.1, 128)])
def test_a_rounded_table_errs_by_half_of_its_digit(sun_path, weather, sky, tolerance, parts):
    table = temperature_table([soil()], sun_path, weather, sky, [0.0], [0.0, 90.0], [0.0, 90.0], HOURS)
    exact, residual = table.temperature.copy(), table.residual.copy()
    short = rounded(table, tolerance)
    # and the last digit of single precision
    assert 0.2 / parts < np.abs(short.temperature - exact).max() <= 0.5 / parts + 3e-5
    assert np.all(np.mod(short.temperature * parts, 1) == 0)
    assert short.residual == pytest.approx(residual, rel=2**-6) and short.method.dtype == np.uint8
