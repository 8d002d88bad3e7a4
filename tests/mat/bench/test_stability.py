"""The stability suite: it passes on a few cases, draws the same ones again, and sees what is wrong."""

import contextlib
import json

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from skyshine.mat.bench import extreme_jobs, stability
from skyshine.mat.bench.extreme_jobs import random_job
from skyshine.mat.cli import main
from skyshine.mat.commands.stability import _write_jobs
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.plan import Kind, Plan, Task
from skyshine.schemas.errors import InputError

KINDS = [kind for kind in stability.KINDS if kind != "job"]


@pytest.mark.validation  # 7 and 60 s
@pytest.mark.parametrize("kinds", [KINDS, ["job"]], ids=["kinds", "job"])
def test_a_few_cases_hold(kinds):
    cases = stability.run(0.0, 17, {kind: stability.KINDS[kind] for kind in kinds})
    assert [case.kind for case in cases] == kinds
    assert all(case.failures == [] and not case.refusal for case in cases)


def test_cases_are_the_same_again():
    first, second = (stability.surface_case(np.random.default_rng([7, 3])) for _ in range(2))
    assert first == second


def test_what_is_not_finite_or_out_of_bounds_fails():
    def bad(generator):
        return {"residual": (float("nan"), 1.0), "excess": (2.0, 1.0), "fine": (0.5, 1.0)}

    def broken(generator):
        raise ArithmeticError("no root")

    wrong, raised = stability.run(0.0, 1, {"bad": bad, "broken": broken})
    assert len(wrong.failures) == 2 and wrong.worst == "residual"
    assert raised.failures == ["mat bench stability --seed 1 --case broken:0: ArithmeticError: no root"]
    (worst, *_, least) = stability.described([wrong, raised], 1)["worst"]
    assert (worst["measure"], worst["value"], worst["margin"]) == ("residual", None, None)
    assert (least["measure"], least["value"], least["limit"], least["margin"]) == ("fine", 0.5, 1.0, 0.5)


@pytest.mark.parametrize(
    ("value", "limit", "share"),
    [(1.0, 4.0, 0.25), (4.0, 4.0, 1.0), (0.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (8.0, 4.0, 2.0), (1e-9, 0.0, np.inf)],
)
def test_the_share_of_a_limit_that_a_value_uses(value, limit, share):
    assert stability.share_of_limit(value, limit) == share


def test_the_worst_case_of_each_measure_comes_first_and_every_case_is_described():
    values = iter([0.2, 0.9, 0.5])

    def near(_):
        return {"excess": (next(values), 1.0)}

    def refused(_):
        return "by the check"

    cases = [stability._tried("near", near, 3, number) for number in range(3)]
    result = stability.described([*cases, stability._tried("odd", refused, 3, 0)], 3)
    ((worst),) = result["worst"]
    assert worst["again"] == "mat bench stability --seed 3 --case near:1"
    assert worst["value"] == 0.9 and worst["margin"] == pytest.approx(0.1)
    assert [case.get("value") for case in result["cases"]] == [0.9, 0.5, 0.2, None]
    assert result["kinds"]["odd"]["refused"] == 1 and result["kinds"]["near"]["cases"] == 3


def test_most_textures_are_mapped_and_the_rest_refused():
    cases = [stability.texture_case(np.random.default_rng([9, k])) for k in range(16)]
    assert sum("not finite" in case for case in cases) >= 8
    assert all(value <= allowed for case in cases for value, allowed in case.values())


def test_five_cases_of_each_kind_then_kinds_share_the_time(monkeypatch):
    clock = [0.0]

    def costing(seconds):
        def case(_):
            clock[0] += seconds
            return {}

        return case

    monkeypatch.setattr(stability, "_processor_seconds", lambda: clock[0])
    kinds = {"dear": costing(50.0), "cheap": costing(1.0), "middling": costing(7.0)}
    numbers = [case.kind for case in stability.run(1500.0, 1, kinds)]
    assert numbers[:3] == list(kinds) and numbers[3:15] == ["cheap"] * 4 + ["middling"] * 4 + ["dear"] * 4
    assert numbers.count("cheap") > 450 and abs(numbers.count("dear") - 10) <= 1
    clock[0] = 0.0
    assert [case.kind for case in stability.run(55.0, 1, kinds)] == ["dear", "cheap", "middling"]


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
    task = Task(Kind.TEMPERATURE, 1, 0, ("s01.htt.h5",), 1)
    monkeypatch.setattr(extreme_jobs, "problems", lambda path: ["temperature: 3 values are not finite"])
    monkeypatch.setattr(extreme_jobs, "run_task", lambda task, _, folder, *others: (folder / task.files[0]).touch())
    monkeypatch.setattr(extreme_jobs, "_checked", lambda job: (None, Plan((task,), (), ())))
    case = stability.replay("job", 4, 1)
    assert case.failures == [
        "mat bench stability --seed 1 --case job:4: CheckFailed: drawn: s01.htt.h5: temperature: 3 values are not"
        " finite"
    ]
    with pytest.raises(InputError, match="found the kind 'jobs'; did you mean 'job'"):
        stability.replay("jobs", 1, 1)


def test_the_command_writes_the_jobs_that_it_drew_and_runs_a_case_again(tmp_path):
    result = CliRunner().invoke(
        main, ["bench", "stability", "--seed", "3", "--case", "lobes:2", "--drawn", str(tmp_path), "--json"]
    )
    assert (
        result.exit_code == 0 and list(json.loads(result.output)["kinds"]) == ["lobes"] and not list(tmp_path.iterdir())
    )
    _write_jobs(tmp_path, 3, [0, 7])
    drawn = yaml.safe_load((tmp_path / "job-3-7.yaml").read_text(encoding="utf-8"))
    assert drawn == random_job(np.random.default_rng([3, 7]))
    assert CliRunner().invoke(main, ["bench", "stability", "--case", "job"]).exit_code == 2
