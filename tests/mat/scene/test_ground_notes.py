"""What `mat check` says where tilted faces have no ground."""

import re

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.job.load import load_job
from skyshine.mat.scene import notes as surface_notes
from skyshine.materials.library import load_library

MATERIALS = ["concrete_wall", "asphalt_road"]


def job(**keys):
    state = {"profile": "midlatitude_summer", "weather": {"air_temperature_c": [14, 28]}} | keys
    return {
        "skyshine": 1,
        "name": "ground",
        "site": {"latitude_deg": 45, "longitude_deg": 5, "date": "2026-06-28", "utc_offset_h": 2},
        "states": [state],
        "bands": [],
        "materials": MATERIALS,
        "surface_grid": {"slope_deg": [0, 90], "altitude_km": [0]},
    }


def notes(given):
    return [line for line in skyshine.mat.check(given).surfaces if line.startswith("ground:")]


@pytest.mark.validation  # 6 s
def test_check_says_by_how_much_a_ground_changes_walls():
    walls = ["concrete_wall", "brick_red"]
    (line,) = notes(job() | {"materials": walls})
    assert "state 1 names no ground_material" in line and "with soil_loam_brown those of 90 degrees" in line
    stated = [float(text) for text in re.search(r"by (\S+) to (\S+) K", line).groups()]
    changes = [
        np.subtract(
            *(
                skyshine.mat.temperature(name, job=given | {"materials": walls}, slope=90, azimuth=azimuth).temperature
                for given in (job(ground_material="soil_loam_brown"), job())
            )
        )
        for name in walls
        for azimuth in (0, 90, 180, 270)
    ]
    assert stated == pytest.approx([np.min(changes), np.max(changes)], abs=0.2)
    assert stated[1] > 2


def test_the_first_level_material_of_a_list_is_the_ground_and_named_in_the_check():
    (line,) = notes(job())
    assert line.startswith("ground: state 1: asphalt_road is taken as ground, first of materials that lies level")
    named, taken = (
        skyshine.mat.temperature("concrete_wall", job=given, slope=90, azimuth=180).temperature
        for given in (job(ground_material="asphalt_road"), job())
    )
    np.testing.assert_array_equal(named, taken)


@pytest.mark.parametrize(
    ("materials", "ground"),
    [
        (["conifer", "concrete_wall"], None),
        ("all", None),
        (["conifer", "concrete_wall", "grass_green", "asphalt_road"], "grass_green"),
    ],
)
def test_no_tree_and_no_wall_is_ground(materials, ground):
    assert load_job(job() | {"materials": materials}).trimmed.states[0].ground_material == ground


def test_nothing_is_said_where_the_ground_is_named_or_all_is_level():
    assert notes(job(ground_material="asphalt_road")) == []
    assert notes(job() | {"surface_grid": {"slope_deg": [0], "altitude_km": [0]}}) == []


@pytest.mark.validation  # 5 s
def test_faces_that_are_all_tilted_see_ground_too():
    (line,) = notes(job() | {"surface_grid": {"slope_deg": [90], "altitude_km": [0]}})
    assert "those of 90 degrees" in line


@pytest.mark.validation  # 9 s
def test_of_all_materials_few_have_the_ends_of_the_change():
    library = load_library()
    names = [material.name for material in library]
    given = load_job(job() | {"materials": ["concrete_wall", "brick_red"]}).trimmed
    assert len(surface_notes._extremes(library, names)) < 45 < len(names)
    ends = []
    for start in range(0, len(names), 25):  # few enough that all of them are solved
        (line,) = surface_notes._without_ground(given, ["soil_loam_brown", *names[start : start + 25]])
        ends += [float(text) for text in re.search(r"by (\S+) to (\S+) K", line).groups()]
    (line,) = surface_notes._without_ground(given, ["soil_loam_brown", *names])
    stated = [float(text) for text in re.search(r"by (\S+) to (\S+) K", line).groups()]
    assert stated == pytest.approx([min(ends), max(ends)], abs=0.3)
