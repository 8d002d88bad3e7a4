"""Views and tables for the tests of the error budget."""

from dataclasses import replace

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.budget.built_tables import Tables
from skyshine.mat.budget.views import Views
from skyshine.mat.quantities.lines_of_sight import direction
from skyshine.mat.tables.axes import table_axis
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.schemas.hdf5 import Group


@pytest.fixture(scope="session")
def make_views():
    """n views that look down at level ground; any of their coordinates may be given."""

    def made(count, **given):
        values = {
            "altitude": 0.5,
            "surface_altitude": 0.0,
            "range": 2.0,
            "elevation": -15.0,
            "heading": 0.0,
            "time": 12.0,
            "source_elevation": 40.0,
            "source_azimuth": 120.0,
            "normal": direction(90.0, 0.0),
            "along": direction(0.0, 90.0),
            "face": 20.0,
            "share": 0.25,
            "bend": 0.0,
        } | given
        shape = {"normal": (count, 3), "along": (count, 3)}
        return Views(*(np.array(np.broadcast_to(value, shape.get(name, count))) for name, value in values.items()))

    return made


@pytest.fixture(scope="session")
def tables(small_build):
    """Air and band of a build; of the surface the axes alone."""
    nodes = {"altitude": [0.0, 1.0], "azimuth": [0.0, 180.0], "slope": [0.0, 90.0], "time": [0.0, 12.0]}
    axes = {name: table_axis(np.array(values), "1", name) for name, values in nodes.items()}
    surface = TemperatureTable("s01.htt.h5", "htt", Group(axes), {})
    air, band = (skyshine.mat.open(small_build / f"{name}.h5") for name in ("s01b01.atmq", "b01.band"))
    stated = {name: value for name, value in air.attributes.items() if name != "ground_material"}
    return Tables(surface, band, replace(air, attributes=stated), None)
