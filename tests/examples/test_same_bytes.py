"""The bindings in Rust and JavaScript compute with the C sources of the package: the same bytes, whatever the compiler,
the vectors of the processor or WebAssembly. Nightly, for both fetch packages first.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "fuzz"))
from runtime_loaders import by_library

pytestmark = pytest.mark.validation
TERMS = ("temperature", "blackbody_radiance", "transmittance", "thermal", "path", "skyshine", "diffuse", "specular")


@pytest.mark.parametrize("language", ["rust", "javascript"])
def test_pixels_have_the_bytes_of_the_package(program_of, scene, tmp_path, language):
    """Of random places, sources and directions, on tilted faces too."""
    draw = np.random.default_rng(41)
    pixels = [pixel | {"source_heading": float(draw.uniform(-400, 400))} for pixel in scene["pixels"]]
    tilted = scene | {"pixels": pixels}
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(tilted), encoding="utf-8")
    done = subprocess.run([*program_of(language), path], capture_output=True, text=True, check=True)
    shown = json.loads(done.stdout)["pixels"]
    expected = by_library(tilted)
    for name in (*TERMS, "radiance", "pixel_value"):
        assert [pixel[name] for pixel in shown] == expected[name].tolist(), name
