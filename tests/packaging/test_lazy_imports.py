"""Slow libraries are imported where they are used: a command that needs none of them does not wait for them."""

import subprocess
import sys

import pytest
import scipy.constants

from skyshine.mat.radiometry import constants

# Seconds of a processor to import: pvlib with pandas 0.4, scipy's folders 0.3, matplotlib 0.2, scikit-image 0.1.
SLOW = ("matplotlib", "pandas", "pvlib", "rasterio", "sklearn", "skimage", "xarray")
CHECK = "import skyshine.mat; skyshine.mat.check(skyshine.mat.example('ship'))"


@pytest.mark.parametrize(
    "program, slow",
    [
        ("import skyshine.mat.api.check, skyshine.mat.commands.check", (*SLOW, "jsonschema", "scipy.special")),
        (CHECK, SLOW),
    ],
)
def test_slow_libraries_are_not_imported(program, slow):
    names = f"import sys; {program}; print(*(name for name in {slow} if name in sys.modules))"
    run = subprocess.run([sys.executable, "-c", names], capture_output=True, text=True, check=True)
    assert run.stdout.split() == []


@pytest.mark.parametrize(
    "name, theirs",
    [
        ("AVOGADRO", "N_A"),
        ("BOLTZMANN", "k"),
        ("FOOT", "foot"),
        ("GAS_CONSTANT", "R"),
        ("LIGHT_SPEED", "c"),
        ("MMHG", "mmHg"),
        ("PLANCK", "h"),
        ("STANDARD_ATMOSPHERE", "atm"),
        ("STANDARD_GRAVITY", "g"),
        ("STEFAN_BOLTZMANN", "Stefan_Boltzmann"),
        ("ZERO_CELSIUS", "zero_Celsius"),
    ],
)
def test_constants_are_those_of_scipy(name, theirs):
    assert getattr(constants, name) == pytest.approx(getattr(scipy.constants, theirs), rel=1e-15, abs=0)
