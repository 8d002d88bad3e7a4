"""`mat doctor`: versions, what extras lack, and the end of the command where a package is missing."""

import json
from importlib import metadata

import numpy as np
import pytest
from click.testing import CliRunner

from skyshine.mat.api import installation as found
from skyshine.mat.cli import main

REQUIRED = ["numpy>=1.26", "no-such-package>=1", "h5netcdf>=1; extra == 'xarray'", "nowhere>2; extra == 'render'"]
REQUIRED += ["elsewhere; (platform_machine == 'x') and extra == 'render'", "skyshine[xarray]; extra == 'test'"]


def test_the_installation_is_complete_and_named():
    shown = CliRunner().invoke(main, ["doctor"], catch_exceptions=False).output
    assert f"numpy {np.__version__}" in shown and f"skyshine {metadata.version('skyshine')}" in shown


def test_packages_that_are_missing_are_named_by_extra(monkeypatch):
    monkeypatch.setattr(found.metadata, "requires", lambda name: REQUIRED)
    monkeypatch.setenv("SKYSHINE_THREADS", "1")
    monkeypatch.setenv("SKYSHINE_CACHE", "")
    result = CliRunner().invoke(main, ["doctor", "--json"])
    assert result.exit_code == 1 and "lacks no-such-package" in result.output
    told = json.loads(result.stdout)
    assert told["missing"] == ["no-such-package"] and told["packages"] == {"numpy": np.__version__}
    assert told["extras"] == {"xarray": [], "render": ["nowhere"]}
    assert (told["threads"], told["cache"]["folder"]) == (1, "none")
    assert told["environment"]["SKYSHINE_THREADS"] == "1"


@pytest.mark.parametrize("lacking", [[], ["xarray"]])
def test_an_extra_that_lacks_something_says_how_to_install_it(monkeypatch, lacking):
    told = found.installation() | {"extras": {"xarray": lacking}}
    monkeypatch.setattr(found, "installation", lambda: told)
    shown = CliRunner().invoke(main, ["doctor"], catch_exceptions=False).output
    assert ("pip install 'skyshine[xarray]'" in shown) == bool(lacking)
