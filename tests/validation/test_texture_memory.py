"""Peak memory of the classification of a texture larger than memory should hold."""

import os
import subprocess
import sys

import numpy as np
import OpenImageIO as oiio
import pytest

pytestmark = pytest.mark.validation

# The whole size takes half an hour and 25 GB; memory depends on the width, so that fewer rows tell it too.
WIDTH, HEIGHT = 32768, int(os.environ.get("SKYSHINE_TEXTURE_ROWS", 2048))
LIMIT = 600  # MiB; the aim is 500, which textures with many distinct colours do not keep yet
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
    print("peak", resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024)
"""


def test_peak_memory(tmp_path, record_property):
    random = np.random.default_rng(0)
    output = oiio.ImageOutput.create("wide.tif")
    assert output.open(str(tmp_path / "wide.tif"), oiio.ImageSpec(WIDTH, HEIGHT, 3, "uint8"))
    # Smooth colour with noise: about as many distinct colours as a photograph has.
    across = np.linspace(0, 40, WIDTH) % 1 * 60
    for top in range(0, HEIGHT, 64):
        rows = np.stack([across + base for base in (60, 90, 50)], axis=-1) + random.normal(0, 12, (64, WIDTH, 3))
        assert output.write_scanlines(top, top + 64, 0, np.clip(rows, 0, 255).astype(np.uint8))
    output.close()
    (tmp_path / "job.yaml").write_text(JOB)
    done = subprocess.run([sys.executable, "-c", PROGRAM, str(tmp_path / "job.yaml")], capture_output=True, text=True)
    peak = int(done.stdout.split()[-1])
    record_property("peak_mebibytes", peak)
    print(f"\n{WIDTH} x {HEIGHT}: peak {peak} MiB")
    assert (tmp_path / "build" / "wide.tmm.h5").is_file(), done.stderr
    assert peak < LIMIT
