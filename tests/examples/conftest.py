"""The library in C and its bindings, built once a run, and a scene for their programs."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from filelock import FileLock

from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.tables.band import band_group
from skyshine.materials.library import load_library
from skyshine.schemas.hdf5 import Header, write_file

sys.path.insert(0, str(Path(__file__).parents[1] / "fuzz"))
from runtime_loaders import PREPARED, missing_tools

FILES = {"surface": "s01.htt.h5", "band": "b01.band.h5", "atmosphere": "s01b01.atmq.h5"}
CAMERA = {"bits": 12, "gain": 60.0, "buffer_gain": 1.02, "offset": 0.05}
PIXELS = 200


@pytest.fixture(scope="session")
def program_of(folder_of_the_run):
    """The command of the program of a language, which the first worker that needs it builds."""

    def built(language):
        if missing := missing_tools(language):
            pytest.skip(f"{', '.join(missing)} not installed")
        folder = folder_of_the_run / f"{language}_program"
        folder.mkdir(exist_ok=True)
        command = folder / "command.json"
        with FileLock(folder / "lock"):
            if not command.exists():
                command.write_text(json.dumps(PREPARED[language](folder)), encoding="utf-8")
            return json.loads(command.read_text(encoding="utf-8"))

    return built


@pytest.fixture(scope="session")
def c_program(program_of):
    return program_of("c")


# Those that must fetch packages first are nightly: the crate takes a minute of a processor.
DOWNLOADS = pytest.mark.validation
LANGUAGES = ["c", pytest.param("rust", marks=DOWNLOADS), pytest.param("javascript", marks=DOWNLOADS)]


@pytest.fixture(scope="module", params=LANGUAGES)
def runtime(request, program_of, tmp_path_factory):
    """Run the program of a language on a scene: exit status, standard output, standard error."""
    command, folder = program_of(request.param), tmp_path_factory.mktemp(request.param)

    def run(scene):
        (folder / "scene.json").write_text(json.dumps(scene), encoding="utf-8")
        done = subprocess.run([*command, folder / "scene.json"], capture_output=True, text=True, timeout=120)
        return done.returncode, done.stdout, done.stderr

    return run


@pytest.fixture(scope="module")
def band_file(tmp_path_factory):
    """Path of the file of the atmosphere's band: materials with a lobe, whose reflectance goes up and down in the
    band.
    """
    library = load_library()
    materials = sorted((library[name] for name in ("asphalt_road", "grass_green")), key=lambda each: each.code)
    sun = (np.linspace(0.4, 14.0, 60), np.ones(60))
    root = band_group(SpectralResponse.rectangular(10.0, 10.2), materials, sun)
    spectrum, fraction = (root.variables[name] for name in ("reflectance_spectrum", "specular_fraction"))
    phase = np.arange(spectrum.data.size).reshape(spectrum.data.shape)
    drawn = {
        "reflectance_spectrum": replace(spectrum, data=(0.5 + 0.45 * np.sin(phase**1.5)).astype(np.float32)),
        "specular_fraction": replace(fraction, data=np.array([0.3, 0.7], np.float32)),
    }
    axis = root.axes["planck_temperature"]  # of which faces are colder and warmer than all nodes
    axes = root.axes | {"planck_temperature": replace(axis, values=np.linspace(293.0, 305.0, axis.values.size))}
    path = tmp_path_factory.mktemp("band") / "b01.band.h5"
    write_file(path, replace(root, axes=axes, variables=root.variables | drawn), Header("band", "data", "job"))
    return path


@pytest.fixture(scope="module")
def scene(small_build):
    """Pixels all over the axes, round the periodic ones more than once, at nodes too, lit from behind too."""
    draw = np.random.default_rng(7)
    limits = {
        "surface_altitude": (0, 1),
        "surface_azimuth": (-400, 800),
        "surface_slope": (0, 45),
        "time": (-30, 60),
        "range": (0.001, 20),
        "centre_range": (0.001, 20),
        "altitude": (0.01, 1),
        "centre_elevation": (-90, 90),
        "source_elevation": (-20, 60),
        "source_azimuth": (-500, 500),
    }
    pixels = []
    for number in range(PIXELS):
        pixel = {name: float(draw.uniform(*limit)) for name, limit in limits.items()}
        if number % 10 == 0:
            pixel |= {
                "time": 24.0,
                "surface_azimuth": 360.0,
                "altitude": 1.0,
                "centre_elevation": 90.0,
                "source_azimuth": 180.0,
            }
        pixel |= {name: draw.normal(size=3).tolist() for name in ("normal", "to_source", "to_observer")}
        pixels.append(pixel | {"material": ["asphalt_road", "grass_green"][number % 2]})
    return {name: str(small_build / file) for name, file in FILES.items()} | CAMERA | {"pixels": pixels}
