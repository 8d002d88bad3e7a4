"""The bench of the whole tool: which rungs no other beats, and what it takes from the parts."""

import pytest

from skyshine.mat.bench.whole import (
    Ladder,
    Rung,
    describe,
    from_absorption,
    from_atmosphere,
    from_surface,
    plot,
    run_command,
)
from skyshine.schemas.errors import CheckFailed

LADDER = Ladder(
    "steps",
    "a day",
    "K",
    (
        Rung("few", 1.0, 0.5),
        Rung("some", 2.0, 0.1, default=True),
        Rung("waste", 3.0, 0.2),
        Rung("peer", 9.0, 0.05, peer=True),
    ),
    "it is enough",
)


def test_a_rung_that_is_slower_and_worse_is_beaten():
    assert [rung.name for rung in LADDER.pareto()] == ["few", "some", "peer"]
    assert [rung["pareto"] for rung in describe([LADDER], {})["ladders"][0]["rungs"]] == [True, True, False, True]


def test_equal_rungs_both_stand():
    twins = Ladder("t", "w", "K", (Rung("a", 1.0, 1.0), Rung("b", 1.0, 1.0)), "")
    assert len(twins.pareto()) == 2


def test_parts_keep_their_figures():
    surface = {
        "rungs": [
            {
                "name": "N = 96",
                "family": "default",
                "rms_error": {"value": 0.02},
                "time_per_column_day": {"value": 1e-5},
            },
            {"name": "none", "family": "marching", "rms_error": None, "time_per_column_day": {"value": 1.0}},
        ]
    }
    (ladder,) = from_surface(surface)
    assert ladder.rungs == (Rung("N = 96", 1e-5, 0.02, default=True),)
    rungs = [
        {"name": name, "time_line_of_sight": {"value": time}, "errors": {"all": {"in_band_rms": {"value": error}}}}
        for name, time, error in (
            ("all points", 1.0, 0.0),
            ("compiled, 48 points", 0.1, 1e-4),
            ("compiled, 128 points", 0.2, 1e-5),
        )
    ]
    (ladder,) = from_absorption({"bands": {"4-5 um": {"reference": "all points", "rungs": rungs}}})
    assert [rung.name for rung in ladder.rungs if rung.default] == ["compiled, 48 points"]


def test_picture(tmp_path):
    plot([LADDER, LADDER], tmp_path / "bench.png")
    assert (tmp_path / "bench.png").read_bytes().startswith(b"\x89PNG")


def test_a_part_that_fails_is_named():
    with pytest.raises(CheckFailed, match="mat info nothing.h5"):
        run_command("mat", "info", "nothing.h5")


def test_ladders_of_tables_name_their_defaults():
    def rung(name, *errors):
        return {
            "name": name,
            "time": {"value": 1.0},
            "errors_rms": {str(k): {"value": error} for k, error in enumerate(errors)},
        }

    ladders = {
        "directions": [rung("4", 0.1, 0.2), rung("8", 0.03, 0.02)],
        "layers": [rung("10 levels", 0.3), rung("40 levels", 0.1)],
    }
    sky, layers = from_atmosphere({"bands": {"8-12 um": {"ladders": ladders}}})
    assert [(each.name, each.error) for each in sky.rungs if each.default] == [("8", 0.03)]
    assert [each.name for each in layers.rungs if each.default] == ["40 levels"]
