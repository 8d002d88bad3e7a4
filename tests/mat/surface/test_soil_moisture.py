"""Water in the pores of soil: laws against published numbers."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import solve_banded

from skyshine.mat.surface.soil_moisture import (
    DEPTH,
    TEXTURES,
    conductivity,
    diffusivity,
    dry_layer,
    drying_moisture,
    freezing_capacity,
    moist_stack,
    resistance,
    supply,
    unfrozen_water,
)
from skyshine.materials.library import load_library
from skyshine.materials.records import Back, Layer, Soil, ThermalStack

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


@pytest.mark.parametrize(("texture", "half"), [("gravel", 0.821), ("sand", 0.780), ("loam", 0.655), ("organic", 0.375)])
def test_relative_conductivity_of_half_full_pores(texture, half):
    """Cote and Konrad (2005), figure of the relative conductivity of unfrozen soils: kappa S / (1 + (kappa - 1) S)."""
    soil = Soil(texture, 0.4, 3.0, 2)
    dry, middle, wet = (float(conductivity(soil, s * 0.4)) for s in (0.0, 0.5, 1.0))
    assert (middle - dry) / (wet - dry) == pytest.approx(half, abs=5e-4)


def test_saturated_conductivity_is_the_geometric_mean():
    """Quartz sand of 5.2 W/mK in 40 % water: 5.2^.6 .6^.4 = 2.19 (Oke: 2.2)."""
    assert conductivity(SAND, 0.4) == pytest.approx(2.19, abs=0.01)


def test_diffusivity_is_conductivity_over_capacity():
    """Van Genuchten (1980): D = K dh/dw, K by Mualem's law and w(h) by his retention curve, differentiated by steps."""
    for name, soil in TEXTURES.items():
        m = 1 - 1 / soil.n

        def water(suction, soil=soil, m=m):
            return soil.residual + (soil.saturated - soil.residual) * (1 + (soil.alpha * suction) ** soil.n) ** -m

        for suction in (0.5, 3.3, 30.0):
            share = (water(suction) - soil.residual) / (soil.saturated - soil.residual)
            flow = soil.flow * np.sqrt(share) * (1 - (1 - share ** (1 / m)) ** m) ** 2
            capacity = (water(0.999 * suction) - water(1.001 * suction)) / (0.002 * suction)
            assert diffusivity(name, water(suction)) == pytest.approx(flow / capacity, rel=2e-3)


def dried(texture, start, demand, days, cells=50, steps=288):
    """Evaporation by day [mm] of 0.1 m of soil that is closed below, by finite volumes of the integral of diffusivity
    over water, implicit by one Newton step: no law of a mean in it."""
    soil, width, step = TEXTURES[texture], DEPTH / cells, 86400.0 / steps
    grid = np.linspace(soil.residual, start, 4000)
    potential = np.concatenate([[0.0], np.cumsum(diffusivity(texture, 0.5 * (grid[1:] + grid[:-1])) * np.diff(grid))])
    water, lost = np.full(cells, start), []
    for _ in range(days * steps):
        flows, slopes = np.interp(water, grid, potential), diffusivity(texture, water)
        limited = flows[0] / (0.5 * width) > demand / 1000.0
        surface = demand / 1000.0 if limited else flows[0] / (0.5 * width)
        net = np.diff(np.concatenate([[surface], np.diff(flows) / width, [0.0]]))
        band = np.zeros((3, cells))
        each = slopes / width**2 * step
        band[0, 1:], band[2, :-1] = -each[1:], -each[:-1]
        band[1] = 1.0 + 2.0 * each
        band[1, -1] -= each[-1]
        band[1, 0] += -each[0] if limited else each[0]
        after = np.maximum(water + solve_banded((1, 1), band, net / width * step), soil.residual)
        lost.append((water - after).sum() * width * 1000.0)
        water = after
    return np.array(lost).reshape(days, steps).sum(axis=1)


# Ritchie (1972), Water Resour. Res. 8, 1204-1213, table 1: what a bare soil loses before it falls dry [mm], and
# what it loses then by the root of time [mm d^-1/2], from all its depth.
RITCHIE = {"sand": (6.0, 3.34), "loam": (9.0, 4.04), "clay": (6.0, 3.50)}


@pytest.mark.parametrize("texture", ["sand", "sandy_loam", "loam", "silt", "clay"])
def test_a_month_without_rain(texture):
    """From soil that has drained (Carsel and Parrish's at 1 m of suction, sand half full) under 5 mm a day: supply by
    the mean of 0.1 m is quick at first, for it has no memory of how dry the surface is; nowhere it is 4.5 mm (0.045
    m3/m3) from diffusion resolved in depth, nor 2.5 mm beyond what Ritchie's soils lose from all their depth."""
    soil = TEXTURES[texture]
    drained = soil.residual + (soil.saturated - soil.residual) * (1 + soil.alpha**soil.n) ** (1 / soil.n - 1)
    start, demand = max(drained, 0.2 if texture == "sand" else 0.0), 5.0 / 86400.0
    water, lost = start, []
    for _ in range(30 * 24):
        loss = min(demand, float(supply(texture, water))) * 3600.0
        water -= loss / (1000.0 * DEPTH)
        lost.append(loss)
    law, exact = np.cumsum(lost)[23::24], np.cumsum(dried(texture, start, demand, 30))
    print(texture, [f"day {d}: {law[d - 1]:.1f} {exact[d - 1]:.1f}" for d in (1, 2, 5, 10, 30)], f"{water:.3f}")
    assert np.all(law > exact - 0.1) and np.all(law < exact + 4.5)
    if texture in RITCHIE:
        first, by_root = RITCHIE[texture]
        days = np.arange(1, 31)
        assert np.all(law < first + by_root * np.sqrt(np.maximum(days - first / 5.0, 0.0)) + 2.5)


def test_sand_with_bound_water_alone_is_dry():
    """What Carsel and Parrish's sand cannot give (0.045) feeds nothing: its resistance keeps evaporation of a hot noon
    (20 g/m3 of deficit) below 0.3 W/m2, the law of van de Griend and Owe had 353 s/m."""
    assert 2.45e6 * 0.02 / resistance("sand", 0.05) < 0.3
    assert resistance("sand", 0.3) == pytest.approx(10.0, abs=0.6)
    assert dry_layer("sand", 0.045) == DEPTH and dry_layer("loam", 0.25) == 0.0
    drying = drying_moisture("loam")
    assert 86400 * supply("loam", drying) == pytest.approx(5.0)
    # Water of dry and of moist soil together is the water that there is.
    dry = dry_layer("loam", 0.15)
    assert dry * TEXTURES["loam"].residual + (DEPTH - dry) * drying == pytest.approx(0.15 * DEPTH)


def test_deeper_soil_keeps_the_water_that_it_has():
    material = load_library()["soil_sand"]
    before = material.thermal.layers[1]
    above, below = moist_stack(material.thermal, material.soil, 0.05).layers
    assert replace(below, thickness=0.9) == before and above.thickness + below.thickness == pytest.approx(1.0)
    assert replace(above, thickness=0.1) == material.thermal.layers[0]
    assert moist_stack(material.thermal, material.soil, 0.35).layers[1].density > before.density
    gravel = load_library()["ballast_granite"]
    assert moist_stack(gravel.thermal, gravel.soil, 0.26).layers[1] == gravel.thermal.layers[1]


def test_frozen_soil_conducts_as_cote_and_konrad_have_it():
    """A saturated sand of 40 % pores and grains of 3.0 W/m/K: 3^.6 2.24^.4 = 2.669 frozen, 3^.6 .6^.4 = 1.576 not; half
    full Kr = .95 / 1.95 and 3.55 / 4.55 of a dry .75 10^(-1.2 x .4) = .2483."""
    sand = Soil("sand", 0.4, 3.0, 1)
    saturated = 3.0**0.6 * np.array([2.24**0.4, 0.6**0.4])
    dry = 0.75 * 10 ** (-0.48)
    for frozen, whole, kappa in zip((True, False), saturated, (0.95, 3.55), strict=True):
        assert conductivity(sand, 0.4, frozen) == pytest.approx(whole)
        half = dry + (whole - dry) * kappa * 0.5 / (1 + (kappa - 1) * 0.5)
        assert conductivity(sand, 0.2, frozen) == pytest.approx(half)
        assert conductivity(sand, 0.0, frozen) == pytest.approx(dry)


def test_water_that_freezes_as_soil_cools_is_the_slope_of_what_stays_liquid():
    """Andersland and Anderson (1978), in volume fractions: ln w = ln dry density + .5519 ln S - 1.449 S^-.264 ln frost
    - 11.25; the heat of what freezes by its slope, taken by steps."""
    for texture, grains in (("silt", 18.0), ("loam", 40.0), ("clay", 60.0)):
        law = np.log(1500.0) + 0.5519 * np.log(grains) - 1.449 * grains**-0.264 * np.log(3.0) - 11.25
        assert unfrozen_water(texture, 1500.0, 3.0) == pytest.approx(np.exp(law), rel=2e-3)
    step = 1e-4
    freezes = unfrozen_water("silt", 1500.0, 4.0) - unfrozen_water("silt", 1500.0, 4.0 + step)
    assert freezing_capacity("silt", 1500.0, 0.3, 4.0) == pytest.approx(3.337e5 * 1e3 * freezes / step, rel=1e-3)
    assert freezing_capacity("clay", 1500.0, 0.05, 2.0) == 0.0  # all of it is liquid still
    assert freezing_capacity("silt", 1500.0, 0.3, 0.1) == freezing_capacity("silt", 1500.0, 0.3, 1.0)


def test_ice_in_the_pores_holds_half_the_heat_of_water():
    layer = Layer(0.1, 0.3, 1600.0, 800.0)
    stack, sand = (
        ThermalStack(Layer(0.002, 0.3, 1600.0, 800.0), (layer, layer), Back("fixed")),
        Soil("sand", 0.4, 3.0, 1),
    )
    ice, water = (moist_stack(stack, sand, 0.4, frost).layers[0] for frost in (6.0, 0.0))
    capacity = water.density * water.heat_capacity - ice.density * ice.heat_capacity
    assert capacity + freezing_capacity("sand", 1600.0, 0.4, 6.0) == pytest.approx(400 * (4180 - 2030))
