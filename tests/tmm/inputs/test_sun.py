"""Where shadows fall: by angles and by time, on images with and without a place on a map."""

from datetime import UTC, datetime

import numpy as np
import pandas as pd
import pvlib
import pydantic
import pytest
import tifffile

from skyshine.schemas.errors import InputError
from skyshine.tmm.inputs.sun import shadow_fall
from skyshine.tmm.job.shade import Shade

TIME = "2021-06-15T08:30:00Z"


def geotiff(path, x, y, code, size=(0.2, 0.2), key=3072):
    """Eight by eight texels whose corner lies at x, y of a system."""
    keys = [1, 1, 0, 3, 1024, 0, 1, 1 if key == 3072 else 2, 1025, 0, 1, 1, key, 0, 1, code]
    tags = [
        (33550, "d", 3, (*size, 0.0), True),
        (33922, "d", 6, (0.0, 0.0, 0.0, x, y, 0.0), True),
        (34735, "H", len(keys), tuple(keys), True),
    ]
    tifffile.imwrite(path, np.full((8, 8, 3), 90, np.uint8), photometric="rgb", extratags=tags)
    return path


def image(tmp_path, world=None):
    path = tmp_path / "a.tif"
    tifffile.imwrite(path, np.full((8, 8, 3), 90, np.uint8), photometric="rgb")
    if world is not None:
        path.with_suffix(".tfw").write_text(world)
    return path


def bearing(fall):
    """Degrees clockwise from up, of an image whose texels are squares."""
    return np.degrees(np.arctan2(fall.x, -fall.y)) % 360


@pytest.mark.parametrize(
    "azimuth, towards", [(0, (0, 1)), (90, (-1, 0)), (180, (0, -1)), (225, (0.5**0.5, -(0.5**0.5)))]
)
def test_shadows_fall_away_from_the_sun(tmp_path, azimuth, towards):
    fall = shadow_fall(Shade(sun_azimuth_deg=azimuth), image(tmp_path))
    assert (fall.x, fall.y) == pytest.approx(towards, abs=1e-12) and fall.reach == 128


def test_north_is_that_of_the_map(tmp_path):
    # Columns run north and rows east, as on an image turned by a quarter: a, d, b, e, c, f.
    fall = shadow_fall(Shade(sun_azimuth_deg=180), image(tmp_path, "0 1 1 0 0 0"))
    assert (fall.x, fall.y) == pytest.approx((1, 0), abs=1e-12)


@pytest.mark.parametrize(
    "x, y, latitude, meridians", [(714_000.0, 5_542_000.0, 50.0, 3.0), (286_000.0, 5_542_000.0, 50.0, -3.0)]
)
def test_true_north_is_not_that_of_the_grid(tmp_path, x, y, latitude, meridians):
    """The convergence of meridians, by the first term of its series: d lambda sin phi."""
    fall = shadow_fall(Shade(sun_azimuth_deg=180), geotiff(tmp_path / "a.tif", x, y, 32633))
    convergence = meridians * np.sin(np.radians(latitude))
    turned = (bearing(fall) + 180) % 360 - 180
    # East of the central meridian true north lies to the left of the grid's.
    assert turned == pytest.approx(-convergence, abs=0.05)


def test_degrees_are_shorter_to_the_east(tmp_path):
    path = geotiff(tmp_path / "a.tif", 10.0, 60.0, 4326, (1e-5, 1e-5), 2048)
    fall = shadow_fall(Shade(sun_azimuth_deg=225), path)  # to the north east
    assert fall.x / -fall.y == pytest.approx(2.0, rel=3e-3)  # 1 / cos 60, less what the ellipsoid is off a sphere


@pytest.mark.parametrize("elevation, reach", [(80.0, 45), (45.0, 128), (89.99, 16), (1.0, 128)])
def test_a_high_sun_casts_short_shadows(tmp_path, elevation, reach):
    """50 m over the tangent, in texels of 0.2 m: 44.1 at 80 degrees, 250 at 45."""
    path = geotiff(tmp_path / "a.tif", 500_000.0, 5_542_000.0, 32633)
    fall = shadow_fall(Shade(sun_azimuth_deg=135, sun_elevation_deg=elevation), path)
    assert fall.reach == pytest.approx(reach, abs=1)


@pytest.mark.parametrize("time", [TIME, "2021-06-15 10:30+02:00"])
def test_time_and_place_give_the_sun_of_another_program(tmp_path, time):
    path = geotiff(tmp_path / "a.tif", 500_000.0, 5_542_000.0, 32633)  # 15 degrees east
    fall = shadow_fall(Shade.model_validate({"time": time}), path)
    moment = pd.DatetimeIndex([datetime(2021, 6, 15, 8, 30, tzinfo=UTC)])
    other = pvlib.solarposition.spa_python(moment, 50.03, 15.0)
    assert fall.azimuth == pytest.approx(other["azimuth"].iloc[0], abs=0.1)
    assert bearing(fall) == pytest.approx(fall.azimuth + 180, abs=0.05)


def test_a_time_that_cannot_be_used_is_refused(tmp_path):
    at = Shade.model_validate({"time": TIME})
    with pytest.raises(InputError, match="has no place on a map, which 'shade.time' needs"):
        shadow_fall(at, image(tmp_path))
    with pytest.raises(InputError, match="lies on a map in 'no coordinate system'; allowed: a system that PROJ knows"):
        shadow_fall(at, image(tmp_path, "1 0 0 -1 0 0"))
    path = geotiff(tmp_path / "b.tif", 500_000.0, 5_542_000.0, 32633)
    with pytest.raises(InputError, match=r"the Sun was [0-9.]+ degrees below the horizon at 2021-06-15T23:00:00"):
        shadow_fall(Shade.model_validate({"time": "2021-06-15T23:00:00Z"}), path)


@pytest.mark.parametrize(
    "given, message",
    [
        ({"time": TIME, "sun_azimuth_deg": 135}, "found time and the Sun's angles"),
        ({}, "found shade without the Sun's direction; add sun_azimuth_deg"),
        ({"sun_elevation_deg": 40}, "found sun_elevation_deg without sun_azimuth_deg"),
        ({"time": "2021-06-15T08:30:00"}, "found '2021-06-15T08:30:00'; allowed: a date and time with its zone"),
        ({"time": 1623745800}, "found '1623745800'; allowed: a date and time with its zone"),
        ({"time": "noon"}, "found 'noon'; allowed: a date and time with its zone"),
        ({"sun_azimuth_deg": 361}, "less than or equal to 360"),
        ({"sun_azimuth_deg": float("nan")}, "finite|greater than or equal"),
        ({"sun_azimuth_deg": 135, "sun_elevation_deg": 0}, "greater than 0"),
    ],
)
def test_angles_and_times_are_checked(given, message):
    with pytest.raises(pydantic.ValidationError, match=message):
        Shade.model_validate(given)
