"""Executors: their environment, what is left of processes that stop, and names that are none."""

import os
import signal
import subprocess
import sys
import time

import pytest

from skyshine.mat import threads
from skyshine.mat.builder.cluster import prepare_worker
from skyshine.mat.builder.executors import open_executor
from skyshine.mat.threads import LINEAR_ALGEBRA
from skyshine.schemas.errors import CheckFailed, InputError
from skyshine.schemas.whole_files import PART

# Begins a file and never finishes it; text, for a process that is started anew imports no test.
UNFINISHED = """
import os, pathlib, time
pathlib.Path({folder!r}, f".s01.htt.h5.{{os.getpid()}}{part}").write_bytes(b"half")
time.sleep(60)
"""


def test_processes_have_one_thread_for_linear_algebra_and_the_variables_asked_for(tmp_path, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("SKYSHINE_OF_THE_TEST", raising=False)
    with open_executor(None, 1, tmp_path, {"SKYSHINE_OF_THE_TEST": "here"}) as pool:
        seen = list(pool.map(os.getenv, [*LINEAR_ALGEBRA, "SKYSHINE_OF_THE_TEST"]))
    assert seen == ["1", "1", "1", "here"]
    assert os.environ["OMP_NUM_THREADS"] == "7" and "SKYSHINE_OF_THE_TEST" not in os.environ


def test_a_failure_stops_processes_and_removes_their_unfinished_files(tmp_path):
    other = tmp_path / f".b01.band.h5.1{PART}"
    other.write_bytes(b"of another process")
    begin = time.monotonic()
    with pytest.raises(ZeroDivisionError), open_executor(None, 1, tmp_path) as pool:
        pool.submit(exec, UNFINISHED.format(folder=str(tmp_path), part=PART))
        while len(list(tmp_path.glob(f".*{PART}"))) < 2 and time.monotonic() - begin < 15:
            time.sleep(0.02)
        assert len(list(tmp_path.iterdir())) == 2
        raise ZeroDivisionError
    assert list(tmp_path.iterdir()) == [other]


def test_a_process_that_dies_is_said_in_one_line(tmp_path):
    died = pytest.raises(CheckFailed, match="a process of the build died.*fewer (--)?jobs")
    with died, open_executor(None, 1, tmp_path) as pool:
        pool.submit(signal.raise_signal, signal.SIGKILL).result()


def test_an_error_of_a_task_is_raised_where_its_result_is_asked_for(tmp_path):
    with pytest.raises(ValueError, match="invalid literal"), open_executor(None, 1, tmp_path) as pool:
        pool.submit(int, "x").result()


@pytest.mark.parametrize("name", ["dask", "dask:", "slurm", ""])
def test_other_names_are_refused_with_what_is_allowed(tmp_path, name):
    with pytest.raises(InputError, match=f"found --executor '{name}'; allowed: dask:ADDRESS"):
        open_executor(name, 1, tmp_path)


def test_a_worker_of_a_cluster_uses_one_thread_unless_told_otherwise(monkeypatch):
    monkeypatch.delenv("MALLOC_TRIM_THRESHOLD_", raising=False)
    monkeypatch.setenv(threads.VARIABLE, "3")
    prepare_worker()
    assert os.environ[threads.VARIABLE] == "3"
    monkeypatch.delenv(threads.VARIABLE)
    prepare_worker()
    assert os.environ.pop(threads.VARIABLE) == "1"


def test_a_worker_has_one_thread_for_linear_algebra_whatever_its_environment_says():
    """With two, temperatures differ in their last digits."""
    program = (
        "import numpy, scipy.linalg, threadpoolctl; from skyshine.mat.builder.cluster import prepare_worker\n"
        "threads = lambda: [each['num_threads'] for each in threadpoolctl.threadpool_info()]\n"
        "before = threads(); prepare_worker(); print(before, threads())"
    )
    environment = os.environ | dict.fromkeys(LINEAR_ALGEBRA, "2")
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[2, 2] [1, 1]"
