"""Temperatures under shade from the response of a file against whole solutions, on random faces of all materials.

Run ``pytest -m validation tests/validation/test_shade_response.py -s`` to see the errors by material.
"""

from collections import defaultdict

import numpy as np
import pytest
from numpy_response import StoredResponse

from skyshine.mat.job.load import load_job
from skyshine.mat.scene.surface import scene_inputs, surface_materials
from skyshine.mat.surface.back_boundary import BackFlux
from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.conduction import Conduction
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.relaxation import melting_cap
from skyshine.mat.surface.response import response_table
from skyshine.mat.surface.response_nodes import LAG_STARTS, OFFSETS
from skyshine.mat.surface.solver import DAY, FINE_STEPS, bound_excess, solve_columns
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.mat.tables.axes import AxisRule
from skyshine.materials.library import load_library

pytestmark = pytest.mark.validation

COLUMNS = 200
RMS, BOUND = 0.5, 0.12  # K
# Snow and ice that melt: on another face than the stored ones another heat goes into melting, so that reads end it too
# early. Closed grass in calm air, between stored altitudes 1 km apart (0.25 K with 0.5 km, in files twice as large);
# coal there, which shade changes by 47 K.
BEYOND = {"snow_melting": 1.2, "melt_pond": 3.0, "grass_green": 0.57, "coal": 0.67}
MELTING_BOUND = 4.2  # K: of snow that the shade keeps from melting, or melts elsewhere than in the sunlight
ALTITUDES = np.array([0.0, 1.0, 3.0])  # km
JOB = {
    "skyshine": 1,
    "name": "shade",
    "site": {"latitude_deg": 35, "longitude_deg": -115, "date": "2026-06-21", "utc_offset_h": -8},
    "bands": [{"wavelength_um": [8, 12]}],
    "materials": "all",
    "states": [
        {"profile": "midlatitude_summer", "weather": {"air_temperature_c": [19, 38], "wind_speed_m_s": 3}},
        {
            "profile": "midlatitude_summer",
            "weather": {"air_temperature_c": [22, 33], "relative_humidity_percent": 80, "wind_speed_m_s": 1},
        },
        {"profile": "midlatitude_winter", "weather": {"air_temperature_c": [-12, -3], "wind_speed_m_s": 6}},
        {
            "profile": "midlatitude_summer",
            "date": "2026-10-01",
            "weather": {"air_temperature_c": [8, 20], "cloud_fraction": 0.5, "wind_speed_m_s": 2},
        },
    ],
}


def _solved(material, scene):
    ((_, solution),) = solve_columns(material, scene.forcing, steps=FINE_STEPS)
    return solution


def _beyond_the_bounds(material, scene, temperature):
    """How far temperatures leave what the maximum principle allows a whole solution [K]."""
    forcing = scene.forcing(FINE_STEPS)
    conduction = Conduction(material.thermal, FINE_STEPS, DAY)
    back = BackFlux.of(material, forcing, conduction, np.arange(FINE_STEPS) * 24.0 / FINE_STEPS)
    balance = Balance(forcing, material)
    return float(bound_excess(balance, temperature, balance.loss(temperature), back, melting_cap(material))[0])


@pytest.fixture(scope="module")
def errors():
    """By material: change of temperature, rms and largest error, excess over the bounds, whether it melts."""
    job = load_job(JOB).trimmed
    library = load_library()
    materials = surface_materials(list(library))
    draw = np.random.default_rng(15)
    by_material = defaultdict(list)
    states = []
    for state in range(1, 5):
        inputs = scene_inputs(job, state)
        scene = Scene(*inputs, 1e3 * ALTITUDES[[0, -1]], np.array([0.0, 180.0]), np.zeros(2))
        states.append((inputs, scene))
    order = [*draw.permutation(len(materials)), *draw.integers(len(materials), size=COLUMNS - len(materials))]
    for number in order:
        material, (inputs, scene) = materials[number], states[draw.integers(4)]
        table = response_table([material], scene)
        response = StoredResponse(
            AxisRule("altitude", table.altitudes_m / 1e3),
            AxisRule("slope", table.slopes_deg),
            LAG_STARTS,
            OFFSETS,
            *(table.kernel, table.temperature, table.loss_slope, table.loss_excess, table.melt),
        )
        altitude, slope = draw.uniform(0, 3), draw.choice([0.0, 90.0, draw.uniform(0, 180)])
        first = draw.uniform(0, 24)
        around = Surroundings(
            [((0.0, 24.0),), ((first, (first + draw.uniform(0.3, 10)) % 24.0),)][draw.integers(2)],
            draw.choice([1.0, draw.uniform(0.2, 0.9)]),
        )
        place = np.array([1e3 * altitude]), np.array([slope]), draw.uniform(0, 360, 1)
        sunlit, shaded = Scene(*inputs, *place), Scene(*inputs, *place, around)
        start, whole = _solved(material, sunlit), _solved(material, shaded)
        heat = (Balance(face.forcing(FINE_STEPS), material).absorbed for face in (shaded, sunlit))
        columns = response.columns(np.array([0]), np.array([altitude]), np.array([slope]))
        read = start.temperature + columns.change(np.subtract(*heat), start.temperature, table.highest.astype(float))
        read = np.minimum(read, np.maximum(table.highest[0], start.temperature))
        error = read - whole.temperature
        by_material[material.name].append(
            (
                np.abs(whole.temperature - start.temperature).max(),
                np.sqrt(np.mean(error**2)),
                np.abs(error).max(),
                _beyond_the_bounds(material, shaded, read),
                bool(np.any(start.melt > 0) or np.any(whole.melt > 0)),
            )
        )
    print(f"\n{'material':34} columns  change [K]  rms [K]  largest [K]  beyond bounds [K]")
    for name, rows in sorted(by_material.items(), key=lambda item: -max(row[1] for row in item[1])):
        change, rms, largest, beyond, melts = np.array(rows, float).max(axis=0)
        words = "  melts" if melts else ""
        print(f"{name:34} {len(rows):7}  {change:10.1f}  {rms:7.3f}  {largest:11.2f}  {beyond:17.3f}{words}")
    return by_material


def test_every_column_is_within_half_a_kelvin(errors):
    missed = {
        name: max(row[1] for row in rows)
        for name, rows in errors.items()
        if any(row[1] > BEYOND.get(name, RMS) for row in rows)
    }
    assert not missed
    assert sum(len(rows) for rows in errors.values()) == COLUMNS
    assert max(row[0] for rows in errors.values() for row in rows) > 25  # K: the changes are large


def test_no_column_leaves_the_bounds_of_the_maximum_principle(errors):
    beyond = [(row[3], row[4]) for rows in errors.values() for row in rows]
    assert max(excess for excess, melts in beyond if not melts) < BOUND
    assert max(excess for excess, melts in beyond if melts) < MELTING_BOUND
