"""What `mat check` says where tilted faces have no ground."""

import re

import numpy as np
import pytest

import skyshine.mat

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


def test_check_says_by_how_much_a_ground_changes_walls():
    (line,) = notes(job())
    assert "state 1 names no ground_material" in line and "with asphalt_road those of 90 degrees" in line
    stated = [float(text) for text in re.search(r"by (\S+) to (\S+) K", line).groups()]
    changes = [
        np.subtract(
            *(
                skyshine.mat.temperature(name, job=given, slope=90, azimuth=azimuth).temperature
                for given in (job(ground_material="asphalt_road"), job())
            )
        )
        for name in MATERIALS
        for azimuth in (0, 90, 180, 270)
    ]
    assert stated == pytest.approx([np.min(changes), np.max(changes)], abs=0.2)
    assert stated[1] > 2


def test_nothing_is_said_where_the_ground_is_named_or_all_is_level():
    assert notes(job(ground_material="asphalt_road")) == []
    assert notes(job() | {"surface_grid": {"slope_deg": [0], "altitude_km": [0]}}) == []


def test_faces_that_are_all_tilted_see_ground_too():
    (line,) = notes(job() | {"surface_grid": {"slope_deg": [90], "altitude_km": [0]}})
    assert "those of 90 degrees" in line
