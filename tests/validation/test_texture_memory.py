"""Peak memory of the classification of a texture larger than memory should hold."""

import os
import subprocess
import sys

import numpy as np
import OpenImageIO as oiio
import pytest

pytestmark = pytest.mark.validation

# Memory depends on the width, so that few rows tell it too; the whole size is asked for by the environment.
WIDTH, HEIGHT = 32768, int(os.environ.get("SKYSHINE_TEXTURE_ROWS", 2048))
LIMIT = 500e6 / 2**20  # MiB: 500 MB
TILE = 256
JOB = """\
textures:
  - image: wide.tif
    seeds:
      polygons:
        grass_green: [[[560, 300], [640, 300], [640, 360]], [[2000, 1000], [2040, 1000], [2040, 1040]]]
        deciduous: [[[700, 150], [760, 150], [760, 200]], [[3000, 700], [3040, 700], [3040, 740]]]
        asphalt_road: [[[400, 500], [440, 500], [440, 560]], [[5000, 300], [5040, 300], [5040, 340]]]
"""
PROGRAM = """\
import resource, sys
from skyshine.tmm.cli import main
try:
    main(["classify", sys.argv[1]])
finally:
    used = resource.getrusage(resource.RUSAGE_SELF)
    print("peak", used.ru_maxrss // 1024, int(used.ru_utime + used.ru_stime))
"""


def _noisy(output, random):
    """Rows of smooth colour with noise: somewhat more distinct colours than a photograph has."""
    across = np.linspace(0, 40, WIDTH) % 1 * 60
    for top in range(0, HEIGHT, 64):
        rows = np.stack([across + base for base in (60, 90, 50)], axis=-1) + random.normal(0, 12, (64, WIDTH, 3))
        assert output.write_scanlines(top, top + 64, 0, np.clip(rows, 0, 255).astype(np.uint8))


def _tiled(output, random):
    """Packed tiles with blocks of one colour each, which are soon written and classified."""
    for top in range(0, HEIGHT, TILE):
        blocks = random.integers(40, 160, (TILE // 32, WIDTH // 32, 3), dtype=np.uint8)
        rows = np.ascontiguousarray(blocks.repeat(32, axis=0).repeat(32, axis=1))
        assert output.write_tiles(0, WIDTH, top, top + TILE, 0, 1, rows)


@pytest.mark.parametrize("kind", ["noisy", "tiled"])
@pytest.mark.parametrize("way", ["seeds", "seeds and model"])
def test_peak_memory(tmp_path, record_property, kind, way):
    spec = oiio.ImageSpec(WIDTH, HEIGHT, 3, "uint8")
    if kind == "tiled":
        spec.tile_width = spec.tile_height = TILE
        spec["compression"] = "zip"
    output = oiio.ImageOutput.create("wide.tif")
    assert output.open(str(tmp_path / "wide.tif"), spec)
    (_noisy if kind == "noisy" else _tiled)(output, np.random.default_rng(0))
    output.close()
    (tmp_path / "job.yaml").write_text(JOB + ("    model: library\n" if way == "seeds and model" else ""))
    done = subprocess.run([sys.executable, "-c", PROGRAM, str(tmp_path / "job.yaml")], capture_output=True, text=True)
    peak, seconds = map(int, done.stdout.split()[-2:])
    record_property("peak_mebibytes", peak)
    print(f"\n{WIDTH} x {HEIGHT}, {kind}, {way}: peak {peak} MiB, {seconds} s of processor time")
    assert (tmp_path / "build" / "wide.tmm.h5").is_file(), done.stderr
    assert peak < LIMIT
