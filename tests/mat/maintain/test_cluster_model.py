"""The simulated batch against its closed forms, and the table of the page against its results."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from mat.maintain.bench.cluster_model import SPREAD, Batch, Costs, Outcome, of_dask, of_parts, table

ROOT = Path(__file__).parents[3]
BATCH = Batch(sites=4, days=30, bands=2)
TASKS = 4 * 30 * 3
COSTS = Costs(3.0, 6.0, 20.0, 100_000, 200_000, 0.0, 0.0, 1e9, 1e15)
WORK = 4 * 30 * (2 * 3.0 + 6.0) * 2.718281828 ** (SPREAD**2 / 2)


def test_one_core_takes_the_work_and_each_cell_once():
    outcome = of_dask(BATCH, COSTS, 1, shared=True)
    cells = 20.0 * COSTS.cells * BATCH.bands * BATCH.sites  # four sites of four altitudes
    assert outcome.hours * 3600 == pytest.approx(WORK + cells, rel=0.03)
    assert outcome.efficiency == pytest.approx(WORK / (WORK + cells), rel=0.03) and outcome.idle_share == pytest.approx(
        0
    )


def test_a_client_or_a_file_system_that_is_busy_all_the_time_sets_the_hours():
    slow_client = of_dask(BATCH, replace(COSTS, submit_seconds=10.0, site_seconds=100.0), 500, shared=True)
    assert slow_client.hours * 3600 == pytest.approx(TASKS * 10.0 + 4 * 100.0, rel=0.02)
    slow_disk = of_dask(BATCH, replace(COSTS, bytes_per_second=1e4), 500, shared=True)
    written = 4 * 30 * (2 * 100_000 + 200_000) / 1e4
    assert slow_disk.hours * 3600 == pytest.approx(written, rel=0.02)
    assert of_parts(BATCH, replace(COSTS, bytes_per_second=1e4), 500).hours * 3600 == pytest.approx(written, rel=0.02)


def test_cells_of_each_process_cost_more_than_those_of_a_folder_and_cores_never_slow_a_batch():
    for ways in (
        [of_dask(BATCH, COSTS, cores, shared=True) for cores in (2, 8, 32)],
        [of_dask(BATCH, COSTS, cores, shared=False) for cores in (2, 8, 32)],
        [of_parts(BATCH, COSTS, cores) for cores in (2, 8, 32)],
    ):
        assert [each.hours for each in ways] == sorted((each.hours for each in ways), reverse=True)
    assert of_dask(BATCH, COSTS, 8, shared=False).cell_share > of_dask(BATCH, COSTS, 8, shared=True).cell_share


def test_the_page_has_the_table_of_the_results():
    results = json.loads((ROOT / "tests/validation/cluster_model.json").read_text(encoding="utf-8"))
    page = (ROOT / "examples/CLUSTER.md").read_text(encoding="utf-8")
    assert table([Outcome(**each) for each in results["outcomes"]]) in page
