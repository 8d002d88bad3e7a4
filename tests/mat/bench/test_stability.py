"""The stability suite: it passes on a few cases, draws the same ones again, and sees what is wrong."""

import contextlib
import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from skyshine.mat.bench import extreme_jobs, stability
from skyshine.mat.bench.extreme_jobs import random_job
from skyshine.mat.cli import main
from skyshine.mat.commands.stability import _write_jobs
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.plan import Plan
from skyshine.schemas.errors import InputError

PARTS = [part for part in stability.PARTS if part != "job"]


@pytest.mark.validation  # 7 and 60 s
@pytest.mark.parametrize("parts", [PARTS, ["job"]], ids=["parts", "job"])
def test_a_few_cases_hold(parts):
    trials = stability.run(0.0, 17, {part: stability.PARTS[part] for part in parts})
    assert set(trials) == set(parts)
    for trial in trials.values():
        assert trial.cases == 1 and trial.failures == [] and trial.largest["not finite"] == 0
    if "job" in parts:  # a seed of a small job that the check accepts
        assert trials["job"].largest["refused by the check"] == 0


def test_cases_are_the_same_again():
    first, second = (stability.surface_case(np.random.default_rng([7, 3])) for _ in range(2))
    assert first == second


def test_what_is_not_finite_or_out_of_bounds_fails():
    def bad(generator):
        return {"residual": (float("nan"), 1.0), "excess": (2.0, 1.0), "fine": (0.5, 1.0)}

    def broken(generator):
        raise ArithmeticError("no root")

    trials = stability.run(0.0, 1, {"bad": bad, "broken": broken})
    assert len(trials["bad"].failures) == 2 and trials["bad"].largest["residual"] == np.inf
    assert trials["broken"].failures == ["--seed 1 --case broken:0: ArithmeticError: no root"]


def test_most_textures_are_mapped_and_the_rest_refused():
    cases = [stability.texture_case(np.random.default_rng([9, k])) for k in range(16)]
    assert sum("not finite" in case for case in cases) >= 8
    assert all(value <= allowed for case in cases for value, allowed in case.values())


def test_parts_share_the_time_whatever_their_cases_cost(monkeypatch):
    clock = [0.0]

    def costing(seconds):
        def case(_):
            clock[0] += seconds
            return {}

        return case

    monkeypatch.setattr(stability.time, "monotonic", lambda: clock[0])
    trials = stability.run(1000.0, 1, {"dear": costing(50.0), "cheap": costing(1.0), "middling": costing(7.0)})
    assert all(abs(trial.seconds - 1000 / 3) <= 50 for trial in trials.values())
    assert trials["cheap"].cases > 250 and trials["dear"].cases < 10


def test_drawn_jobs_reach_the_ends_and_most_pass_the_check():
    jobs = [random_job(np.random.default_rng([1, k])) for k in range(300)]
    lows = [band["wavelength_um"][0] for job in jobs for band in job["bands"]]
    widths = [np.ptp(band["wavelength_um"]) for job in jobs for band in job["bands"]]
    assert min(lows) < 0.4 and max(lows) > 100 and min(widths) <= 0.0101
    assert sum(job["site"]["altitude_km"] < 0 for job in jobs) > 50
    states = [state for job in jobs for state in job["states"]]
    assert sum("radiation" in state["weather"] for state in states) > 50
    assert sum(job.get("operated", {"": {}}).popitem()[1].get("kind") == "heated" for job in jobs) > 10
    assert sum("tolerance" in job["surface_grid"] for job in jobs) > 10
    accepted = 0
    for job in jobs[:40]:
        with contextlib.suppress(InputError):
            load_job(job)
            accepted += 1
    assert accepted >= 30


def test_a_job_that_breaks_a_law_is_a_failure(monkeypatch):
    monkeypatch.setattr(extreme_jobs, "problems", lambda path: ["temperature: 3 values are not finite"])
    monkeypatch.setattr(extreme_jobs, "build", lambda loaded, out, jobs: (Path(out) / "s01.htt.h5").touch())
    monkeypatch.setattr(extreme_jobs, "_checked", lambda job: (None, Plan((), (), ())))
    monkeypatch.setitem(stability.PARTS, "job", extreme_jobs.job_case)
    trial = stability.replay("job", 4, 1)
    assert trial.failures == [
        "--seed 1 --case job:4: CheckFailed: drawn: s01.htt.h5: temperature: 3 values are not finite"
    ]
    with pytest.raises(InputError, match="found the part 'jobs'; did you mean 'job'"):
        stability.replay("jobs", 1, 1)


def test_the_command_writes_the_jobs_that_it_drew_and_runs_a_case_again(tmp_path):
    result = CliRunner().invoke(
        main, ["bench", "stability", "--seed", "3", "--case", "lobes:2", "--drawn", str(tmp_path), "--json"]
    )
    assert result.exit_code == 0 and list(json.loads(result.output)) == ["lobes"] and not list(tmp_path.iterdir())
    _write_jobs(tmp_path, 3, [0, 7])
    drawn = yaml.safe_load((tmp_path / "job-3-7.yaml").read_text(encoding="utf-8"))
    assert drawn == random_job(np.random.default_rng([3, 7]))
    assert CliRunner().invoke(main, ["bench", "stability", "--case", "job"]).exit_code == 2
