"""Observers in space: their lines of sight enter the air at its top, and are read there."""

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS
from skyshine.mat.job.load import load_job
from skyshine.mat.quantities.channels.coordinates import TOP_KM, Entry
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.scattering_angle import scattering_angle
from skyshine.mat.tables.atmq import tables_on_axes

JOB = """\
skyshine: 1
name: orbit
site: {latitude_deg: 29.7, longitude_deg: -82.0, date: 2026-06-28, utc_offset_h: -5}
states:
  - {profile: midlatitude_summer, weather: {air_temperature_c: [22, 33]}}
bands: [{wavelength_um: [10.0, 10.2]}]
sources: [sun]
materials: [asphalt_road]
atmosphere_grid: {tolerance: 5 K, range_km: [1, 3000], altitude_km: [90, 700], source_elevation_deg: [-8, 60]}
surface_grid: {altitude_km: [0], azimuth_deg: [180], slope_deg: [0], time: ["12:00"]}
output: {folder: built, pictures: false}
"""


@pytest.fixture(scope="module")
def air(build_atmosphere, tmp_path_factory):
    folder = tmp_path_factory.mktemp("orbit")
    (folder / "job.yaml").write_text(JOB, encoding="utf-8")
    return skyshine.mat.open(build_atmosphere(load_job(folder / "job.yaml"), folder))


def vectors(altitude, elevation, up, azimuth):
    """Place, line of sight and source in the plane of the line, z through the observer; kilometres."""
    place = np.array([0.0, 0.0, EARTH_RADIUS / 1e3 + altitude])
    line = np.array([np.cos(np.radians(elevation)), 0.0, np.sin(np.radians(elevation))])
    turn, height = np.radians([azimuth, up])
    source = np.array([np.cos(height) * np.cos(turn), np.cos(height) * np.sin(turn), np.sin(height)])
    return place, line, source


@pytest.mark.parametrize(("altitude", "elevation"), [(400.0, -60.0), (700.0, -25.5), (36_000.0, -85.0), (150.0, -10.0)])
def test_the_entry_is_where_the_line_meets_the_top_of_the_air(altitude, elevation):
    """By vectors in a plane."""
    place, line, source = vectors(altitude, elevation, 35.0, 70.0)
    entry = Entry.of(50_000.0, altitude, elevation)
    there = place + (50_000.0 - entry.range_km) * line
    assert np.linalg.norm(there) == pytest.approx(EARTH_RADIUS / 1e3 + TOP_KM, rel=1e-9)
    up = there / np.linalg.norm(there)
    assert entry.elevation_deg == pytest.approx(np.degrees(np.arcsin(up @ line)), abs=1e-6)
    assert entry.source_elevation(35.0, 70.0) == pytest.approx(np.degrees(np.arcsin(up @ source)), abs=1e-6)
    assert scattering_angle(elevation, 35.0, 70.0) == pytest.approx(np.degrees(np.arccos(line @ source)), abs=1e-6)


def test_observers_in_the_air_stay_where_they_are():
    entry = Entry.of([1.0, 2.0], [0.0, 99.0], [-30.0, 30.0])
    assert entry.range_km.tolist() == [1.0, 2.0] and entry.elevation_deg == pytest.approx([-30.0, 30.0])
    assert entry.source_elevation(60.0, 50.0).tolist() == [60.0, 60.0]  # no rounding beyond the end of an axis


def test_tables_on_axes_hold_sources_that_are_higher_where_a_line_enters_the_air(air):
    """At the entry a Sun ahead, 60 degree high at the observer, is higher: read at the end of the channels."""
    axes = [1.0, 900.0], [90.0, 700.0], [-60.0, -25.0], [-8.0, 60.0], [0.0, 180.0]
    grid = PathGrid(*map(np.array, axes))
    assert Entry.of(900.0, 700.0, -60.0).source_elevation(60.0, 0.0) > 60.0
    path = tables_on_axes(air, grid)["path_radiance_ratio"].values
    assert path.shape == (2, 2, 2, 2, 2) and np.all(np.isfinite(path)) and np.all(path >= 0)


def test_a_satellite_reads_what_the_top_of_the_air_reads_on_the_same_line(air):
    satellite = {"range": 900.0, "altitude": 700.0, "elevation": -60.0}
    entry = Entry.of(*satellite.values())
    top = {"range": entry.range_km, "altitude": TOP_KM, "elevation": entry.elevation_deg}
    tau = [air.transmittance(range=at["range"], beta_star=air.value("beta_star", **at)) for at in (satellite, top)]
    assert tau[0] == pytest.approx(tau[1], rel=1e-6) and 0.2 < tau[0] < 0.95
    assert air.value("valid", **satellite) == air.value("valid", **top) == 0  # 900 km lead into the ground
    for name in ("ambient_radiance", "direct_radiance"):
        light = [air.value(name, **at, source_elevation=40.0) for at in (satellite, top)]
        assert light[0] == pytest.approx(light[1], rel=1e-6)


def test_a_line_that_misses_the_air_or_ends_before_it_loses_nothing(air):
    for line in (
        {"range": 100.0, "elevation": -60.0},
        {"range": 2000.0, "elevation": 10.0},
        {"range": 2000.0, "elevation": -5.0},
    ):
        beta = air.value("beta_star", altitude=700.0, **line)
        assert air.transmittance(range=line["range"], beta_star=beta) == pytest.approx(1.0, abs=1e-6)
        assert air.value("valid", altitude=700.0, **line) == 1


def test_a_target_in_space_is_lit_when_the_ground_below_is_dark(air):
    """700 km up the horizon lies 25.7 degrees down."""
    target = {"range": 50.0, "altitude": 700.0, "elevation": 0.0}
    lit, dark = (air.value("direct_radiance", **target, source_elevation=up) for up in (-7.0, -8.0))
    assert lit == pytest.approx(dark, rel=0.01) and lit > 0
    ground = {"range": 700.0, "altitude": 700.0, "elevation": -90.0}
    assert air.value("direct_radiance", **ground, source_elevation=-7.0) == 0
