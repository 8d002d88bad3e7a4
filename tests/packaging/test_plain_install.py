"""An installation without extras has the public functions and the commands that the README names."""

import importlib.util
import re
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import click
import pytest

from skyshine.mat.cli import main as mat
from skyshine.tmm.cli import main as tmm

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


def _readme_program():
    spec = importlib.util.spec_from_file_location("readme", CHECKOUT / ".ci/readme.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


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


def test_the_readme_names_every_command_and_no_other():
    named = _readme_program().commands_of((CHECKOUT / "README.md").read_text(encoding="utf-8"))
    groups = {"mat": mat, "tmm": tmm}
    context = click.Context(mat)
    for line in named:
        program, *words = line.split()
        command = groups[program]
        for word in words:
            command = command.get_command(context, word)
            assert command is not None, line
    assert {f"mat {name}" for name in mat.list_commands(context)} <= set(named) | {"mat materials", "mat lines"}


def test_usages_of_a_list_become_commands():
    usages = "    mat a FILE [--b N]   what it does\n    mat c d | e FILE      two\n    tmm f | g\n"
    text = f"# x\n\n## Commands\n\n{usages}\n## Next\n    mat h\n"
    assert _readme_program().commands_of(text) == ["mat a", "mat c d", "mat c e", "tmm f", "tmm g"]
