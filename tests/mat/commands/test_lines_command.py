"""The command ``mat lines``."""

import json
import re

import pytest
from click.testing import CliRunner

from skyshine.mat.cli import main


def test_info_prints_coverage_gases_and_errors():
    result = CliRunner().invoke(main, ["lines", "info", "--json"], catch_exceptions=False)
    about = json.loads(result.output)
    assert about["coverage"]["units"] == "cm-1"
    assert {"H2O", "CO2", "CH4"} <= set(about["gases"])
    assert 0 < about["error"]["rms"]["value"] <= 0.0015
    assert [part["width"]["value"] for part in about["regions"]][:3] == [10, 5, 20]
    assert all(0 <= part["rms"]["value"] <= 0.0015 for part in about["regions"])
    assert about["data_version"].count(".") == 2 and all(
        gas["terms"] or not gas["rms_error"]["value"] for gas in about["gases"].values()
    )
    text = CliRunner().invoke(main, ["lines", "info"], catch_exceptions=False).output
    assert "coverage" in text and "HITRAN2012" in text


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["info", "absent.h5"], "does not exist"),
        (["build", "--lines", ".", "--continua", ".", "--wavenumber", "750-800", "--out", "x.h5"], "give LO:HI"),
        (["build", "--lines", ".", "--continua", ".", "--wavenumber", "800:750", "--out", "x.h5"], "no range"),
        (
            ["build", "--lines", "absent", "--continua", ".", "--wavenumber", "750:800", "--out", "x.h5"],
            "is not a folder",
        ),
    ],
)
def test_bad_input_is_one_clear_error(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if arguments[0] == "build":
        pytest.importorskip("numba")
    result = CliRunner().invoke(main, ["lines", *arguments])
    assert result.exit_code == 2 and re.search(message, result.output)
    assert len(result.output.strip().splitlines()) == 1
