"""Axes and arrays of a ``.htt`` database: units, times, midnight, shade."""

import datetime as dt
from types import SimpleNamespace

import numpy as np
import pytest

from skyshine.mat.surface.response import ResponseTable
from skyshine.mat.surface.response_nodes import LAG_STARTS, OFFSETS, RESPONSE_HOURS
from skyshine.mat.surface.sun_path import sun_hours
from skyshine.mat.tables.htt import midnight_of, shade_fields


def test_altitudes_are_in_kilometres_and_the_sun_stands_at_the_times_of_the_light():
    columns, ends = (1, 2, 1, len(RESPONSE_HOURS)), np.array([-430.0, 2500.0])
    one = np.ones(1, np.float32)
    table = ResponseTable(
        ends,
        np.zeros(1),
        np.zeros((*columns, len(LAG_STARTS)), np.float32),
        *(np.full(columns, 280.0, np.float32), np.ones(columns, np.float32)),
        np.zeros((*columns, len(OFFSETS)), np.float32),
        np.zeros(columns, np.float32),
        *(one, one, one),
    )
    hours = sun_hours()
    scene = SimpleNamespace(
        open_air=lambda steps: np.zeros((5, 2, steps)),
        sun=SimpleNamespace(solar_elevation=hours - 12.0, solar_azimuth=15.0 * hours),
    )
    axes, arrays = shade_fields(table, scene)
    altitude = axes["response_altitude"]
    assert altitude.units == "km" and list(altitude.values) == [-0.43, 2.5]
    (name,) = arrays["solar_azimuth"].dims
    np.testing.assert_allclose(arrays["solar_azimuth"].data, 15.0 * axes[name].values, rtol=1e-6)
    np.testing.assert_allclose(arrays["solar_elevation"].data, axes[name].values - 12.0, rtol=1e-6)


@pytest.mark.parametrize(
    ("offset", "written"), [(0, "+00:00"), (-5, "-05:00"), (5.75, "+05:45"), (-3.5, "-03:30"), (14, "+14:00")]
)
def test_midnight_has_the_zone_of_the_site(offset, written):
    """Newfoundland is 3.5 hours behind, Nepal 5.75 ahead of UTC."""
    assert midnight_of(dt.date(2026, 1, 2), offset) == f"2026-01-02 00:00:00 {written}"
