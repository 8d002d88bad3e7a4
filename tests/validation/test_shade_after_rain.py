"""Temperatures under shade on rainy days from the response of a file, against whole solutions with the shade's light.

Run ``pytest -m validation tests/validation/test_shade_after_rain.py -s`` to see the errors by material.
"""

import numpy as np
import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.products.shade_error import stored_response
from skyshine.mat.scene.surface import scene_inputs, surface_materials
from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.response import response_table
from skyshine.mat.surface.solver import FINE_STEPS, solve_columns
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.materials.library import load_library

pytestmark = pytest.mark.validation

NAMES = [
    "asphalt_road",
    "concrete",
    "grass_green",
    "soil_sand",
    "paint_green_on_metal",
    "galvanised_weathered",
    "roof_tile_terracotta",
]
HOURS = range(24)
RAINS = {
    "noon shower": [4.0 if hour in (12, 13) else 0.0 for hour in HOURS],
    "night drizzle": [0.3 if hour in (1, 2, 3, 4) else 0.0 for hour in HOURS],
    "no rain": [0.0] * 24,
}
SHADES = [
    Surroundings(((10.0, 15.0),)),
    Surroundings(((0.0, 24.0),), 0.5),
    Surroundings(((6.0, 12.5),)),
]
FACES = [(0.0, 180.0), (30.0, 90.0)]  # degree: slope and azimuth
ALTITUDE = np.array([300.0])  # m
# With the film of open ground the same cases err by 25 K at most, 1.6 K rms after the shower and by 11 and 0.9 K after
# drizzle; a day without rain by 1.9 K at most.
LARGEST, RMS = 2.5, 0.25  # K


def rainy_job(rain):
    air = [round(18 + 7 * float(np.cos(2 * np.pi * (hour - 15) / 24)), 2) for hour in HOURS]
    hourly = {"time": [f"{hour:02d}:00" for hour in HOURS], "air_temperature_c": air, "rain_mm_h": rain}
    weather = {"hourly": hourly, "relative_humidity_percent": 70, "wind_speed_m_s": 2.5}
    return {
        "skyshine": 1,
        "name": "rain",
        "site": {"latitude_deg": 45, "longitude_deg": 5, "date": "2026-06-28", "utc_offset_h": 2},
        "states": [{"profile": "midlatitude_summer", "weather": weather}],
        "bands": [],
        "materials": "all",
    }


def solved(material, scene):
    ((_, solution),) = solve_columns(material, scene.forcing, steps=FINE_STEPS)
    return solution


@pytest.fixture(scope="module", params=list(RAINS))
def errors(request):
    """By material: errors of the reading (faces x shades, FINE_STEPS) and change that the shade makes [K]."""
    job = load_job(rainy_job(RAINS[request.param])).trimmed
    inputs = scene_inputs(job, 1)
    library = load_library()
    by_material = {}
    for material in surface_materials([library[name] for name in NAMES], None, inputs[1].wetting):
        table = response_table([material], Scene(*inputs, ALTITUDE, np.array([0.0, 90.0]), np.zeros(2)))
        response, rows, changes = stored_response(table), [], []
        for slope, azimuth in FACES:
            place = ALTITUDE, np.array([slope]), np.array([azimuth])
            sunlit = Scene(*inputs, *place)
            start, columns = solved(material, sunlit), response.columns(np.array([0]), ALTITUDE / 1e3, place[1])
            for shade in SHADES:
                shaded = Scene(*inputs, *place, shade)
                heat = (Balance(face.forcing(FINE_STEPS), material).absorbed for face in (shaded, sunlit))
                whole = solved(material, shaded).temperature
                change = columns.change(np.subtract(*heat), start.temperature, table.highest.astype(float))
                rows.append((start.temperature + change - whole)[0])
                changes.append((whole - start.temperature)[0])
        by_material[material.name] = np.array(rows), np.array(changes)
    print(f"\n{request.param:22} change [K]  rms [K]  largest [K]")
    for name, (error, change) in by_material.items():
        print(f"{name:22} {np.abs(change).max():10.1f}  {np.sqrt(np.mean(error**2)):7.3f}  {np.abs(error).max():11.2f}")
    return by_material


def test_shade_is_as_exact_on_wet_surfaces_as_on_dry_ones(errors):
    everything = np.concatenate([error for error, _ in errors.values()])
    assert np.sqrt(np.mean(everything**2)) < RMS
    assert np.abs(everything).max() < LARGEST
    assert max(np.abs(change).max() for _, change in errors.values()) > 15  # K: shade matters
