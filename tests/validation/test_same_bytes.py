"""A build gives the same bytes in one process and in two, whatever the threads, hash seed, locale and time zone.

Three states, two of which share the points of their bands, two bands, the Moon, extra tables and a texture are built
anew in each environment, without the cache of compiled bands. A locale that writes decimals with a comma is compiled
where the machine has its sources.
"""

import os
import shutil
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

pytestmark = pytest.mark.validation
# As a host program does that honours its user's locale.
PROGRAM = "import locale; locale.setlocale(locale.LC_ALL, ''); from skyshine.mat.cli import main; main()"
COMMAND = [sys.executable, "-c", PROGRAM, "build", "job.yaml", "--fresh"]
COMMA = "de_DE.UTF-8"
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
JOB_CHANGES = {
    "  - profile: midlatitude_summer\n    weather: {air_temperature_c: [22, 33]}\n": (
        "  - profile: midlatitude_summer\n    weather: {air_temperature_c: [22, 33]}\n"
        "  - profile: tropical\n    visibility_km: 5\n    weather: {air_temperature_c: [25, 31]}\n"
        "  - profile: midlatitude_summer\n    weather: {air_temperature_c: [20, 31]}\n"
    ),
    "[10.0, 10.2]\n": "[10.0, 10.2]\n  - wavelength_um: [3.9, 4.0]\n",
    "sources: [sun]": "sources: [sun, moon]",
    "materials: [asphalt_road]": (
        "materials: [asphalt_road, grass_green]\n"
        "textures:\n"
        "  - image: halves.png\n"
        "    seeds:\n"
        "      polygons: {grass_green: [[[1, 1], [8, 1], [8, 18]]], asphalt_road: [[[25, 3], [38, 3], [38, 12]]]}"
    ),
}


ENVIRONMENTS = {
    "two processes": (2, {}),
    "two threads": (1, dict.fromkeys(THREADS, "2")),
    "hash seed": (1, {"PYTHONHASHSEED": "1"}),
    "C locale": (1, {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}),
    "time zone": (1, {"TZ": "Asia/Kathmandu"}),
    "all at once": (
        2,
        {**dict.fromkeys(THREADS, "2"), "PYTHONHASHSEED": "4000000000", "TZ": "America/St_Johns", "LC_ALL": "C"},
    ),
}


@pytest.fixture(scope="module")
def built(tiny_job, contents, tmp_path_factory):
    """Builds the job in so many processes under an environment, and returns the bytes of its files."""
    text = tiny_job()
    for old, new in JOB_CHANGES.items():
        assert old in text
        text = text.replace(old, new)
    pixels = np.empty((20, 40, 3))
    pixels[:, :20], pixels[:, 20:] = (60, 140, 50), (120, 120, 125)
    pixels += np.random.default_rng(1).normal(0, 6, pixels.shape)

    def run(processes: int, changes: dict[str, str]) -> dict[str, bytes]:
        folder = tmp_path_factory.mktemp("environment")
        (folder / "job.yaml").write_text(text, encoding="utf-8")
        Image.fromarray(np.clip(pixels, 0, 255).astype(np.uint8)).save(folder / "halves.png")
        plain = {**dict.fromkeys(THREADS, "1"), "PYTHONHASHSEED": "0", "LC_ALL": "C.UTF-8", "TZ": "UTC"}
        environment = os.environ | plain | {"SKYSHINE_CACHE": ""} | changes
        done = subprocess.run(
            [*COMMAND, "--jobs", str(processes)], cwd=folder, env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        return contents(folder / "built")

    return run


@pytest.fixture(scope="module")
def expected(built):
    return built(1, {})


@pytest.fixture(scope="module")
def comma(tmp_path_factory):
    """Environment of a locale in which 1/2 is written 0,5."""
    if shutil.which("localedef") is None:
        pytest.skip("no localedef here")
    folder = tmp_path_factory.mktemp("locale")
    subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", folder / COMMA], capture_output=True, check=False)
    found = {"LOCPATH": str(folder), "LC_ALL": COMMA}
    shown = "import locale; locale.setlocale(locale.LC_ALL, ''); print(locale.localeconv()['decimal_point'])"
    done = subprocess.run([sys.executable, "-c", shown], env=os.environ | found, capture_output=True, text=True)
    if done.stdout.strip() != ",":
        pytest.skip("no sources of locales here")
    return found


def test_nor_on_a_locale_with_decimal_commas(built, expected, comma):
    assert built(1, comma) == expected


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_the_bytes_of_a_build_do_not_depend_on_its_environment(name, built, expected):
    found = built(*ENVIRONMENTS[name])
    assert len(expected) == 3 + 2 + 12 + 1  # temperatures, bands, two sources, the texture
    assert found.keys() == expected.keys()
    assert [file for file in expected if found[file] != expected[file]] == []
