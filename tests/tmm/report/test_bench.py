"""``tmm bench``: every classifier against labels, the graph with and without a library model."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from skyshine.tmm.cli import main
from skyshine.tmm.report.bench import GRAPH, OURS, PEERS, WITH_MODEL

POLYGONS = """
      polygons:
        grass_green: [[[2, 2], [12, 2], [12, 15], [2, 15]]]
        asphalt_road: [[[25, 3], [38, 3], [38, 12], [25, 12]]]
"""


@pytest.fixture
def bench(tmp_path, two_halves, write_image):
    pytest.importorskip("sklearn")
    truth = np.full((20, 40, 1), 2, np.uint8)
    truth[:, :20] = 1
    write_image("truth.png", truth)
    (tmp_path / "truth.yaml").write_text(
        'truth: {halves: {image: truth.png, palette: {"1": grass_green, "2": asphalt_road}}}\n'
    )

    def run(more: str = "") -> dict:
        (tmp_path / "job.yaml").write_text(f"textures:\n  - image: {two_halves}\n{more}    seeds:{POLYGONS}")
        arguments = ["bench", str(tmp_path / "job.yaml"), str(tmp_path / "truth.yaml"), "--json"]
        done = CliRunner().invoke(main, arguments, catch_exceptions=False)
        assert done.exit_code == 0, done.output
        return {row["name"]: row for row in json.loads(done.stdout)["classifiers"]}

    return run


def test_all_classifiers_tell_two_plain_halves(bench):
    rows = bench()
    assert list(rows) == [*OURS, GRAPH, WITH_MODEL, *PEERS]
    for name, row in rows.items():
        assert row["overall_accuracy"]["value"] > 0.9, name  # boxes reach over the border
        assert row["rate"]["value"] > 0, name


def test_a_library_that_is_wrong_spoils_its_own_row_alone(bench, tmp_path):
    right = bench()
    # A model whose names are exchanged.
    swapped = POLYGONS.replace("grass_green", "x").replace("asphalt_road", "grass_green").replace("x", "asphalt_road")
    (tmp_path / "wrong.yaml").write_text(f"textures:\n  - image: halves.png\n    seeds:{swapped}")
    trained = CliRunner().invoke(
        main, ["train", str(tmp_path / "wrong.yaml"), "--out", str(tmp_path / "wrong.tmm-model.h5")]
    )
    assert trained.exit_code == 0, trained.output
    wrong = bench("    model: wrong.tmm-model.h5\n")
    changed = {name for name in right if wrong[name]["overall_accuracy"] != right[name]["overall_accuracy"]}
    confidence = {name for name in right if wrong[name]["calibration_error"] != right[name]["calibration_error"]}
    assert confidence | changed == {WITH_MODEL}
