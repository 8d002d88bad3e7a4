"""Atmospheric tables while their source is below the lowest of its elevations."""

from dataclasses import replace

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.tables.night import dark_elevation
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Variable

LINE = {"range": [0.5, 4.0], "altitude": 0.4, "elevation": [-20.0, 10.0]}
MIDNIGHT = {"source_elevation": -70.0}
THERMAL = ("path_radiance_ratio", "ambient_radiance")


@pytest.fixture(scope="module")
def sun(small_build):
    return skyshine.mat.open(small_build / "s01b01.atmq.h5")


def with_lowest(table, degree):
    """The table, as if the light of its first elevation of the source from 20 degrees on were that of another one."""
    axes, variables = dict(table.root.axes), dict(table.root.variables)
    for name in ("source_elevation", "sky_source_elevation"):
        nodes = np.asarray(axes[name].values, float)
        kept = np.flatnonzero(nodes >= 20.0)
        axes[name] = replace(axes[name], values=np.array([degree, *nodes[kept[1:]]]))
        for key, variable in variables.items():
            if name in variable.dims:
                data = np.take(np.asarray(variable.data), kept, axis=variable.dims.index(name))
                variables[key] = Variable(variable.dims, data, variable.units, variable.long_name)
    return replace(table, root=replace(table.root, axes=axes, variables=variables))


def scattering(table):
    """The table with scattered light along paths, of which the band of the job has too little to be stored."""
    variables = dict(table.root.variables)
    for name in ("scattered_ratio", "source_factor"):
        stored = variables[name]
        variables[name] = Variable(stored.dims, np.ones(np.shape(stored.data)), stored.units, stored.long_name)
    variables["source_reference"] = variables["thermal_reference"]
    return replace(table, root=replace(table.root, variables=variables))


def where(quantity):
    return LINE | ({"scattering_angle": 60.0} if quantity == "path_radiance_ratio" else {})


def test_the_dark_begins_when_twilight_has_ended_within_the_horizon():
    """Astronomical twilight ends at -18 degree; the horizon of 10 km lies 3.21 degree below the horizontal."""
    assert dark_elevation(0.0) == -18.0
    assert dark_elevation(90_000.0) == -90.0
    assert dark_elevation(10.0) == pytest.approx(-18.0 - np.degrees(np.sqrt(2 * 10 / 6371.0)), abs=3e-3)


@pytest.mark.parametrize("source", ["atmq", "lunar_atmq"])
@pytest.mark.parametrize("quantity", THERMAL)
def test_at_midnight_the_thermal_light_stays_as_the_table_has_it_at_20_degrees_below(small_build, source, quantity):
    table = skyshine.mat.open(small_build / f"s01b01.{source}.h5")
    night = table.value(quantity, **where(quantity), **MIDNIGHT)
    assert np.all(night > 0)
    np.testing.assert_allclose(night, table.value(quantity, **where(quantity), source_elevation=-20.0), rtol=1e-5)


def test_there_is_no_direct_light_at_midnight(sun):
    assert not np.any(sun.value("direct_radiance", **LINE, **MIDNIGHT))


def test_tilted_faces_are_lit_at_midnight_as_at_20_degrees_below(sun):
    face = {"slope": [30.0, 90.0], "azimuth": 50.0}
    night = sun.ambient_radiance(**face, **LINE, **MIDNIGHT)
    np.testing.assert_allclose(night, sun.ambient_radiance(**face, **LINE, source_elevation=-20.0), rtol=1e-4)


@pytest.mark.parametrize("quantity", THERMAL)
def test_light_fades_from_deep_twilight_without_a_step(sun, quantity):
    """A table whose light of a high Sun is that of -8 degrees."""
    table = with_lowest(scattering(sun), -8.0)
    dark = table.root.axes["source_elevation"].attributes["dark_below"]
    heights = np.array([-8.0, -8.0001, (dark - 8) / 2, dark + 1e-4, dark, -60.0])
    place = {name: np.atleast_1d(values)[..., :1] for name, values in where(quantity).items()}
    values = table.value(quantity, **place, source_elevation=heights)
    lit, night = values[0], values[-1]
    assert lit > night * 1.0000001
    np.testing.assert_allclose((values - night) / (lit - night), [1, 1, 0.5, 0, 0, 0], atol=1e-4)


def test_a_table_without_twilight_refuses_twilight_and_answers_in_the_dark(sun):
    table = with_lowest(sun, -1e-9)
    with pytest.raises(InputError, match=r"source_elevation: found -9; allowed: .*-19.* and below, where it is dark"):
        table.value("ambient_radiance", **LINE, source_elevation=[-50.0, -9.0])
    lowest = table.value("ambient_radiance", **LINE, source_elevation=-1e-9)
    clamped = table.clamped().value("ambient_radiance", **LINE, source_elevation=-9.0)
    np.testing.assert_allclose(clamped, lowest, rtol=1e-9)
    assert np.all(table.value("ambient_radiance", **LINE, source_elevation=-30.0) > 0)


@pytest.mark.parametrize("degree", [5.0, -91.0, np.nan, "dark"])
def test_a_dark_that_cannot_be_is_refused(sun, degree):
    axis = sun.root.axes["source_elevation"]
    wrong = Axis(axis.values, axis.units, axis.long_name, axis.attributes | {"dark_below": degree})
    table = replace(sun, root=replace(sun.root, axes=sun.root.axes | {"source_elevation": wrong}))
    with pytest.raises(InputError, match="dark_below"):
        table.value("ambient_radiance", **LINE, source_elevation=10.0)
