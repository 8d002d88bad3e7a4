"""The part of a table that a frame reads gives what the whole table gives."""

import numpy as np
import pytest

from skyshine.mat.tables.axes import EXACT, FOLDED, AxisRule, table_axis
from skyshine.mat.tables.frame import part_of
from skyshine.mat.tables.table import Table
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Group, Variable


@pytest.fixture
def table():
    draw = np.random.default_rng(2)
    axes = {
        "range": table_axis(np.array([0.0, 1.0, 4.0, 9.0]), "km", "r"),
        "altitude": table_axis(np.array([0.1, 2.0]), "km", "a"),
        "elevation": table_axis(np.array([-30.0, -10.0, -3.0, 0.0, 20.0]), "degree", "e"),
        "source_azimuth": table_axis(np.array([0.0, 90.0, 180.0]), "degree", "s", interpolation=FOLDED, period=360.0),
        "material": table_axis(np.array([3, 8], np.int32), "1", "m", interpolation=EXACT),
    }
    shapes = {"path": ("range", "altitude", "elevation", "source_azimuth"), "plain": ("material",)}
    variables = {
        name: Variable(dims, draw.random([axes[d].values.size for d in dims]).astype(np.float32), "1", name)
        for name, dims in shapes.items()
    }
    variables["valid"] = Variable(("range", "altitude", "elevation"), np.ones((4, 2, 5), np.int8), "1", "valid")
    return Table("t.h5", "atmq", Group(axes, variables), {})


def test_it_reads_as_the_whole_does(table):
    draw = np.random.default_rng(5)
    place = {
        "range": draw.uniform(0, 9, 300),
        "elevation": draw.uniform(-8, -4, 300),
        "source_azimuth": draw.uniform(-400, 400, 300),
    }
    part = table.part(altitude=1.3, elevation=(-8.0, -4.0))
    np.testing.assert_allclose(part.value("path", **place), table.value("path", altitude=1.3, **place), rtol=1e-12)
    assert part.root.variables["path"].data.shape == (4, 2, 3)
    assert (
        set(part.root.axes) == {"range", "elevation", "source_azimuth", "material"}
        and "valid" not in part.root.variables
    )
    np.testing.assert_array_equal(part.root.variables["plain"].data, table.root.variables["plain"].data)


def test_a_profile_along_one_line_of_sight(table):
    still = {"altitude": 0.4, "elevation": 7.0, "source_azimuth": 200.0}
    ranges = np.linspace(0, 9, 40)
    np.testing.assert_allclose(
        table.part(**still).value("path", range=ranges), table.value("path", range=ranges, **still), rtol=1e-12
    )


def test_ends_outside_the_axis_clamp_where_asked(table):
    part = table.clamped("elevation").part(elevation=(-90.0, -20.0))
    assert part.root.axes["elevation"].values.tolist() == [-30.0, -10.0]


@pytest.mark.parametrize(
    ("where", "words"),
    [
        ({"elevation": (-90.0, -20.0)}, "elevation: found -90; allowed: -30 to 20"),
        ({"altitude": np.nan}, "altitude: found a value that is not finite"),
        ({"elevation": (3.0, -3.0)}, "elevation: found .*; allowed: a number, or the least and the most"),
        ({"source_azimuth": (0.0, 20.0)}, "source_azimuth: found a pair; allowed: one value, or leave the axis whole"),
        ({"elevatoin": 3.0}, "found the axis 'elevatoin'.*elevation"),
    ],
)
def test_what_is_refused(table, where, words):
    with pytest.raises(InputError, match=words):
        table.part(**where)


@pytest.fixture
def plane():
    """x + 10 y on two axes, a variable of y alone and one of neither."""
    x, y = np.array([0.0, 1.0, 2.0, 4.0]), np.array([0.0, 5.0])
    axes = {"x": table_axis(x, "1", "x"), "y": table_axis(y, "1", "y"), "z": table_axis(np.array([7.0]), "1", "z")}
    variables = {
        "sum": Variable(("x", "y"), x[:, None] + 10 * y, "K", "sum", {"error": "0.1"}),
        "flag": Variable(("y",), np.ones(2), "1", "flag"),
        "other": Variable(("z",), np.ones(1), "1", "other"),
    }
    return Group(axes, variables, {}, {"made": "here"}), {"sum": [AxisRule("x", x), AxisRule("y", y)]}


def test_a_value_is_interpolated_and_its_axis_gone(plane):
    root, rules = plane
    part = part_of(root, rules, {"sum": {"y": 2.0}})
    assert part.variables["sum"].dims == ("x",) and set(part.axes) == {"x", "z"}
    assert part.variables["sum"].data == pytest.approx([20, 21, 22, 24])
    assert part.variables["sum"].attributes == {"error": "0.1"} and part.attributes == {"made": "here"}
    assert set(part.variables) == {"sum", "other"}  # what else has the axis has no meaning without it


@pytest.mark.parametrize("pair, nodes", [((0.5, 1.5), [0, 1, 2]), ((1.0, 1.0), [1, 2]), ((3.0, 4.0), [2, 4])])
def test_a_pair_keeps_the_nodes_around_it(plane, pair, nodes):
    part = part_of(*plane, {"sum": {"x": pair}})
    assert part.axes["x"].values.tolist() == nodes
    assert part.variables["sum"].data[:, 0].tolist() == nodes


@pytest.mark.parametrize("pair", [(2.0, 1.0), (0.0, 1.0, 2.0)])
def test_what_is_neither_a_number_nor_a_rising_pair_is_refused(plane, pair):
    with pytest.raises(InputError, match=r"x: found \[.*\]; allowed: a number, or the least and the most"):
        part_of(*plane, {"sum": {"x": pair}})
