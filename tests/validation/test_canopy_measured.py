"""Gaps between leaves against measured radiometric temperatures, with leaf areas from books and from the site, none
fitted: the closed stand beside the open one.

A pyrgeometer looks at a hemisphere: leaves and soil count by the gaps of all directions, not by those seen from above.
"""

from dataclasses import replace

import numpy as np
import pytest
import test_surface_measured as measured_sets

from skyshine.mat.atmosphere.sources.ephemeris import position
from skyshine.mat.scene.moisture import open_library
from skyshine.mat.scene.surface import surface_materials
from skyshine.mat.surface import column
from skyshine.mat.surface.canopy import gap_to_sky
from skyshine.mat.surface.weather import DRY
from skyshine.materials.library import load_library

pytestmark = [pytest.mark.validation, pytest.mark.shared_data]


def open_stand(name, leaf_area_index):
    (found,) = surface_materials([open_library(load_library(), ((name, leaf_area_index),))[name]])
    return found


@pytest.fixture
def hemisphere(monkeypatch):
    """Records of open stands with the Sun of a place, their temperature that of a hemisphere."""
    place = {}
    solve = column.from_record

    def from_record(material, record, slope, azimuth, sun, ground_albedo):
        if material.canopy is None:
            return solve(material, record, slope, azimuth, sun, ground_albedo)

        def sun_at(times):
            there = position("sun", times.astype("datetime64[s]"), place["latitude"], place["longitude"], 0.0)
            return there.elevation, there.azimuth

        found = solve(material, record, slope, azimuth, sun_at, ground_albedo)
        gap = gap_to_sky(material.canopy.leaf_area)
        mean = (1 - gap) * found.leaf_temperature**4 + gap * found.soil_temperature**4
        return replace(found, temperature=mean**0.25)

    monkeypatch.setattr(column, "from_record", from_record)
    return place


def test_grass_of_payerne_on_watered_ground(shared_data, tmp_path, hemisphere):
    """A rainy June: reference grass of FAO Paper 56 (2.88) over loam at field capacity is nearer than a closed skin."""
    hemisphere.update(latitude=46.815, longitude=6.944)
    measured = measured_sets.bsrn(shared_data / "heat" / "bsrn" / "bsrn-pay0616.dat.gz")
    absorptance = 1 - measured_sets.albedo(measured)
    closed = measured_sets.canopy("closed grass", "grass_green", solar_absorptance=absorptance)
    grass = open_stand("grass_green", "library").with_optics(solar_absorptance=absorptance)
    before, _ = measured_sets.compare(closed, measured, tmp_path, heights=(2.0, 2.0))
    after, _ = measured_sets.compare(grass, measured, tmp_path, heights=(2.0, 2.0))
    assert after < 1.05 and after < 0.9 * before


@pytest.mark.parametrize(("leaf_area_index", "limit"), [("library", 0.9), (2.2, 1.2), (2.0, 1.35)])
def test_oaks_of_puechabon(shared_data, tmp_path, hemisphere, leaf_area_index, limit):
    """The site gives 2.0 to 2.2 for its leaves, without wood. With that, dry litter is seen too hot by day: the closed
    stand is nearer. A stand of the library's leaf area is as near as the closed one."""
    hemisphere.update(latitude=43.741, longitude=3.596)
    material, measured = measured_sets.oaks_of_puechabon(shared_data, DRY)
    stand = open_stand("deciduous", leaf_area_index)
    leaves = replace_surface(stand.canopy.leaves, material.surface)
    opened = replace_surface(stand, material.surface, leaves)
    closed, _ = measured_sets.compare(material, measured, tmp_path)
    rms, air = measured_sets.compare(opened, measured, tmp_path)
    assert rms < limit and (leaf_area_index != "library" or rms < 1.02 * closed)
    assert np.isfinite(air)


def test_meadow_of_caldern(shared_data, tmp_path, hemisphere):
    """A calm day of summer in a forest, whose closed skin is too cold by day: over loam at field capacity it is warmer.
    How wet that ground was is not known."""
    hemisphere.update(latitude=50.84, longitude=8.68)
    measured = measured_sets.caldern(shared_data)
    absorptance = 1 - measured_sets.albedo(measured)
    grass = open_stand("grass_green", "library").with_optics(solar_absorptance=absorptance)
    rms, _ = measured_sets.compare(grass, measured, tmp_path)
    assert rms < 1.8


def replace_surface(material, surface, leaves=None):
    canopy = material.canopy if leaves is None else replace(material.canopy, leaves=leaves)
    return replace(material, surface=surface, canopy=canopy)
