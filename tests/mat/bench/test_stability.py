"""The stability suite: it passes on a few cases, draws the same ones again, and sees what is wrong."""

import numpy as np

from skyshine.mat.bench import stability


def test_a_few_cases_hold():
    trials = stability.run(0.0, 5)
    assert set(trials) == set(stability.PARTS)
    for trial in trials.values():
        assert trial.cases == 1 and trial.failures == [] and trial.worst["not finite"] == 0


def test_cases_are_the_same_again():
    first, second = (stability.surface_case(np.random.default_rng([7, 3])) for _ in range(2))
    assert first == second


def test_what_is_not_finite_or_out_of_bounds_fails():
    def bad(generator):
        return {"residual": (float("nan"), 1.0), "excess": (2.0, 1.0), "fine": (0.5, 1.0)}

    def broken(generator):
        raise ArithmeticError("no root")

    trials = stability.run(0.0, 1, {"bad": bad, "broken": broken})
    assert len(trials["bad"].failures) == 2 and trials["bad"].worst["residual"] == np.inf
    assert trials["broken"].failures == ["broken, seed 1, case 0: ArithmeticError: no root"]


def test_most_textures_are_mapped_and_the_rest_refused():
    cases = [stability.texture_case(np.random.default_rng([9, k])) for k in range(16)]
    assert sum("not finite" in case for case in cases) >= 8
    assert all(value <= allowed for case in cases for value, allowed in case.values())
