"""The atmospheric databases as written: (9) gives the transmittance back, no gap from 1 m to space, night is 0."""

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.job.load import load_job
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.tables.atmq import grid_group
from skyshine.mat.tables.gridded import QUANTITIES, Gridded
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Group


@pytest.fixture(scope="module")
def sun(small_build):
    return skyshine.mat.open(small_build / "s01b01.atmq.h5")


def test_beta_star_as_stored_gives_the_transmittance_back(small_job):
    job = load_job(small_job).trimmed
    response = response_of(job.bands[0])
    every = points_of_band(absorption_table(), response)
    few = type(every)(every.points.subset(np.arange(0, every.weight.size, 40)), every.weight[::40], every.gases)
    grid = PathGrid([0.001, 0.1, 1, 10, 100, 1000], [0.01, 5, 600], [-90, -20, -1, 0, 1, 45, 90], [45], [0])
    air = BandAtmosphere.of(atmospheric_state(job.site, job.states[0]), few)
    quantities = air.table(grid, np.zeros(few.weight.size))
    tables = {name: Gridded(grid, getattr(quantities, key), quantities.valid) for name, (key, _) in QUANTITIES.items()}
    stored = grid_group(tables, Group()).variables["beta_star"].data.astype(np.float32)
    where = quantities.valid
    again = np.exp(-5.5 * grid.range_km[:, None, None] / stored.astype(float))
    assert np.max(np.abs(again - quantities.transmittance)[where]) <= 1e-6
    assert np.all(np.isfinite(stored)) and np.all(stored > 0)


def test_cells_behind_the_ground_are_marked(sun):
    valid = (
        sun.root.groups["grid"].variables["valid"].data
    )  # range 0.001, 1, 5, 20 km; altitude 0.01, 1; elevation -90 ... 90
    assert valid[0].all() and valid[:, :, 3:].all()
    assert not valid[2:, 1, 0].any() and not valid[1:, 0, 0].any() and not valid[3, 1, 1]


def test_every_value_is_finite_and_no_radiance_is_negative(sun):
    for name, variable in sun.root.groups["grid"].variables.items():
        assert np.all(np.isfinite(variable.data)) and np.all(variable.data >= 0), name


def test_the_tables_on_the_axes_of_the_job_are_what_the_channels_give_there(sun, small_build):
    """As stored, in single precision; read by linear interpolation half way between two nodes."""
    tables = skyshine.mat.open(small_build / "s01b01.atmq.h5", grid=True)
    place = {"range": [1.0, 5.0], "altitude": 1.0, "elevation": [-30.0, 30.0], "source_elevation": 30.0}
    for name in ("ambient_radiance", "direct_radiance"):
        np.testing.assert_allclose(tables.value(name, **place), sun.value(name, **place), rtol=1e-6)
    path = place | {"source_azimuth": 90.0}
    np.testing.assert_allclose(
        tables.value("path_radiance_ratio", **path), sun.value("path_radiance_ratio", **path), rtol=1e-6
    )
    line = {"altitude": 1.0, "elevation": 30.0}
    ends = [tables.value("beta_star", range=reach, **line) for reach in (5.0, 20.0)]
    assert tables.value("beta_star", range=12.5, **line) == pytest.approx(sum(ends) / 2)
    assert ends[0] == pytest.approx(float(sun.value("beta_star", range=5.0, **line)), rel=1e-6)
    with pytest.raises(InputError, match="omit grid"):
        skyshine.mat.open(small_build / "b01.band.h5", grid=True)


def test_at_night_direct_light_is_0_and_the_sky_is_not(sun):
    night = {"range": 1.0, "altitude": 0.5, "elevation": 30.0, "source_elevation": -20.0}
    assert sun.value("direct_radiance", **night) == 0.0
    assert sun.value("ambient_radiance", **night) > 1.0


def test_the_moon_is_far_fainter_than_the_sun(sun, small_build):
    moon = skyshine.mat.open(small_build / "s01b01.lunar_atmq.h5")
    place = {"range": 1.0, "altitude": 0.01, "elevation": 30.0, "source_elevation": 60.0}
    ratio = moon.value("direct_radiance", **place) / sun.value("direct_radiance", **place)
    # A 390 K disk against a 5000 K one of the same size at 10 um: 3e-3 of it; seen nearly full.
    assert 1e-3 < ratio < 1e-2


@pytest.mark.parametrize(
    ("length", "beta", "words"),
    [
        (-1.0, 20.0, "range: found -1; allowed: 0 km or more"),
        ([1.0, np.nan], 20.0, "range: found nan; allowed: 0 km or more"),
        (np.inf, 20.0, "range: found inf"),
        (1.0, 0.0, "beta_star: found 0; allowed: above 0 km"),
        (1.0, [5.0, np.nan], "beta_star: found nan"),
        (1.0, -3.0, "beta_star: found -3"),
    ],
)
def test_ranges_below_0_and_what_is_not_finite_have_no_transmittance(sun, length, beta, words):
    with pytest.raises(InputError, match=words):
        sun.transmittance(range=length, beta_star=beta)
    assert sun.transmittance(range=[0.0, 2.0], beta_star=11.0) == pytest.approx([1.0, np.exp(-1.0)])
