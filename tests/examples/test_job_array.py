"""The job array of a year: its tasks share out all days, each once, and build in folders of their own."""

import csv
import os
import shutil
import subprocess

import pytest

from skyshine.mat.job.load import load_job


@pytest.mark.skipif(shutil.which("bash") is None, reason="a job array is a shell script")
def test_the_tasks_share_out_all_days(pytestconfig, tmp_path):
    year = pytestconfig.rootpath / "examples" / "year"
    told = tmp_path / "mat"
    told.write_text('#!/bin/sh\necho "$@"\n')
    told.chmod(0o755)
    days = []
    for part in range(1, 13):
        settings = {"SLURM_ARRAY_TASK_ID": str(part), "SLURM_ARRAY_TASK_COUNT": "12", "MAT": str(told)}
        environment = {name: value for name, value in os.environ.items() if not name.startswith("SLURM_")} | settings
        run = subprocess.run(
            ["bash", year / "array.sh"], cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
        )
        out = tmp_path / "built" / f"part_{part:02d}"
        assert run.stdout.split() == ["build", f"{out}/job.yaml", "--out", str(out), "--jobs", "1", "--verbose"]
        with open(out / "every_day.csv", newline="") as file:
            days += [row["date"] for row in csv.DictReader(file)]
    assert len(days) == len(set(days)) == 365 and days == sorted(days)
    loaded = load_job(tmp_path / "built" / "part_02" / "job.yaml")
    assert len(loaded.trimmed.states) == 30
