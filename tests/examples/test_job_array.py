"""The job array of a year: its tasks build the parts of one job, which `test_sites.py` shows to be disjoint."""

import os
import shutil
import subprocess

import pytest


@pytest.mark.skipif(shutil.which("bash") is None, reason="a job array is a shell script")
def test_a_task_builds_its_part(pytestconfig, tmp_path):
    year = pytestconfig.rootpath / "examples" / "year"
    told = tmp_path / "mat"
    told.write_text('#!/bin/sh\necho "$@"\n')
    told.chmod(0o755)
    settings = {"SLURM_ARRAY_TASK_ID": "3", "SLURM_ARRAY_TASK_COUNT": "12", "MAT": str(told)}
    environment = {name: value for name, value in os.environ.items() if not name.startswith("SLURM_")} | settings
    run = subprocess.run(
        ["bash", year / "array.sh"], cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
    )
    out = ["--out", f"{tmp_path}/built", "--verbose", "--part", "3/12", "--jobs", "1"]
    assert run.stdout.split() == ["build", f"{year}/every_day.yaml", *out]
