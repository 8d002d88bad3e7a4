"""Equations of a column in casadi: what each state's rate depends on."""

import numpy as np
import pytest

from skyshine.mat.scene.surface import surface_materials
from skyshine.mat.surface.symbolic_balance import SymbolicMaterial
from skyshine.mat.surface.symbolic_column import cell_shares, grid, rate_function
from skyshine.materials.library import load_library

casadi = pytest.importorskip("casadi")


def test_the_last_cell_exchanges_heat_with_the_air_of_its_cavity():
    """A kelvin more in the cavity warms the last cell by the conductance between both, and no other cell."""
    library = load_library()
    name = next(
        each.name
        for each in library
        if each.opened is None and each.thermal.back.kind == "cavity" and each.thermal.back.capacity
    )
    (material,) = surface_materials([library[name]])
    symbolic = SymbolicMaterial.of(material)
    cells = grid(symbolic, cell_shares(symbolic, 6, 600.0, 86400.0))
    rate = rate_function(casadi, symbolic, cells, casadi.SX.sym("none", 0))
    size = rate.size1_in(0)
    assert size == len(cells) + 2  # the surface, the cells, the air
    state, forcing = np.linspace(290.0, 310.0, size), np.full(rate.size1_in(1), 0.5)
    warmer = state.copy()
    warmer[-1] += 1.0
    before, after = (np.ravel(rate(each, forcing, [])[0]) for each in (state, warmer))
    back, last = symbolic.thermal.back, cells[-1]
    resistance = last.half_resistance + (1.0 / back.coefficient if back.coefficient is not None else 0.0)
    change = after - before
    assert change[:-2] == pytest.approx(0.0, abs=1e-12)
    assert change[-2] == pytest.approx(1.0 / (resistance * last.width * last.capacity), rel=1e-6)
    assert change[-1] == pytest.approx(-(1.0 / resistance + back.exchange) / back.capacity, rel=1e-6)
