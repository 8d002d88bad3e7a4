"""``python -m mat.maintain.bench.scene_needs``: what the needs of three scenes save of a build, and what they change.

A street with a camera above its end, the starter's photograph as a plan, and a terrain of 10 km below the track of an
aircraft. Each job is built as it is written and with the needs of its scene; both are read at random points inside
these needs.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

import click
import numpy as np
import yaml

from skyshine.mat.job.load import load_job
from skyshine.schemas.documents import read_yaml

RESULTS = Path("tests/validation/needs_results.json")
CASES = ("street", "starter", "terrain")
TERRAIN_KM, TERRAIN_CELLS = 10.0, 40
TERRAIN_MATERIALS = ("grass_green", "conifer", "soil_sand")


@click.command()
@click.option("--case", "cases", type=click.Choice(CASES), multiple=True, help="Default: all.")
@click.option("--out", type=click.Path(dir_okay=False), default=str(RESULTS), show_default=True)
def scene_needs(cases: tuple[str, ...], out: str) -> None:
    """Build the job of each scene with and without the scene's needs, and write costs and differences to a JSON file.

    \b
    Example:
      python -m mat.maintain.bench.scene_needs --case terrain
    """
    file = Path(out)
    results = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    for case in cases or CASES:
        with tempfile.TemporaryDirectory() as folder:
            results[case] = measured(case, Path(folder))
        file.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
        click.echo(f"{case}: {json.dumps(shares(results[case]))}")


def shares(result: dict[str, Any]) -> dict[str, float]:
    """Bytes and processor time with needs over those without, and the largest difference over its bound."""
    whole, reduced = result["without_needs"], result["with_needs"]
    return {
        "bytes": reduced["bytes"] / whole["bytes"],
        "seconds": reduced["processor_s"] / whole["processor_s"],
        "difference": max(entry["largest"] / entry["bound"] for entry in result["differences"].values()),
    }


def measured(case: str, folder: Path) -> dict[str, Any]:
    """Costs of a case's job with and without the needs of its scene, and the differences of what both files give.

    Parameters
    ----------
    case : str
        One of `CASES`.
    folder : Path
        Empty folder, for the job and both builds.
    """
    from mat.maintain.bench.omissions import build_cost, read_differences
    from skyshine.mat.api.needs import needs

    job, scene = (_terrain if case == "terrain" else _example)(case, folder)
    os.environ["SKYSHINE_CACHE"] = ""  # without a cache, or the second build would use the bands of the first
    whole = load_job(job)
    cost = build_cost(whole, folder / "whole")
    _take_textures(job, folder / "whole")
    scene_of_whole = {**read_yaml(scene).data, "databases": "whole"}
    if plan := scene_of_whole["surface"].get("plan"):
        plan["texture"] = f"whole/{Path(plan['texture']).name}"
    scene.write_text(yaml.safe_dump(scene_of_whole), encoding="utf-8")
    needs(scene, job).write(folder / "less.yaml")
    reduced = load_job(folder / "less.yaml")
    less = build_cost(reduced, folder / "kept")
    differences = read_differences(reduced, folder / "kept", folder / "whole", np.random.default_rng(1))
    return {
        "needs": sorted(reduced.document.data["needs"]),
        **{
            name: {"processor_s": round(spent.seconds, 2), "bytes": spent.size}
            for name, spent in (("without_needs", cost), ("with_needs", less))
        },
        "differences": {
            name: {"largest": float(f"{value:.3g}"), "bound": bound} for name, (value, bound) in differences.items()
        },
    }


def _example(name: str, folder: Path) -> tuple[Path, Path]:
    """Job and scene of a packaged example; without pictures."""
    from skyshine.mat.api.examples import starter_files

    for file in starter_files(name):
        shutil.copy(file, folder)
    return folder / "job.yaml", folder / "scene.yaml"


def _take_textures(job: Path, built: Path) -> None:
    """Have the second build read the texture databases of the first, whose cost is no matter of needs."""
    content = dict(read_yaml(job).data)
    if "textures" in content:
        content["textures"] = [{"database": f"{built.name}/{entry['name']}.tmm.h5"} for entry in content["textures"]]
        job.write_text(yaml.safe_dump(content), encoding="utf-8")


def _terrain(_: str, folder: Path) -> tuple[Path, Path]:
    """Hills of three materials, seen from an aircraft that crosses them within ten minutes at 1.5 km above sea level;
    the job is one for any scene at the site.
    """
    job = {
        "skyshine": 1,
        "name": "terrain",
        "site": {"latitude_deg": 47.0, "longitude_deg": 8.5, "date": "2026-06-20", "utc_offset_h": 2},
        "states": [
            {
                "profile": "midlatitude_summer",
                "visibility_km": 23,
                "ground_material": "grass_green",
                "weather": {"air_temperature_c": [12, 24]},
            }
        ],
        "bands": [{"wavelength_um": [3, 5]}, {"wavelength_um": [8, 12]}],
        "sources": ["sun", "moon"],
        "materials": [*TERRAIN_MATERIALS, "asphalt_road", "concrete", "brick_red"],
        "output": {"folder": "built", "pictures": False},
    }
    job["site"]["altitude_km"] = 0.4  # type: ignore[index]
    job["surface_grid"] = {"altitude_km": [0.4, 1.0]}
    stations = [
        {
            "hour": 14.0 + minute / 60.0,
            "position_m": [-4500.0 + 900.0 * minute, -800.0, 1100.0],
            "look_at_m": [-1500.0 + 600.0 * minute, 1500.0, 100.0],
        }
        for minute in range(0, 11, 2)
    ]
    camera = {"perspective": {"field_of_view_deg": 30, "size": [96, 72], "track": stations}}
    mesh = {"file": "hills.obj", "up": "z", "materials": {name: name for name in TERRAIN_MATERIALS}}
    surface = {"altitude_km": 0.4, "mesh": mesh}
    scene = {
        "skyshine_scene": 1,
        "name": "terrain",
        "databases": "built",
        "bands": ["b02"],
        "surface": surface,
        "camera": camera,
    }
    (folder / "hills.obj").write_text(_hills(), encoding="utf-8")
    for name, content in (("job", job), ("scene", scene)):
        (folder / f"{name}.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    return folder / "job.yaml", folder / "scene.yaml"


def _hills() -> str:
    """Wavefront text of a square of rolling hills up to 300 m high, its material by height."""
    axis = np.linspace(-0.5, 0.5, TERRAIN_CELLS + 1) * 1e3 * TERRAIN_KM
    east, north = np.meshgrid(axis, axis)
    height = 150.0 * (1 + np.sin(east / 900.0) * np.cos(north / 1300.0))
    lines = [f"v {x:.2f} {y:.2f} {z:.2f}" for x, y, z in zip(east.flat, north.flat, height.flat, strict=True)]
    faces: dict[str, list[str]] = {name: [] for name in TERRAIN_MATERIALS}
    side = TERRAIN_CELLS + 1
    for row in range(TERRAIN_CELLS):
        for column in range(TERRAIN_CELLS):
            corner = row * side + column + 1
            name = TERRAIN_MATERIALS[int(height[row, column] // 101)]
            faces[name] += [
                f"f {corner} {corner + 1} {corner + side + 1}",
                f"f {corner} {corner + side + 1} {corner + side}",
            ]
    for name, triangles in faces.items():
        lines += [f"usemtl {name}", *triangles]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    scene_needs()
