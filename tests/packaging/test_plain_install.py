"""An installation without extras has the public functions and the commands that the README names."""

import re
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[2]

WITHOUT_EXTRAS = """
import importlib, pkgutil, sys

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in PACKAGES:
            raise ModuleNotFoundError(f"No module named '{name}'", name=name)

sys.meta_path.insert(0, Missing())
import skyshine, skyshine.mat, skyshine.mat.commands, skyshine.tmm, skyshine.tmm.commands
for package in (skyshine.mat, skyshine.tmm):
    for name in package.__all__:
        getattr(package, name)
for package in (skyshine.mat.commands, skyshine.tmm.commands):
    for module in pkgutil.iter_modules(package.__path__, package.__name__ + "."):
        importlib.import_module(module.name)
print(skyshine.mat.spectrum(wavelength=(8, 12), altitude=3, elevation=-20, range=2))
"""


def _packages_of_extras() -> set[str]:
    """Modules of all packages that an extra alone asks for, where they are installed."""
    wanted = [re.split(r"[^\w.-]", text, maxsplit=1)[0] for text in metadata.requires("skyshine") if "extra ==" in text]
    plain = {
        re.split(r"[^\w.-]", text, maxsplit=1)[0].lower()
        for text in metadata.requires("skyshine")
        if "extra ==" not in text
    }
    homes = metadata.packages_distributions()
    optional = {name.lower() for name in wanted} - plain - {"skyshine"}
    return {module for module, names in homes.items() if {name.lower() for name in names} & optional}


def test_public_functions_and_commands_load_without_the_packages_of_extras():
    packages = _packages_of_extras()
    if "numba" not in packages:
        pytest.skip("the extras are not installed")
    code = WITHOUT_EXTRAS.replace("PACKAGES", repr(packages))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "8" in done.stdout and "mean transmittance" in done.stdout
