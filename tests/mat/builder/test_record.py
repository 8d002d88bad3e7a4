"""The record of a build: what each file cost, and for files that were kept what the earlier build says."""

import json

from skyshine.mat.builder import record
from skyshine.mat.products.product import TaskReport
from skyshine.mat.tables.build_record import cost_of


def write_record(folder, reports, seconds):
    result = record.record_of(folder, reports, seconds)
    record.write_record(folder, result)
    return result


def report(*files, **settings):
    values = {"seconds": 3.00049, "processor_seconds": 2.0, "stages": {"solve": 1.23456}, "peak_memory": 77}
    values["processor_stages"] = {"solve": 1.11111}
    return TaskReport(files, **{**values, **settings})


def test_the_file_holds_what_is_returned(tmp_path):
    result = write_record(tmp_path, [report("a.h5", "b.h5", notes=["n"])], 4.5678)
    assert result == json.loads((tmp_path / "build.json").read_text(encoding="utf-8"))
    assert (result["folder"], result["seconds"], result["not_of_this_job"]) == (str(tmp_path), 4.568, [])
    assert result["files"]["b.h5"] == result["files"]["a.h5"] | {"made_with": "a.h5"}  # one computation makes both
    assert result["files"]["a.h5"] == {
        "kept": False,
        "seconds": 3.0,
        "processor_seconds": 2.0,
        "stages": {"solve": 1.235},
        "processor_stages": {"solve": 1.111},
        "peak_memory_bytes": 77,
        "notes": ["n"],
    }


def test_a_kept_file_keeps_the_cost_of_the_build_that_made_it(tmp_path):
    write_record(tmp_path, [report("a.h5", seconds=50.0)], 60.0)
    write_record(tmp_path, [report("a.h5", kept=True, seconds=0.01, stages={})], 0.1)
    cost = cost_of(tmp_path / "a.h5")
    assert cost["kept"] and cost["seconds"] == 50.0 and cost["stages"] == {"solve": 1.235}


def test_a_file_written_again_has_its_new_cost(tmp_path):
    write_record(tmp_path, [report("a.h5", seconds=50.0)], 60.0)
    write_record(tmp_path, [report("a.h5", seconds=5.0)], 6.0)
    assert cost_of(tmp_path / "a.h5")["seconds"] == 5.0


def test_a_kept_file_of_a_lost_record_has_no_cost_but_an_entry(tmp_path):
    (tmp_path / "build.json").write_text("{", encoding="utf-8")
    entry = write_record(tmp_path, [report("a.h5", kept=True, stages={})], 0.1)["files"]["a.h5"]
    assert entry["kept"] and entry["stages"] == {} and cost_of(tmp_path / "a.h5") is None


def test_a_file_has_the_error_that_its_table_states(tmp_path):
    error = {"quantity": "temperature", "p99": 0.1, "maximum": 0.4}
    files = write_record(tmp_path, [report("a.h5", "b.h5", error_kelvin={"a.h5": error})], 1.0)["files"]
    assert files["a.h5"]["error_kelvin"] == error and "error_kelvin" not in files["b.h5"]
