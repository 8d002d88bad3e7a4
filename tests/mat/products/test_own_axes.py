"""Atmospheric tables on axes that a job does not write: each quantity on its own nodes, with the numbers that it has on
any others.
"""

import h5py
import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.builder.tasks import run_task
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.plan import Kind, make_plan
from skyshine.mat.scene.grids import path_grid
from skyshine.mat.tables.gridded import AXES, FIELDS, QUANTITIES
from skyshine.mat.tables.verify import problems
from skyshine.materials.library import load_library

FILE = "s01b01.atmq.h5"


@pytest.fixture(scope="module")
def task_of(builds_here, tiny_job, tmp_path_factory):
    """Builds the air of the tiny job with its source elevations replaced; gives the job, task and folder."""

    def built(line):
        folder = tmp_path_factory.mktemp("air")
        text = tiny_job()
        assert "  source_elevation_deg: [-20, 60]\n" in text
        (folder / "job.yaml").write_text(text.replace("  source_elevation_deg: [-20, 60]\n", line), encoding="utf-8")
        loaded = load_job(folder / "job.yaml")
        plan = make_plan(loaded, load_library())
        task = next(task for task in plan.tasks if task.kind is Kind.ATMOSPHERE)
        run_task(task, loaded, folder, plan.materials, True)
        return loaded, task, folder

    return built


@pytest.fixture(scope="module")
def plain(task_of):
    """With the default source elevations."""
    return task_of("")


def test_each_quantity_stands_on_its_own_nodes_and_the_plan_counts_them(plain):
    loaded, task, folder = plain
    assert problems(folder / FILE) == []
    table = skyshine.mat.open(folder / FILE)
    for name, (_, count) in QUANTITIES.items():
        grid = path_grid(loaded.trimmed, name)
        rules = table.rules(name)
        assert [rule.name for rule in rules] == list(AXES[:count])
        for rule, field in zip(rules, FIELDS[:count], strict=True):
            np.testing.assert_array_equal(rule.nodes, getattr(grid, field), err_msg=f"{name} {field}")
    assert len({table.rules(name)[3].nodes.size for name in QUANTITIES if name != "beta_star"}) == 3
    with h5py.File(folder / FILE) as file:
        arrays = [entry for entry in file.values() if isinstance(entry, h5py.Dataset) and entry.ndim > 1]
        counted = [entry for entry in arrays if "thermal" not in entry.name and entry.dtype != np.int8]
        assert sum(entry.size for entry in counted) == task.values


def test_numbers_at_a_node_hardly_depend_on_the_other_nodes(plain, task_of):
    """The axes of a job choose the spectral points: the last digits differ."""
    _, _, folder = task_of("  source_elevation_deg: [-10, -2, 0, 20, 90]\n")
    own, written = (skyshine.mat.open(place / FILE) for place in (plain[2], folder))
    for name, (_, count) in QUANTITIES.items():
        nodes = dict(zip(AXES[:count], np.ix_(*(rule.nodes for rule in written.rules(name))), strict=True))
        np.testing.assert_allclose(
            own.value(name, **nodes), written.root.variables[name].data, rtol=5e-3, atol=1e-5, err_msg=name
        )


def test_a_job_that_writes_the_default_axis_is_another_file(plain, task_of):
    shared = path_grid(plain[0].trimmed).source_elevation_deg.tolist()
    loaded, _, folder = task_of(f"  source_elevation_deg: {shared}\n")
    table = skyshine.mat.open(folder / FILE)
    assert all(
        table.rules(name)[-1 if name != "path_radiance_ratio" else 3].nodes.size == 13 for name in list(QUANTITIES)[1:]
    )
    assert table.attributes["job"] != skyshine.mat.open(plain[2] / FILE).attributes["job"]
    assert loaded.trimmed.atmosphere_grid.model_dump() == plain[0].trimmed.atmosphere_grid.model_dump()
