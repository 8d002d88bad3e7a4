"""Transfer coefficients of wind and of free convection against published laws and limits."""

import numpy as np
import pytest

from skyshine.mat.surface.convection import (
    TREE_ROUGHNESS,
    Wind,
    air_density,
    forced_coefficient,
    natural_coefficients,
)
from skyshine.materials.library import load_library
from skyshine.materials.records import SurfaceProperties


def surface(exposure, roughness_length):
    return SurfaceProperties(roughness_length, 0.0, 0.0, False, False, exposure)


SMOOTH = surface("plate", 1e-6)


@pytest.mark.parametrize("speed", [0.0, 1.0, 3.0, 10.0, 30.0])
def test_plate_in_wind(speed):
    """Jürges' smooth plate, 7.17 V^0.78 with V at the plate: 0.723 of the wind at 10 m."""
    value = forced_coefficient(Wind(speed), 101325.0, 293.15, SMOOTH)
    assert value == pytest.approx(7.17 * (0.723 * speed) ** 0.78, rel=3e-3)


def test_field_takes_the_logarithmic_law():
    """Short grass (z0 = 1 cm), wind at 10 m, air at 2 m: rho cp k^2 / (ln 1000 ln 1478) a m/s. With FAO Paper 56's
    r_a = 208 / u2 its grass of 12 cm has 11.7 W/m2K at 2 m/s; this one, shorter and so smoother, has less."""
    grass = surface("field", 0.01)
    value = forced_coefficient(Wind(2.0), 101325.0, 293.15, grass)
    assert value == pytest.approx(2 * 1.204 * 1013 * 0.16 / (np.log(1001) * np.log(1479)), rel=3e-3)
    fao = surface("field", 0.123 * 0.12)
    assert value < forced_coefficient(Wind(2.0, 2.0), 101325.0, 293.15, fao) == pytest.approx(11.7, rel=0.1)


def test_snow_has_less_than_a_plate():
    """Endless smooth ground builds a deep boundary layer, a plate of its roughness a thin one."""
    snow, plate = (forced_coefficient(Wind(1.3), 9e4, 265.0, surface(kind, 5e-4)) for kind in ("field", "plate"))
    assert 2.5 < plate / snow < 2.9


@pytest.mark.parametrize("exposure", ["field", "plate", "roof", "wall"])
def test_the_same_wind_measured_lower_is_the_same_wind(exposure):
    """At 2 m over open ground (z0 3 cm) an anemometer reads 0.723 of that at 10 m; FAO Paper 56, eq. 47, whose grass is
    smoother, says 0.748."""
    ground = surface(exposure, 0.03)
    high, low = (
        forced_coefficient(Wind(speed, height), 1e5, 290.0, ground) for speed, height in ((4.0, 10.0), (2.892, 2.0))
    )
    assert low == pytest.approx(high, rel=5e-3)
    assert Wind(1.0, 10.0).at(2.0) == pytest.approx(0.748, abs=0.03)


def test_wall_between_windward_and_lee():
    """Yazdanian and Klems (1994): 3.26 V^0.89 and 3.55 V^0.617 on smooth glass; 5 m/s: 13.66 and 9.59 W/m2K."""
    value = forced_coefficient(Wind(5.0), 101325.0, 293.15, surface("wall", 1e-5))
    assert value == pytest.approx(0.5 * (13.66 + 9.59), rel=2e-3)


@pytest.mark.parametrize("exposure", ["roof", "wall"])
@pytest.mark.parametrize("length, multiplier", [(1e-4, 1.11), (1e-3, 1.52), (2e-3, 1.67), (1e-2, 2.17), (1.0, 2.17)])
def test_rough_building_surfaces_have_walton_s_multipliers(exposure, length, multiplier):
    """Smooth plaster 1.11, concrete 1.52, brick 1.67, stucco 2.17 over glass; nothing goes beyond stucco's."""
    glass, rough = (forced_coefficient(Wind(5.0), 101325.0, 293.15, surface(exposure, z)) for z in (1e-5, length))
    assert rough / glass == pytest.approx(multiplier)


def test_three_metres_make_a_tree():
    """Oke (1987): a tenth of the height; crops and shrubs below it have the stability of the surface layer."""
    library = load_library()
    trees = {name for name in library.names if library[name].surface.canopy} & {
        name for name in library.names if library[name].surface.roughness_length > TREE_ROUGHNESS
    }
    assert trees == {"conifer", "deciduous", "deciduous_leafless"} and abs(TREE_ROUGHNESS - 0.1 * 3.0) < 1e-12


def test_roof_by_the_textbook_s_turbulent_plate():
    """Incropera's Nu = 0.0296 Re^(4/5) Pr^(1/3), 5 m from the edge in 5 m/s: Re = 1.663e6, Nu = 2502, 12.9 W/m2K."""
    value = forced_coefficient(Wind(5.0, 6.0), 101325.0, 293.15, surface("roof", 1e-5))
    assert value == pytest.approx(2502 * 0.0257 / 5, rel=2e-3)


def test_natural_convection_by_tilt():
    """A wall does not care which way heat flows; a warm roof loses twice what a cold one takes."""
    warmer, colder = natural_coefficients(np.array([1.0, 0.0, -1.0]), 101325.0, SMOOTH)
    assert warmer[0] == pytest.approx(1.52, abs=5e-3)
    assert colder[0] == pytest.approx(0.76, abs=5e-3)
    assert warmer[1] == pytest.approx(colder[1], rel=1e-3)
    assert (warmer[2], colder[2]) == (pytest.approx(colder[0]), pytest.approx(warmer[0]))


def test_cold_ground_sheds_air_along_its_slope_alone():
    """A plate loses cold air over its edges; ground has none. As a wall at 90 degrees, a third of it at 30."""
    ground, trees = surface("field", 0.01), surface("field", 1.0)
    cosines = np.cos(np.radians([0.0, 30.0, 90.0, 150.0, 180.0]))
    warmer, colder = natural_coefficients(cosines, 101325.0, ground)
    plate_warmer, plate_colder = natural_coefficients(cosines, 101325.0, SMOOTH)
    assert colder[0] == 0.0 and colder[1:3] == pytest.approx(plate_colder[2] * np.array([1 / 3, 1.0]))
    assert warmer == pytest.approx(plate_warmer) and colder[3:] == pytest.approx(plate_colder[3:])
    assert natural_coefficients(1.0, 101325.0, trees)[1] == pytest.approx(plate_colder[0])


def test_a_rough_plate_has_the_larger_constant():
    """McAdams' table: 0.53 rough over 0.50 smooth, from a roughness of a thirtieth of a millimetre on."""
    smooth, rough = (
        forced_coefficient(Wind(5.0), 101325.0, 290.0, surface("plate", length)) for length in (2.9e-5, 3.1e-5)
    )
    assert rough / smooth == pytest.approx(0.53 / 0.50, rel=1e-9)


def test_thin_air_transfers_less():
    """A turbulent plate goes with density^0.8, the logarithmic law with density, free convection with density^(2/3)."""
    half = 0.5 * 101325.0
    plate = [forced_coefficient(Wind(5.0), pressure, 290.0, SMOOTH) for pressure in (half, 101325.0)]
    canopy = surface("field", 0.05)
    log_law = [forced_coefficient(Wind(5.0), pressure, 290.0, canopy) for pressure in (half, 101325.0)]
    free = [natural_coefficients(1.0, pressure, SMOOTH)[0] for pressure in (half, 101325.0)]
    assert plate[0] / plate[1] == pytest.approx(0.5**0.8)
    assert log_law[0] / log_law[1] == pytest.approx(0.5)
    assert free[0] / free[1] == pytest.approx(0.5 ** (2 / 3))


def test_density_of_dry_air():
    """ISO 2533: 1.225 kg/m3 at 15 C and 101325 Pa; 8 % more at the Dead Sea's 106.5 kPa and 25 C than at 35 C and sea
    level."""
    assert air_density(101325.0, 288.15) == pytest.approx(1.225, abs=5e-5)
    assert air_density(106.5e3, 298.15) / air_density(101325.0, 308.15) == pytest.approx(1.0864, abs=1e-3)
