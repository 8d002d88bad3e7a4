"""Days of `examples/year/every_day.yaml` in two processes, killed twice on the way: the bytes of a build of its own.

SKYSHINE_DAYS sets how many days from 1 April (default 4; 91 are a quarter of a year: half an hour of two cores).
"""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from result_blocks import keep

from skyshine.materials.library import load_library

pytestmark = pytest.mark.validation
DAYS = int(os.environ.get("SKYSHINE_DAYS", "4"))
YEAR = Path(__file__).parents[2] / "examples" / "year"
RESULTS = Path(__file__).with_name("year_results.json")
PAGE = YEAR.parent / "CLUSTER.md"
COMMAND = [sys.executable, "-c", "from skyshine.mat.cli import main; main()", "build", "job.yaml"]
KINDS = {"b01.atmq.h5": "3 to 5 um", "b02.atmq.h5": "8 to 12 um", ".htt.h5": "temperatures"}
CHECKED = 5  # days that are built again, from the first


def write_job(folder, days):
    """The example with 82 materials and so many days from 1 April."""
    names = ", ".join(list(load_library().names)[::2][:82])
    text = (YEAR / "every_day.yaml").read_text(encoding="utf-8").replace("built_every_day", "built")
    (folder / "job.yaml").write_text(text.replace("materials: all", f"materials: [{names}]"), encoding="utf-8")
    _, head, *rows = (YEAR / "every_day.csv").read_text(encoding="utf-8").splitlines()
    spring = [row for row in rows if row >= "2026-04"][:days]
    (folder / "every_day.csv").write_text("\n".join([head, *spring]) + "\n", encoding="utf-8")


def kill_when(build, folder, count):
    """Kill a build when its folder has so many databases."""
    while build.poll() is None and len(list(folder.glob("*.h5"))) < count:
        time.sleep(0.2)
    build.send_signal(signal.SIGKILL)
    return build.wait() == -signal.SIGKILL


def test_a_build_that_is_killed_twice_has_the_bytes_of_another(tmp_path, contents):
    write_job(tmp_path, DAYS)
    built, files = tmp_path / "built", 3 * DAYS + 2
    environment = os.environ | {"SKYSHINE_CACHE": str(tmp_path / "cache")}
    killed = [
        kill_when(subprocess.Popen([*COMMAND, "--jobs", "2"], cwd=tmp_path, env=environment), built, count)
        for count in (files // 3, 2 * files // 3)
    ]
    subprocess.run([*COMMAND, "--jobs", "2"], cwd=tmp_path, env=environment, check=True)
    again = tmp_path / "again"
    again.mkdir()
    write_job(again, min(CHECKED, DAYS))
    environment = os.environ | {"SKYSHINE_CACHE": str(tmp_path / "other")}
    subprocess.run([*COMMAND, "--jobs", "1"], cwd=again, env=environment, check=True)
    expected, found = contents(again / "built"), contents(built)
    assert killed == [True, True] and len(found) == files
    assert len(expected) >= 3 and [name for name in expected if expected[name] != found[name]] == []
    if os.environ.get("SKYSHINE_WRITE"):
        write_results(built, again / "built", len(killed))


def write_results(built, again, killed):
    """Keep means by kind of table of a folder of days, killed so many times, some of which were built again."""
    record = json.loads((again / "build.json").read_text(encoding="utf-8"))["files"]
    tables = {}
    for ending, kind in KINDS.items():
        files = [path for path in built.glob("s*.h5") if path.name.endswith(ending)]
        seconds = [entry["processor_seconds"] for name, entry in record.items() if name.endswith(ending)]
        tables[kind] = {
            "files": len(files),
            "kilobytes": round(float(np.mean([path.stat().st_size for path in files])) / 1e3, 1),
            "built_again": len(seconds),
            "processor_seconds": round(float(np.median(seconds)), 2),
        }
    keep({"killed": killed, "tables": tables}, RESULTS, PAGE, paragraph)


def paragraph(results):
    """The results as the page has them."""
    tables = results["tables"]
    total, entry = sum(each["kilobytes"] for each in tables.values()), tables["temperatures"]
    sizes = ", ".join(f"{each['kilobytes']:.0f} {_of(kind)}" for kind, each in tables.items())
    times = ", ".join(f"{each['processor_seconds']:.1f} s {_of(kind)}" for kind, each in tables.items())
    return (
        f"A day of `year/every_day.yaml`, two bands at 0.5 K and 82 materials, takes {total:.0f} kB: {sizes}; at this"
        f" rate a year is {365 * total / 1e3:.0f} MB. One more day takes a busy processor {times} (medians).\n"
        f"{entry['files']} days from 1 April were built in two processes that were killed {results['killed']} times;"
        f" {entry['built_again']} of them, built again elsewhere, had the same bytes (`tests/validation/test_year.py`)."
    )


def _of(kind):
    return f"of {kind}" if kind == "temperatures" else f"in {kind}"


def test_page_has_the_results():
    assert paragraph(json.loads(RESULTS.read_text(encoding="utf-8"))) in PAGE.read_text(encoding="utf-8")
