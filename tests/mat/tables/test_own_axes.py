"""Databases whose quantities have axes of their own: read as written, checked, exported."""

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.tables.gridded import AXES, QUANTITIES
from skyshine.mat.tables.raw import export_raw
from skyshine.mat.tables.verify import problems
from skyshine.schemas.errors import InputError


@pytest.fixture
def places():
    draw = np.random.default_rng(3)
    limits = ((0.001, 20.0), (0.01, 1.0), (-90.0, 90.0), (-20.0, 60.0), (0.0, 180.0))
    return {name: draw.uniform(*ends, 300) for name, ends in zip(AXES, limits, strict=True)}


@pytest.mark.parametrize("flat", [False, True])
def test_each_quantity_is_read_on_its_own_axes(own_axes, places, tmp_path, flat):
    file, tables = own_axes
    table = skyshine.mat.open(export_raw(file, tmp_path) if flat else file)
    for name, (_, count) in QUANTITIES.items():
        found = table.value(name, **{axis: places[axis] for axis in AXES[:count]})
        np.testing.assert_allclose(found, tables[name].read(places), rtol=1e-6)


def test_scattering_angle_may_be_named_itself(own_axes, places):
    file, tables = own_axes
    table, where = skyshine.mat.open(file), {axis: places[axis] for axis in AXES[:4]}
    angle = tables["path_radiance_ratio"].located(places)["scattering_angle"]
    one = table.value("path_radiance_ratio", **where, scattering_angle=angle)
    other = table.value(
        "path_radiance_ratio",
        **where,
        source_azimuth=-places["source_azimuth"],
        out_of_range={"source_azimuth": "clamp"},
    )
    np.testing.assert_allclose(one, other)
    with pytest.raises(InputError, match="the axis 'source_elevation' is missing"):
        table.value("path_radiance_ratio", range=1.0, altitude=0.5, elevation=0.0, source_azimuth=0.0)


def test_layout_allows_them_and_nothing_else(own_axes):
    # The random values of the file state no errors, and no physics stands behind them.
    lines = [line for line in problems(own_axes[0]) if not line.startswith(("groups/accuracy", "beta_star over range"))]
    assert lines == []


def test_out_of_range_names_the_axis_without_the_quantity(own_axes):
    with pytest.raises(InputError, match="^range: found 30; allowed: 0.001 to 20"):
        skyshine.mat.open(own_axes[0]).value("beta_star", range=30.0, altitude=0.5, elevation=0.0)
