"""What the needs of a scene save of its build, and what they change of its pictures: a street, and the starter's road.

Run: python -m pytest -m validation -s tests/validation/test_needs.py
"""

import json

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from skyshine.mat.cli import main
from skyshine.mat.render.frames import Renderer
from skyshine.mat.render.scene_file import load_scene
from skyshine.mat.tables.loader import open_table
from skyshine.schemas.documents import read_yaml

pytestmark = pytest.mark.validation

HOURS = [13, 14, 15]


def run(*arguments):
    done = CliRunner().invoke(main, list(map(str, arguments)), standalone_mode=False, catch_exceptions=False)
    assert done.exit_code == 0, done.output


def cost(folder):
    """Processor seconds of the tables of a build, and bytes."""
    tables = {
        name: entry
        for name, entry in json.loads((folder / "build.json").read_text())["files"].items()
        if not name.endswith(".tmm.h5")
    }
    return (
        sum(entry["processor_seconds"] or 0.0 for entry in tables.values()),
        sum((folder / name).stat().st_size for name in tables),
    )


# Example; changes of its scene and of its job; largest shares of seconds and bytes.
SMALL = [96, 64]
DOWN = {"position_m": [66, -2, 22], "look_at_m": [46, -2, 0], "field_of_view_deg": 40, "size": SMALL}
PLAN = {"plan_view": {"height_m": 1500, "size": [96, 54]}}
CLOSE = {"accuracy": "0.3 K"}
CASES = {
    "street": ("street", {}, CLOSE, 0.5, 0.4),
    "street in one band": ("street", {"bands": ["b02"]}, CLOSE, 0.3, 0.25),
    "street in one band from above": ("street", {"bands": ["b02"], "camera": {"perspective": DOWN}}, CLOSE, 0.25, 0.25),
    "street on classic axes": ("street", {}, {}, 0.5, 0.5),
    "starter": ("starter", {"camera": PLAN, "sensors": None}, {}, 0.35, 0.35),
}


@pytest.mark.parametrize("name", CASES)
def test_a_build_for_a_scene_costs_less_and_draws_the_same_within_its_bound(tmp_path, monkeypatch, name):
    monkeypatch.setenv("SKYSHINE_CACHE", "")  # or the second build would take the bands of the first
    example, changes, job_changes, most_seconds, most_bytes = CASES[name]
    run("init", tmp_path / "job", "--example", example)
    folder = tmp_path / "job"
    job = dict(read_yaml(folder / "job.yaml").data) | {"output": {"folder": "whole", "pictures": False}} | job_changes
    (folder / "job.yaml").write_text(yaml.safe_dump(job))
    run("build", folder / "job.yaml", "--jobs", 1)
    if "textures" in job:
        job["textures"] = [{"database": f"whole/{texture['name']}.tmm.h5"} for texture in job["textures"]]
        (folder / "job.yaml").write_text(yaml.safe_dump(job))
    scene = dict(read_yaml(folder / "scene.yaml").data) | {"hours": HOURS, "databases": "whole"} | changes
    if "perspective" in scene["camera"]:
        scene["camera"]["perspective"]["size"] = SMALL
    if "plan" in scene["surface"]:
        scene["surface"]["plan"]["texture"] = job["textures"][0]["database"]
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene))
    arguments = ("check", folder / "job.yaml", "--scene", folder / "scene.yaml")
    done = CliRunner().invoke(main, [*map(str, arguments), "--json"], standalone_mode=False, catch_exceptions=False)
    replaced = json.loads(done.output)["replaced_materials"]
    run(*arguments, "--out", folder / "less.yaml")
    run("build", folder / "less.yaml", "--out", folder / "less", "--jobs", 1)
    whole, less = (cost(folder / name) for name in ("whole", "less"))
    shares = less[0] / whole[0], less[1] / whole[1]
    print(
        f"\n{name}: without needs {whole[0]:.1f} s and {whole[1]:,} bytes, with them {less[0]:.1f} s ({shares[0]:.2f})"
        f" and {less[1]:,} bytes ({shares[1]:.2f})"
    )
    frames = []
    for build, replacements in (("whole", {}), ("less", replaced)):
        surface = scene["surface"] | {"replaced_materials": replacements}
        with Renderer(load_scene(scene | {"databases": build, "surface": surface}, folder=folder)) as renderer:
            frames.append(list(renderer.frames()))
    for one, other in zip(*frames, strict=True):
        difference = np.abs(one.apparent_temperature - other.apparent_temperature)
        stated, worst = bounds(folder, one.band)
        print(
            f"{one.band} at {one.hour:g} h: 99 % of the pixels within {np.percentile(difference, 99):.3f} K (stated"
            f" {stated:.2f}), largest {difference.max():.3f} K (stated {worst:.2f})"
        )
        assert stated <= 3.0  # a bound that says something
        # Pixels of replaced materials differ by more.
        assert np.percentile(difference, 99) <= stated and np.percentile(difference, 99.9) <= worst
    assert shares[0] <= most_seconds and shares[1] <= most_bytes


def bounds(folder, band):
    """What both builds state together, K: in 99 % of the reads and at most.

    Temperatures, and nodes where a tolerance places them anew; between spectral points the error of a value counts
    with its kelvin.
    """
    total = np.zeros(2)
    for build in ("whole", "less"):
        surface = open_table(next((folder / build).glob("s01*.htt.h5"))).root.groups["accuracy"]
        number = list(surface.axes["quantity"].values).index("temperature")
        total += [surface.variables[f"{name}_kelvin"].data[number] for name in ("p99", "maximum")]
        air = open_table(folder / build / f"s01{band}.atmq.h5").root.groups["accuracy"]
        black = open_table(folder / build / f"{band}.band.h5").root
        kelvin, radiance = (
            np.asarray(values, float)
            for values in (black.axes["temperature"].values, black.variables["blackbody_radiance"].data)
        )
        per_kelvin = np.interp(300.0, kelvin, np.gradient(np.log(radiance), kelvin))
        total += np.array([air.variables[f"spectral_{name}"].data.max() for name in ("p95", "max")]) / per_kelvin
        if "tolerance" in air.attributes:
            tolerance = float(str(air.attributes["tolerance"]).split()[0])
            total += [tolerance, 3 * tolerance]
    return total
