"""What leaving out saves on the starter job and on states at the edges, and that no answer changes by more than the
plan says.
"""

import pytest
import yaml
from click.testing import CliRunner

from mat.maintain.bench.omissions import compare
from skyshine.mat.cli import main
from skyshine.mat.job.load import load_job
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


@pytest.fixture
def measured(tmp_path, monkeypatch):
    """Compares builds of a job with and without its omissions; 98 % of the reads of an atmosphere count."""
    monkeypatch.setenv("SKYSHINE_CACHE", "")  # without a cache, or the second build would use the bands of the first

    def compared(file):
        found = compare(load_job(file), tmp_path / "compared", seed=1)
        seconds, size = found.trimmed.seconds / found.full.seconds, found.trimmed.size / found.full.size
        worst = max(found.differences.items(), key=lambda item: item[1][0] / item[1][1])
        print(f"\nshares of the whole: {seconds} of the time, {size} of the size; nearest to its bound: {worst}")
        assert all(largest <= bound for largest, bound in found.differences.values())
        return seconds, size, {name: largest for name, (largest, _) in found.differences.items()}

    return compared


def test_starter_with_and_without_what_its_needs_leave(tmp_path, measured):
    needs = {
        "range_km": [0.5, 8],
        "observer_altitude_km": [2.2, 4],
        "elevation_deg": [-90, -5],
        "bands": ["b02"],
        "hours": ["23:00", "03:00"],
    }
    seconds, size, differences = measured(starter(tmp_path / "demo", {"needs": needs}))
    assert size < 0.3 and seconds < 0.7
    assert {name.split(":")[0] for name in differences} == {"s01b02.lunar_atmq.h5", "s01.htt.h5"}


def test_starter_with_and_without_moonlight_in_the_air(tmp_path, measured):
    seconds, size, differences = measured(starter(tmp_path / "demo", {}))
    assert size < 1 and seconds < 1
    assert differences["s01b02.lunar_atmq.h5: path_radiance_ratio, K"] > 0


def test_starter_with_and_without_sunlight_in_the_air(tmp_path, measured):
    _, _, differences = measured(
        starter(tmp_path / "demo", {"bands": [{"wavelength_um": [8, 12]}], "accuracy": {"negligible_k": 0.8}})
    )
    assert differences["s01b01.atmq.h5: path_radiance_ratio, K"] > 0.01


@pytest.mark.parametrize("name", STATES)
def test_edges_with_and_without(tmp_path, name, measured):
    """An observer at the top of the air, ranges through all of it, and a tolerance so wide that much is left out."""
    grid = {
        "range_km": [0.001, 1, 30, 1000, 3000],
        "altitude_km": [2.102, 6, 12, 100],
        "elevation_deg": [-90, -20, -2, 0, 3, 60],
        "source_elevation_deg": [-10, 0, 5, 40, 90],
        "source_azimuth_deg": [0, 10, 90, 180],
    }
    changes = {"states": STATES[name], "bands": [{"wavelength_um": [10.3, 11.3]}, {"wavelength_um": [3.7, 4.1]}]}
    _, _, differences = measured(
        starter(tmp_path / "demo", {**changes, "atmosphere_grid": grid, "accuracy": {"negligible_k": 1.0}})
    )
    assert any(name.endswith("path_radiance_ratio, K") for name in differences)
