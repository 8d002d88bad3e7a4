"""Water in the pores of soil: laws against published numbers."""

import numpy as np
import pytest

from skyshine.mat.surface.soil_moisture import conductivity, evaporating_share, moist_stack, resistance
from skyshine.materials.library import load_library
from skyshine.materials.records import Soil

SAND = Soil("sand", 0.4, 5.2, 2)


def test_oke_table_of_dry_and_saturated_soils():
    """Oke (1987), table 2.1: clay soil of 40 % pore space .25 and 1.58 W/mK, peat of 80 % .06 and .50; 1.42, 3.10 and
    .58, 4.02 MJ/m3K; water moves both from one to the other."""
    library = load_library()
    for name, dry, wet, capacities in (
        ("soil_clay_dark", 0.25, 1.58, (1.42e6, 3.10e6)),
        ("soil_organic", 0.06, 0.50, (0.58e6, 4.02e6)),
    ):
        material = library[name]
        assert conductivity(material.soil, 0.0) == pytest.approx(dry, rel=0.02)
        assert conductivity(material.soil, material.soil.porosity) == pytest.approx(wet, rel=0.06)
        for moisture, capacity in zip((0.0, material.soil.porosity), capacities, strict=True):
            top = moist_stack(material.thermal, material.soil, moisture).layers[0]
            assert top.density * top.heat_capacity == pytest.approx(capacity, rel=0.03)


@pytest.mark.parametrize(("texture", "half"), [("gravel", 0.821), ("sand", 0.780), ("fine", 0.655), ("organic", 0.375)])
def test_relative_conductivity_of_half_full_pores(texture, half):
    """Cote and Konrad (2005), figure of the relative conductivity of unfrozen soils: kappa S / (1 + (kappa - 1) S)."""
    soil = Soil(texture, 0.4, 3.0, 2)
    dry, middle, wet = (float(conductivity(soil, s * 0.4)) for s in (0.0, 0.5, 1.0))
    assert (middle - dry) / (wet - dry) == pytest.approx(half, abs=5e-4)


def test_saturated_conductivity_is_the_geometric_mean():
    """Quartz sand of 5.2 W/mK in 40 % water: 5.2^.6 .6^.4 = 2.19 (Oke: 2.2)."""
    assert conductivity(SAND, 0.4) == pytest.approx(2.19, abs=0.01)


def test_resistance_of_van_de_griend_and_owe():
    """10 exp(0.3563 (15 - theta)) s/m: 10 at 15 %, 59.4 at 10 %, 353 at 5 %."""
    np.testing.assert_allclose(resistance([0.15, 0.10, 0.05, 0.3]), [10.0, 59.39, 352.7, 10.0], rtol=1e-3)
    np.testing.assert_allclose(evaporating_share([0.0, 0.02, 0.04, 0.3]), [0.0, 0.5, 1.0, 1.0])


def test_deeper_soil_keeps_the_water_that_it_has():
    material = load_library()["soil_sand"]
    before = material.thermal.layers[1]
    assert moist_stack(material.thermal, material.soil, 0.05).layers[1] == before
    assert moist_stack(material.thermal, material.soil, 0.35).layers[1].density > before.density
    gravel = load_library()["ballast_granite"]
    assert moist_stack(gravel.thermal, gravel.soil, 0.26).layers[1] == gravel.thermal.layers[1]
