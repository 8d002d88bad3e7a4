"""The examples in the documentation of the public functions run as they stand."""

import doctest
import importlib

import pytest

import skyshine.mat

MODULES = [
    "skyshine.mat",
    "skyshine.mat.tables.loader",
    *(
        f"skyshine.mat.api.{name}"
        for name in ("band", "build", "check", "contrast", "examples", "fit_material", "spectrum", "temperature")
    ),
]


LONG = {"skyshine.mat.api.build"}  # 6 s


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.validation) if name in LONG else name for name in MODULES]
)
def test_examples_give_what_they_show(builds_here, name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    module = importlib.import_module(name)
    result = doctest.testmod(module, raise_on_error=False)
    assert result.attempted > 0 and result.failed == 0


TABLES = {"AtmosphereTable", "BandTable", "TemperatureTable"}  # whose use `open` shows


@pytest.mark.parametrize("name", sorted(set(skyshine.mat.__all__) - TABLES - {"report"}))
def test_every_public_function_has_an_example(name):
    assert ">>>" in getattr(skyshine.mat, name).__doc__
