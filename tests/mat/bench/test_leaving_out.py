"""Two builds compared: equal files differ by nothing, and a planted difference shows at its size."""

from dataclasses import replace

import numpy as np
import pytest

import skyshine.mat
from mat.maintain.bench.omissions import KELVIN_BOUND, VALUE_BOUND, air_differences, table_differences
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.equivalent_temperature import kelvin_per_radiance
from skyshine.mat.tables.axes import EXACT, PERIODIC, table_axis
from skyshine.schemas.hdf5 import Group, Header, Variable, write_file


@pytest.fixture
def write(tmp_path):
    """Writes a table of a temperature and of a plain value over one axis."""

    def written(folder, kelvin=0.0, share=0.0):
        (tmp_path / folder).mkdir(exist_ok=True)
        axes = {
            "material": table_axis(np.array([7], np.int32), "1", "code", interpolation=EXACT),
            "altitude": table_axis(np.array([0.0, 1.0, 3.0]), "km", "altitude"),
            "azimuth": table_axis([0.0], "degree", "azimuth", interpolation=PERIODIC, period=360.0),
            "slope": table_axis([0.0], "degree", "slope"),
            "time": table_axis([0.0], "h", "local time", interpolation=PERIODIC, period=24.0),
        }
        kelvins = np.reshape([280.0, 290.0, 300.0], (1, 3, 1, 1, 1)) + kelvin
        variables = {
            "temperature": Variable(tuple(axes), kelvins, "K", "t"),
            "share": Variable(("altitude",), np.array([2.0, 4.0, 8.0]) * (1 + share), "1", "s"),
        }
        file = tmp_path / folder / "s01.htt.h5"
        accuracy = Group(attributes={"left_out_bound_kelvin": 0.0})
        write_file(file, Group(axes, variables, {"accuracy": accuracy}), Header("htt", "d", "j"))
        return file

    return written


def compare(kept, whole):
    return table_differences(skyshine.mat.open(kept), skyshine.mat.open(whole), np.random.default_rng(1))


def test_equal_files_differ_by_nothing(write):
    found = compare(write("kept"), write("whole"))
    assert found == {"s01.htt.h5: temperature": (0.0, KELVIN_BOUND), "s01.htt.h5: share": (0.0, VALUE_BOUND)}


def test_temperatures_differ_in_kelvin_and_values_by_their_share(write):
    found = compare(write("kept"), write("whole", kelvin=0.5, share=0.25))
    assert found["s01.htt.h5: temperature"][0] == pytest.approx(0.5, rel=1e-3)
    # Relative to the value of the whole table, or to the median where it is less.
    assert found["s01.htt.h5: share"][0] == pytest.approx(0.2, rel=1e-3)


LINES = PathGrid(*(np.array(ends, float) for ends in ((0.01, 20), (0.01, 2), (-90, 90), (-60, -30), (0, 180))))


def test_an_error_of_path_radiance_shows_in_kelvin_and_in_nothing_else(channel_atmosphere):
    """At night, where all of it is thermal: a share of what the longest lines see."""
    air = skyshine.mat.open(channel_atmosphere)
    ratio = air.root.variables["thermal_ratio"]
    values = np.asarray(ratio.data) * np.float32(1.05)
    brighter = Variable(ratio.dims, values, ratio.units, ratio.long_name, ratio.attributes)
    changed = replace(air, root=replace(air.root, variables=air.root.variables | {"thermal_ratio": brighter}))
    same, found = (air_differences(one, air, LINES, np.random.default_rng(2)) for one in (air, changed))
    assert [value for value, _ in same.values()] == [0.0] * 4
    assert {bound for _, bound in found.values()} == {10.0}  # each file keeps 5 K
    (name,) = (name for name, (value, _) in found.items() if value > 0)
    assert name.endswith("path_radiance_ratio, K")
    line = {"range": 20.0, "altitude": 0.5, "elevation": 0.0}
    through = air.transmittance(range=20.0, beta_star=air.value("beta_star", **line))
    path = air.value("path_radiance_ratio", source_elevation=-60.0, source_azimuth=0.0, **line) * (1 - through)
    kelvin = 0.05 * float(path) * kelvin_per_radiance(SpectralResponse.rectangular(10.0, 10.2))
    assert 0.3 * kelvin < found[name][0] < kelvin  # few of the lines are as long
