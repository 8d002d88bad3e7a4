"""`python -m mat.maintain.bench.surface`: more steps are nearer to the oracle; the periodic solver leads marching."""

import json

import pytest
from click.testing import CliRunner

from mat.maintain.bench.surface import surface

pytestmark = pytest.mark.validation


def test_error_falls_with_steps(tmp_path):
    pytest.importorskip("casadi")
    done = CliRunner().invoke(surface, ["--quick", "--json", "--out", str(tmp_path)], catch_exceptions=False)
    assert done.exit_code == 0
    rungs = {rung["name"]: rung for rung in json.loads((tmp_path / "surface-bench.json").read_text())["rungs"]}
    error = {name: rung["rms_error"]["value"] for name, rung in rungs.items() if rung["rms_error"]}
    assert (
        error["periodic, N = 24"] > error["periodic, N = 48"] > error["periodic, N = 96"] > error["periodic, N = 576"]
    )
    assert error["periodic, N = 96"] < 0.1 and error["periodic, N = 576"] < 0.02
    assert error["one node a layer, implicit, 15 min"] > 10 * error["periodic, N = 96"]
    times = {name: rung["time_per_column_day"]["value"] for name, rung in rungs.items()}
    assert (
        times["periodic, N = 96"] < times["Crank-Nicolson, 5 min"]
        and times["periodic, N = 96"] < times["oracle (reference)"]
    )
    assert (tmp_path / "surface-bench.png").stat().st_size > 10_000
