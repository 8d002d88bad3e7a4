"""The record beside a database: its cost, and no cost where the record is missing, damaged or silent."""

import json

import pytest

from skyshine.mat.tables.build_record import cost_of

COST = {"kept": False, "seconds": 2.5, "stages": {"solve": 2.0}}


def write(folder, text):
    (folder / "build.json").write_text(text, encoding="utf-8")
    return folder / "s01.htt.h5"


def test_a_cost_is_read_by_the_name_of_the_file(tmp_path):
    other = {**COST, "seconds": 9.0}
    file = write(tmp_path, json.dumps({"files": {"b01.band.h5": other, "s01.htt.h5": COST}}))
    assert cost_of(file) == COST and cost_of(tmp_path / "b01.band.h5") == other


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[1, 2]",
        "null",
        json.dumps({"files": {}}),
        json.dumps({"files": []}),
        json.dumps({"files": {"s01.htt.h5": 3}}),
        json.dumps({"files": {"s01.htt.h5": {"seconds": 1.0}}}),
        json.dumps({"files": {"s01.htt.h5": {**COST, "stages": {}}}}),
        json.dumps({"files": {"s01.htt.h5": {**COST, "stages": ["solve"]}}}),
        "[" * 100_000,
    ],
)
def test_what_the_record_does_not_say_is_not_known(tmp_path, text):
    assert cost_of(write(tmp_path, text)) is None


def test_a_folder_without_a_record_knows_no_cost(tmp_path):
    assert cost_of(tmp_path / "s01.htt.h5") is None
    (tmp_path / "build.json").write_bytes(b"\xff\xfe\xff")
    assert cost_of(tmp_path / "s01.htt.h5") is None
