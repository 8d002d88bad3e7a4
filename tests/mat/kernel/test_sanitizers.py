"""The kernel reads and writes no memory but its own, and computes nothing that C leaves undefined."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from skyshine.mat.kernel import library

FLAGS = ["-std=c11", "-O1", "-g", "-ffp-contract=off", "-fno-math-errno", "-fPIC", "-fvisibility=hidden", "-mavx2"]
SANITIZED = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
FOLDER = Path(__file__).parent
BUILT = "SKYSHINE_SMALL_BUILD"
ONCE = {"dispatch.c", "layouts.c", "processor.c", "tables.c"}  # compiled once, as in backend.py


@pytest.mark.validation
@pytest.mark.skipif(not shutil.which("gcc"), reason="needs gcc")
def test_the_tests_of_the_kernel_pass_under_address_and_undefined_sanitizers(built, tmp_path):
    if library.lanes() != 8:
        pytest.skip("needs AVX2")
    sources, objects = Path(library.__file__).parent, []
    for source in sorted(sources.glob("*.c")):
        if source.name == "freestanding.c":  # the sanitizers bring their own memcpy
            continue
        for number in ("4",) if source.name in ONCE else ("4", "8"):
            objects.append(tmp_path / f"{source.name}.{number}.o")
            definitions = [f"-DLANES={number}", '-DSKYSHINE_SOURCES=""']
            subprocess.run(["gcc", *FLAGS, *SANITIZED, *definitions, "-c", source, "-o", objects[-1]], check=True)
    made = tmp_path / "sanitized.so"
    subprocess.run(["gcc", *SANITIZED, "-shared", *objects, "-o", made], check=True)
    runtimes = [
        subprocess.run(["gcc", f"-print-file-name={name}"], capture_output=True, text=True, check=True).stdout.strip()
        for name in ("libasan.so", "libubsan.so")
    ]
    settings = {
        "LD_PRELOAD": " ".join(runtimes),
        "ASAN_OPTIONS": "detect_leaks=0",
        "PYTHONMALLOC": "malloc",
        BUILT: str(built),
    }
    tests = [FOLDER / "test_scattered_light.py", FOLDER / "test_thermal_light.py", FOLDER / "test_cut_layers.py"]
    tests.append(FOLDER / "test_pixels.py")
    command = [sys.executable, FOLDER / "with_library.py", made, "-q", "-n", "0", "-p", "no:cacheprovider", *tests]
    done = subprocess.run(command, env=os.environ | settings, capture_output=True, text=True, cwd=FOLDER.parents[2])
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-6000:]
