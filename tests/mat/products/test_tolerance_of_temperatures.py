"""The table that holds a tolerance of temperatures is solved once; the tolerance is verified on nodes of it."""

import numpy as np

import skyshine.mat
from skyshine.mat.job.load import load_job
from skyshine.mat.products import temperature


def test_the_table_that_is_written_is_solved_once(build_surface, small_job, tmp_path, monkeypatch):
    text = small_job.read_text(encoding="utf-8").replace("slope_deg: [0, 45]", "slope_deg: [0, 45]\n  tolerance: 2 K")
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    solved, original = [], temperature.temperature_table

    def recorded(*arguments, **options):
        solved.append([np.asarray(axis, float).tobytes() for axis in arguments[4:8]] + [options["steps"]])
        return original(*arguments, **options)

    monkeypatch.setattr(temperature, "temperature_table", recorded)
    file = build_surface(load_job(tmp_path / "job.yaml"), tmp_path)
    # Of so small a table the nodes beside the test places may be all of them, and are solved once more to be written.
    assert len(solved) - 1 <= len({tuple(axes) for axes in solved}) and len(solved) > 5
    axes = skyshine.mat.open(file).root.axes
    written = [1e3 * axes["altitude"].values, *(axes[name].values for name in ("azimuth", "slope", "time"))]
    *_, table, _, _, _ = solved  # then the ground of Cn2 and the errors: of interpolation, of the steps
    assert [values.astype(float).tobytes() for values in written] == table[:4]
