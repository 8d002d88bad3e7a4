"""Spectra of arrays of lines of sight: dimensions, numbers, what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray

import skyshine.mat
from skyshine.schemas.errors import InputError

BINS = {"wavenumber": (2500, 2505)}  # sunlight and emission
RADIANCES = ("path_thermal", "path_scattered", "sky_irradiance", "direct_irradiance")


@pytest.fixture(scope="module")
def lines():
    return skyshine.mat.spectrum(
        **BINS, visibility_km=[5, 50], altitude=0.5, elevation=np.array([-30.0, 0.0, 60.0]), range=(2, "space")
    )


def test_an_array_is_a_dimension(lines):
    assert lines.dims == (
        "visibility_km",
        "elevation",
        "range",
        "wavenumber",
    ) and "2 visibility_km x 3 elevation" in repr(lines)
    data = lines.to_xarray()
    assert data.transmittance.dims == lines.dims and data.transmittance.shape == (2, 3, 2, 1)
    assert data.elevation.units == "degree" and data.range.units == "km" and math.isinf(data.range[1])
    assert data.path_length.sel(elevation=-30, range=math.inf).values == pytest.approx(
        1.0, rel=2e-3
    )  # 0.5 km, 30 degrees
    assert data.ends_at_ground.sel(elevation=-30).all() and not data.ends_at_ground.sel(elevation=60).any()


@pytest.mark.parametrize(
    ("row", "visibility", "elevation", "distance"), [((0, 2, 1), 5, 60.0, "space"), ((1, 1, 0), 50, 0.0, 2)]
)
def test_each_line_is_that_computed_alone(lines, row, visibility, elevation, distance):
    alone = skyshine.mat.spectrum(**BINS, visibility_km=visibility, altitude=0.5, elevation=elevation, range=distance)
    np.testing.assert_allclose(lines.transmittance[row], alone.transmittance, rtol=1e-9)
    np.testing.assert_allclose(lines.transmittance_by_gas["CO2"][row], alone.transmittance_by_gas["CO2"], rtol=1e-9)
    for name in RADIANCES:
        np.testing.assert_allclose(getattr(lines, name)[row], getattr(alone, name), rtol=1e-3, err_msg=name)
    assert lines.range[row] == alone.range and lines.ground[row] == alone.ground


def test_numbers_of_other_libraries():
    line = skyshine.mat.spectrum(
        **BINS, source="none", altitude=np.int8(1), elevation=xarray.DataArray([-1.0, 2.0]), range=np.float32(2)
    )
    assert line.dims == ("elevation", "wavenumber") and line.range.tolist() == [2000.0, 2000.0]
    assert "elevation:\n- -1.0\n- 2.0\n" in line.attributes["job"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"elevation": [[1, 2]]}, r"found elevation of shape \(1, 2\); allowed: a number or a one-dim"),
        ({"elevation": []}, r"of shape \(0,\)"),
        ({"elevation": np.ma.array([1.0, 2.0], mask=[False, True])}, "found elevation nan"),
        ({"range": [1, -1]}, "found the range -1.0; allowed: at least 0 km, or 'space'"),
        ({"range": ["far"]}, "allowed: numbers"),
        ({"visibility_km": [10, math.inf]}, "found visibility_km inf"),
        ({"visibility_km": [10, 0]}, "visibility_km: found 0.0; input should be greater than or equal to 0.1"),
        ({"elevation": [5, -5]}, "found elevation -5 of an observer on the ground at 0 km"),
        ({"altitude": [0, 1], "elevation": -5.0}, "found elevation -5 of an observer on the ground"),
        ({"altitude": [1, -1]}, "is below the ground"),
        ({"source_elevation": [10, 20]}, "allowed: a number"),
    ],
)
def test_arrays_that_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        skyshine.mat.spectrum(**BINS, **arguments)


def test_a_path_of_no_length_may_look_down_from_the_ground():
    assert skyshine.mat.spectrum(**BINS, elevation=-5, range=0).transmittance == 1


def test_several_lines_are_no_file(lines, tmp_path):
    with pytest.raises(InputError, match="over visibility_km, elevation, range; allowed: a single"):
        lines.save(tmp_path / "lines.h5")
