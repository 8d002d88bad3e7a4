"""What the needs of a scene save of its build, and what they change of its pictures: a street, and the starter's road.

Run: python -m pytest -m validation -s tests/validation/test_needs.py
"""

import json
import struct

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from skyshine.mat.api.examples import starter_files
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


def street_mesh(path):
    """Write a street of 120 m, 12 degree off north: road, pavements, walls of 12 m, tilted roofs, a wall at its end."""

    def quad(*corners):
        a, b, c, d = corners
        return [[a, b, c], [a, c, d]]

    def across(left, right, low, high):
        return quad([left, -60, low], [left, 60, low], [right, 60, high], [right, -60, high])

    parts = {
        "road": quad([-6, -60, 0], [6, -60, 0], [6, 60, 0], [-6, 60, 0]),
        "pavement": across(-6, -9, 0, 0) + across(6, 9, 0, 0),
        "wall": across(-9, -9, 0, 12) + across(9, 9, 0, 12) + quad([-9, 60, 0], [9, 60, 0], [9, 60, 14], [-9, 60, 14]),
        "roof": across(-9, -15, 12, 16.2) + across(9, 15, 12, 16.2),
    }
    turn, blob, views, accessors, meshes = np.radians(12.0), b"", [], [], []
    for number, corners in enumerate(parts.values()):
        x, y, z = np.reshape(corners, (-1, 3)).T
        # glTF has y up and z to the south.
        east, north = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
        flat = np.stack([east, z, -north], axis=-1).astype("<f4")
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": flat.nbytes})
        limits = {"min": flat.min(axis=0).tolist(), "max": flat.max(axis=0).tolist()}
        accessors.append({"bufferView": number, "componentType": 5126, "count": len(flat), "type": "VEC3"} | limits)
        meshes.append({"primitives": [{"attributes": {"POSITION": number}, "material": number}]})
        blob += flat.tobytes()
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(meshes)))}],
        "nodes": [{"mesh": number} for number in range(len(meshes))],
        "meshes": meshes,
        "materials": [{"name": name} for name in parts],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(blob)}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(blob), 0x004E4942) + blob
    path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)


def street(folder, look_at, bands):
    street_mesh(folder / "street.glb")
    (job,) = [file for file in starter_files("street") if file.name == "job.yaml"]
    text = job.read_text(encoding="utf-8").replace("altitude_km: [0.17]", "altitude_km: [0.17, 0.2]")
    text = text.replace("pictures: true", "pictures: false") + "accuracy: 0.3 K\n"
    (folder / "job.yaml").write_text(text, encoding="utf-8")
    materials = {"road": "asphalt_road", "pavement": "concrete", "wall": "brick_red", "roof": "brick_red"}
    position = {"field_of_view_deg": 50, "size": [64, 48], "position_m": [-7.3, -38, 9], "look_at_m": look_at}
    return {
        "surface": {"altitude_km": 0.17, "mesh": {"file": "street.glb", "materials": materials}},
        "camera": {"perspective": position},
    } | ({"bands": bands} if bands else {})


def starter(folder, look_at, bands):
    run("init", folder / "start")
    job = dict(read_yaml(folder / "start" / "job.yaml").data)
    (folder / "job.yaml").write_text(yaml.safe_dump(job | {"output": {"folder": "built", "pictures": False}}))
    for file in (folder / "start").glob("*.png"):
        file.rename(folder / file.name)
    return {
        "surface": {"altitude_km": 2.1, "plan": {"texture": "whole/yellowstone_road.tmm.h5", "metres_per_texel": 0.5}},
        "camera": {"plan_view": {"height_m": 1000, "size": [120, 70]}},
    }


CASES = {
    "street": (street, [2, 28, 1], None, 0.4, 0.4),
    "street, one band": (street, [2, 28, 1], ["b02"], 0.3, 0.25),
    "street, no sky, one band": (street, [0, 0, 0], ["b02"], 0.25, 0.25),
    "starter": (starter, None, None, 0.4, 0.4),
}


@pytest.mark.parametrize("name", CASES)
def test_a_build_for_a_scene_costs_less_and_draws_the_same_within_its_bound(tmp_path, monkeypatch, name):
    monkeypatch.setenv("SKYSHINE_CACHE", "")  # or the second build would take the bands of the first
    make, look_at, bands, most_seconds, most_bytes = CASES[name]
    scene = {"skyshine_scene": 1, "name": "scene", "hours": HOURS, "databases": "whole"}
    scene |= make(tmp_path, look_at, bands)
    run("build", tmp_path / "job.yaml", "--out", tmp_path / "whole", "--jobs", 1)
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(scene))
    job = dict(read_yaml(tmp_path / "job.yaml").data)
    if "textures" in job:
        job["textures"] = [{"database": "whole/yellowstone_road.tmm.h5"}]
        (tmp_path / "job.yaml").write_text(yaml.safe_dump(job))
    arguments = ("needs", tmp_path / "scene.yaml", "--job", tmp_path / "job.yaml")
    done = CliRunner().invoke(main, [*map(str, arguments), "--json"], standalone_mode=False, catch_exceptions=False)
    replaced = json.loads(done.output)["replaced_materials"]
    run(*arguments, "--output", tmp_path / "less.yaml")
    run("build", tmp_path / "less.yaml", "--out", tmp_path / "less", "--jobs", 1)
    whole, less = (cost(tmp_path / folder) for folder in ("whole", "less"))
    shares = less[0] / whole[0], less[1] / whole[1]
    print(
        f"\n{name}: without needs {whole[0]:.1f} s and {whole[1]:,} bytes, with them {less[0]:.1f} s ({shares[0]:.2f})"
        f" and {less[1]:,} bytes ({shares[1]:.2f})"
    )
    frames = []
    for folder in ("whole", "less"):
        surface = scene["surface"] | {"replaced_materials": replaced}
        with Renderer(load_scene(scene | {"databases": folder, "surface": surface}, folder=tmp_path)) as renderer:
            frames.append(list(renderer.frames()))
    for one, other in zip(*frames, strict=True):
        difference = np.abs(one.apparent_temperature - other.apparent_temperature)
        stated, worst = bounds(tmp_path, one.band)
        print(
            f"{one.band} at {one.hour:g} h: 99 % of the pixels within {np.percentile(difference, 99):.3f} K (stated"
            f" {stated:.2f}), largest {difference.max():.3f} K (stated {worst:.2f})"
        )
        assert np.percentile(difference, 99) <= stated and difference.max() <= worst
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
