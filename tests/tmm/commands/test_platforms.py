"""tmm checks a job where modules of POSIX are missing, and warns of nothing on any texture."""

import subprocess
import sys

import numpy as np
import pytest
import yaml

WITHOUT_POSIX = """
import sys
for name in ("resource", "fcntl", "pwd", "grp", "termios", "tty", "pty"):
    sys.modules[name] = None
from skyshine.tmm.cli import main
main(["check", sys.argv[1]])
"""

WARNINGS_ARE_ERRORS = """
import json, sys, traceback
import yaml
from pathlib import Path
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError
from skyshine.tmm import map_texture, write_texture
from skyshine.tmm.job.model import TextureJob
from skyshine.tmm.mapping.run import check
from skyshine.tmm.report.preview import draw
folder, library = Path(sys.argv[1]), load_library()
for entry in yaml.safe_load((folder / "jobs.yaml").read_text()):
    job = TextureJob.model_validate(entry)
    try:
        if job.clusters is not None:
            check(job, folder, library)
        write_texture(map_texture(job, folder, library), folder / "a.tmm.h5")
        if job.material is not None:
            draw(folder / "a.tmm.h5", folder / "a.png", folder / job.image)
    except InputError:
        pass
    except Exception:
        print(json.dumps(entry), traceback.format_exc()[-900:], flush=True)
"""


def test_check_runs_without_the_modules_of_posix(write_image, tmp_path):
    image = write_image("a.png", np.full((4, 4, 3), 90, np.uint8))
    (tmp_path / "job.yaml").write_text(f"textures: [{{image: {image}, material: grass_green}}]")
    command = [sys.executable, "-c", WITHOUT_POSIX, str(tmp_path / "job.yaml")]
    result = subprocess.run(command, capture_output=True, text=True)
    assert result.returncode == 0 and "OK" in result.stdout, result.stderr


TEXTURES = {
    "black.png": np.zeros((6, 9, 3), np.uint8),
    "white.png": np.full((6, 9, 3), 255, np.uint8),
    "texel.png": np.full((1, 1, 3), 9, np.uint8),
    "row.png": np.random.default_rng(0).integers(0, 256, (1, 40, 3), np.uint8),
    "column.png": np.random.default_rng(1).integers(0, 256, (40, 1, 3), np.uint8),
    "nan.tif": np.random.default_rng(2).choice(np.array([np.nan, 0, 0.5, 1], np.float32), (8, 9, 3)),
    "infinite.tif": np.random.default_rng(3).choice(np.array([np.inf, -np.inf, 0.5, 1], np.float32), (8, 9, 3)),
    "huge.tif": np.random.default_rng(4).choice(np.array([3e38, -3e38, 1e-40, 0], np.float32), (8, 9, 3)),
    "negative.tif": -np.random.default_rng(5).random((8, 9, 3), np.float32),
    "nothing.tif": np.full((4, 4, 3), np.nan, np.float32),
    "transparent.png": np.random.default_rng(6).integers(0, 256, (8, 9, 4), np.uint8),
}


def _jobs(image: str, height: int, width: int) -> list[dict]:
    half = [[0, 0], [width / 2, 0], [width / 2, height], [0, height]]
    other = [[width / 2, 0], [width, 0], [width, height], [width / 2, height]]
    seeds = {"polygons": {"grass_green": [half], "asphalt_road": [other]}}
    when = {"hue": {"below": 180}, "chroma": {"at_least": 1}, "excess_green": {"at_least": 0.01}}
    ways = [
        {"seeds": {"polygons": {"grass_green": [half]}}},
        {"seeds": seeds},
        {"seeds": seeds, "classifier": {"speed": "fast"}},
        {"clusters": {"count": 3, "names": {1: "grass_green"}}},
        {"rules": {"rules": [{"material": "grass_green", "when": when}]}},
        {"palette": {"match": "nearest", "colours": {"#000000": "grass_green", "#FFFFFF": "asphalt_road"}}},
        {"material": "grass_green"},
    ]
    return [{"image": image, **way} for way in ways]


@pytest.mark.validation  # 25 s: every way of mapping on every kind of image
def test_no_texture_makes_a_library_warn(write_image, tmp_path):
    jobs = []
    for name, values in TEXTURES.items():
        write_image(name, values, "float" if values.dtype.kind == "f" else "uint8")
        jobs += _jobs(name, *values.shape[:2])
    (tmp_path / "jobs.yaml").write_text(yaml.safe_dump(jobs))
    command = [sys.executable, "-W", "error", "-c", WARNINGS_ARE_ERRORS, str(tmp_path)]
    result = subprocess.run(command, capture_output=True, text=True)
    assert result.returncode == 0 and not result.stdout and not result.stderr, result.stdout + result.stderr
