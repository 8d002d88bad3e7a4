"""Errors that tables state."""

import numpy as np

from skyshine.mat.tables.stated_error import accuracy_group, measure, worst_kelvin
from skyshine.schemas.hdf5 import Group


def table(*errors):
    measures = [measure(name, np.array(kelvin) / 10, np.array(kelvin)) for name, kelvin in errors]
    return Group({}, {}, {"accuracy": accuracy_group(measures, {}, {}, {})}, {})


def test_the_quantity_that_errs_most_speaks_for_a_table():
    found = worst_kelvin(table(("tau", [0.1, -0.2]), ("direct", [0.3, -0.5]), ("band", [np.nan, np.nan])))
    assert found == {"quantity": "direct", "p95": 0.49, "maximum": 0.5}


def test_a_table_without_kelvin_states_none():
    assert worst_kelvin(table(("tau", [np.nan]))) is None
    assert worst_kelvin(table(("tau", []))) is None
    assert worst_kelvin(Group({}, {}, {}, {})) is None
