"""What leaving out saves on the starter job and on states at the edges, and that no answer changes by more than the
plan says.
"""

import json

import pytest
import yaml
from click.testing import CliRunner

from mat.maintain.bench.leaving_out import leaving_out
from skyshine.mat.cli import main
from skyshine.schemas.documents import read_yaml

pytestmark = pytest.mark.validation

WEATHER = {"air_temperature_c": 10}
STATES = {
    "hazy": [{"profile": "tropical", "visibility_km": 5, "aerosol": "maritime", "weather": {"air_temperature_c": 28}}],
    "cloudy": [
        {
            "profile": "midlatitude_summer",
            "clouds": [{"type": "stratus"}, {"phase": "ice", "height_km": [9, 10], "optical_depth": 1e-6}],
            "weather": WEATHER,
        }
    ],
    "fog": [{"profile": "midlatitude_summer", "aerosol": "fog_advection", "visibility_km": 0.1, "weather": WEATHER}],
    "polar night": [{"profile": "subarctic_winter", "surface_albedo": 0.6, "weather": {"air_temperature_c": -45}}],
}


def starter(folder, changes):
    """A starter job without its texture, changed."""
    CliRunner().invoke(main, ["init", str(folder)], standalone_mode=False, catch_exceptions=False)
    job = dict(read_yaml(folder / "job.yaml").data)
    job.pop("textures")
    job |= {"materials": ["asphalt_road", "grass_green", "conifer"], **changes}
    (folder / "job.yaml").write_text(yaml.safe_dump(job), encoding="utf-8")
    return folder / "job.yaml"


def measured(file):
    done = CliRunner().invoke(leaving_out, [str(file), "--json"], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    found = json.loads(done.output)
    less = {name: found["as_it_is"][name]["value"] / found["whole"][name]["value"] for name in ("time", "size")}
    worst = max(found["differences"].items(), key=lambda item: item[1]["largest"] / item[1]["bound"])
    print(f"\nshare of the whole: {less}; nearest to its bound: {worst}")
    assert all(each["largest"] <= each["bound"] for each in found["differences"].values())
    return less, found["differences"]


def test_starter_with_and_without_what_its_needs_leave(tmp_path):
    needs = {
        "range_km": [0.5, 8],
        "observer_altitude_km": [2.2, 4],
        "elevation_deg": [-90, -5],
        "bands": ["b02"],
        "hours": ["23:00", "03:00"],
    }
    less, differences = measured(starter(tmp_path / "demo", {"needs": needs}))
    assert less["size"] < 0.3 and less["time"] < 0.7
    assert {name.split(":")[0] for name in differences} == {"s01b02.lunar_atmq.h5", "s01.htt.h5"}


def test_starter_with_and_without_moonlight_in_the_air(tmp_path):
    less, differences = measured(starter(tmp_path / "demo", {}))
    assert less["size"] < 1 and less["time"] < 1
    assert differences["s01b02.lunar_atmq.h5: path_radiance_ratio, K"]["largest"] > 0


def test_starter_with_and_without_sunlight_in_the_air(tmp_path):
    _, differences = measured(
        starter(tmp_path / "demo", {"bands": [{"wavelength_um": [8, 12]}], "accuracy": {"negligible_k": 0.8}})
    )
    assert differences["s01b01.atmq.h5: path_radiance_ratio, K"]["largest"] > 0.01


@pytest.mark.parametrize("name", STATES)
def test_edges_with_and_without(tmp_path, name):
    """An observer at the top of the air, ranges through all of it, and a tolerance so wide that much is left out."""
    grid = {
        "range_km": [0.001, 1, 30, 1000, 3000],
        "altitude_km": [2.102, 6, 12, 100],
        "elevation_deg": [-90, -20, -2, 0, 3, 60],
        "source_elevation_deg": [-10, 0, 5, 40, 90],
        "source_azimuth_deg": [0, 10, 90, 180],
    }
    changes = {"states": STATES[name], "bands": [{"wavelength_um": [10.3, 11.3]}, {"wavelength_um": [3.7, 4.1]}]}
    _, differences = measured(
        starter(tmp_path / "demo", {**changes, "atmosphere_grid": grid, "accuracy": {"negligible_k": 1.0}})
    )
    assert any(name.endswith("path_radiance_ratio, K") for name in differences)
