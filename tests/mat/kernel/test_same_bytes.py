"""Light has the same bytes with vectors of four and of eight numbers, and in any number of threads."""

import hashlib
import os
import pickle
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from skyshine.mat.atmosphere.transfer.segments import Depths
from skyshine.mat.kernel.library import VARIABLE, lanes

PRINTED = """
import pickle, sys
sys.path.insert(0, sys.argv[2])
from test_same_bytes import digest
for case in pickle.load(open(sys.argv[1], "rb")):
    print(digest(*case))
"""


def digest(air, lines):
    """Of all that the kernel computes."""
    single = Depths(lines.depths.per_segment.astype(np.float32), lines.depths.starts)
    results = (
        air.scattered_light.along(*lines.arguments),
        air.scattered_light.in_band(*lines.arguments, np.linspace(1.0, 2.0, air.optics.wavenumber.size)),
        air.scattered_light.of_segments(*lines.of_source(9)),
        air.scaled_source_paths.optical_depth(lines.segments.altitude, lines.to_source),
        air.thermal_radiance(lines.segments, lines.depths),
        air.thermal_radiance(lines.segments, single),
    )
    return hashlib.sha256(b"".join(part.tobytes() for part in results)).hexdigest()


def test_with_four_and_eight_numbers(case, tmp_path):
    if lanes() != 8:
        pytest.skip("this processor has vectors of four")
    cases = [case(name) for name in ("clear", "cloud")]
    expected = [digest(*each) for each in cases]
    for air, _ in cases:
        for cached in ("scattered_light", "_thermal_light"):  # addresses are of this process
            vars(air).pop(cached, None)
        for paths in (air.source_paths, air.scaled_source_paths, air.forward_peak.paths):
            vars(paths).pop("_structure", None)
    (tmp_path / "cases").write_bytes(pickle.dumps(cases))
    for number in ("4", "8"):
        command = [sys.executable, "-c", PRINTED, tmp_path / "cases", Path(__file__).parent]
        done = subprocess.run(command, env=os.environ | {VARIABLE: number}, capture_output=True, text=True)
        assert done.stdout.split() == expected, done.stderr


def test_in_several_threads(case):
    air, lines = case("cloud")
    expected = digest(air, lines)
    with ThreadPoolExecutor(4) as pool:
        assert set(pool.map(lambda _: digest(air, lines), range(12))) == {expected}
