"""Typical aerosol by place and month."""

import datetime

import numpy as np
import pvlib
import pytest

from skyshine.mat.atmosphere.state.turbidity import LEAST_DEPTH, aerosol_depth, typical_aerosol

JULY, JANUARY = datetime.date(2026, 7, 20), datetime.date(2026, 1, 20)


@pytest.mark.parametrize("water", [5.0, 15.0, 30.0])
@pytest.mark.parametrize("depth", [0.05, 0.2, 0.5])
def test_the_turbidity_of_kasten_gives_the_depth_back(water, depth):
    """Kasten's pyrheliometric formula as pvlib has it, whose broadband depth is that at 0.7 um (Molineaux et al. 1998);
    Angstrom exponent 1.3. The conversion is a fit.
    """
    broadband = depth * (0.7 / 0.55) ** -1.3
    turbidity = float(pvlib.atmosphere.kasten96_lt(2.0, water / 10, broadband))
    assert aerosol_depth(turbidity, water, 101325.0) == pytest.approx(depth, abs=0.02 + 0.05 * depth)


def test_depth_of_a_place_and_month():
    """Linke turbidity of the map (pvlib), the whole month alike; dust of the Sahel, clean air of high mountains."""
    berlin = typical_aerosol(52.5, 13.4, 40.0, JULY)
    assert berlin == typical_aerosol(52.5, 373.4, 40.0, JULY.replace(day=1))
    assert berlin.month == 7 and 2 < berlin.linke_turbidity < 6 and 10 < berlin.water_vapour < 35
    assert 0.1 < berlin.optical_depth < 0.3
    assert typical_aerosol(52.5, 13.4, 40.0, JANUARY).optical_depth < berlin.optical_depth
    assert typical_aerosol(13.54, 2.66, 250.0, datetime.date(2026, 3, 15)).optical_depth > 0.35
    assert LEAST_DEPTH <= typical_aerosol(19.54, -155.58, 3397.0, JULY).optical_depth < 0.05


def test_every_place_has_a_depth():
    for latitude, longitude in ((90.0, 180.0), (-90.0, -180.0), (0.0, 0.0), (-54.8, -68.3)):
        typical = typical_aerosol(latitude, longitude, 0.0, JULY)
        assert np.isfinite(typical.optical_depth) and typical.optical_depth >= LEAST_DEPTH


def test_water_and_pressure_count_as_published():
    """Ineichen 2008: turbidity grows by 0.376 of the logarithm of the water vapour, and by 3.91 exp(0.689 p0/p) of the
    optical depth: 7.79 at sea level, 10.2 at 0.72 of its pressure.
    """
    for pressure, slope in ((101325.0, 7.788), (0.72 * 101325.0, 10.18)):
        water = aerosol_depth(4.0, 4.0, pressure) - aerosol_depth(4.0, 40.0, pressure)
        turbidity = aerosol_depth(4.0, 10.0, pressure) - aerosol_depth(3.0, 10.0, pressure)
        assert water == pytest.approx(0.376 * 2.302585 / slope, rel=1e-3)
        assert turbidity == pytest.approx(1 / slope, rel=1e-3)
