"""Which gases of a table are judged line by line: those that lines describe over all of a range."""

import pytest
from line_by_line_levels import judged_gases


class Library:
    """Line lists of CO2 everywhere and of H2O up to 800 cm^-1."""

    class Gas:
        def __init__(self, name):
            self.name = name

    gases = (Gas("CO2"), Gas("H2O"))

    def covers(self, gas, low, high):
        return gas == "CO2" or high <= 800.0


class Table:
    """Four gases on intervals of 100 cm^-1; O3 comes from cross sections, N2O has no data here."""

    gases = ("CO2", "H2O", "O3", "N2O")
    interval_edges = tuple((low, low + 100.0) for low in (600.0, 700.0, 800.0, 900.0))

    def provenance(self, gas):
        source = {"CO2": "lines", "H2O": "lines", "O3": "cross sections", "N2O": "no data"}[gas]
        return [(600.0, 1000.0, source)]


class Partial(Table):
    """H2O in the first two intervals alone."""

    def provenance(self, gas):
        rest = (800.0, 1000.0, "negligible")
        return [(600.0, 800.0, "lines"), rest] if gas == "H2O" else Table.provenance(self, gas)


@pytest.mark.parametrize(
    "table, judged, others",
    [(Table(), ["CO2"], ["H2O", "O3"]), (Partial(), ["CO2", "H2O"], ["O3"])],
)
def test_gases_are_judged_where_lines_cover_all_that_the_table_holds(table, judged, others):
    assert judged_gases(Library(), table, 600.0, 1000.0) == (judged, others)


def test_a_gas_outside_the_range_is_neither():
    assert judged_gases(Library(), Partial(), 850.0, 950.0) == (["CO2"], ["O3"])
