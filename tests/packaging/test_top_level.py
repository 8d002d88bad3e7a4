"""The generated top of the package: it names its parts without loading them."""

import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

import skyshine.mat

CHECKOUT = Path(__file__).parents[2]


@pytest.fixture
def top():
    """The module that `pyproject.toml` generates."""
    project = tomllib.loads((CHECKOUT / "pyproject.toml").read_text(encoding="utf-8"))
    (generated,) = (
        entry for entry in project["tool"]["scikit-build"]["generate"] if entry["path"] == "skyshine/__init__.py"
    )
    module = ModuleType("skyshine_generated")
    exec(generated["template"].replace("${version}", "1.2.3"), module.__dict__)
    return module


def test_the_top_of_the_package_has_the_scene(top):
    assert top.Scene is skyshine.mat.Scene
    assert top.__version__ == "1.2.3"


def test_the_top_of_the_package_has_its_parts(top):
    assert top.mat is skyshine.mat and top.tmm.__name__ == "skyshine.tmm"


def test_importing_the_package_loads_none_of_its_parts():
    code = "import sys, skyshine; print(*(name for name in sys.modules if name.startswith('skyshine.')))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not done.stdout.split()


def test_another_name_is_an_attribute_error(top):
    with pytest.raises(AttributeError, match="no attribute 'Skene'"):
        top.Skene
