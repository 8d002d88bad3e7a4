"""Times and errors of settings that `mat bench` models, against those that it builds: the starter job."""

import json

import pytest
from click.testing import CliRunner

from skyshine.mat.cli import main

pytestmark = pytest.mark.validation  # ten minutes of a processor

MODELLED = ("5 K", "3 K", "2 K")


def front(folder, *options):
    done = CliRunner().invoke(main, ["bench", "--out", str(folder), "--json", *options], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return {rung["name"]: rung for rung in json.loads(done.stdout)["rungs"]}


def test_modelled_times_are_within_a_quarter_of_the_real_ones(tmp_path):
    modelled = front(tmp_path)
    real = front(tmp_path, "--full")
    for name in MODELLED:
        ours, theirs = modelled[name], real[name]
        assert ours["modelled"] and not theirs["modelled"]
        seconds, error = (ours[key]["value"] / theirs[key]["value"] for key in ("time", "error"))
        print(f"\n{name}: time modelled over real {seconds:.3f}, error of thinned tables over real {error:.3f}")
        assert seconds == pytest.approx(1.0, abs=0.25)
        for stage in ("tables", "temperature"):
            print(
                f"  {stage}: {ours['stages'][stage]['value']:.1f} s modelled, {theirs['stages'][stage]['value']:.1f} s"
            )
