"""Days of materials before and after: a change that is planted is the change that is drawn."""

import shutil

import numpy as np
import pytest
from click.testing import CliRunner

from mat.maintain.materials.days import SHOWN, Day, days_of, main
from skyshine import materials
from skyshine.mat.api.examples import starter_files
from skyshine.materials.library import load_library


@pytest.fixture(scope="module")
def before(tmp_path_factory):
    """Two packaged materials, the concrete with the spectrum of a white roof."""
    folder = tmp_path_factory.mktemp("before") / "materials"
    for part in ("ht", "ref", "spec"):
        (folder / part).mkdir(parents=True)
        for name in ("concrete", "basalt"):
            (file,) = materials.path(part).glob(f"{name}.*")
            shutil.copy(file, folder / part)
    white = materials.path("ref/roof_membrane_white.csv").read_text(encoding="utf-8")
    (folder / "ref" / "concrete.csv").write_text(white.replace("roof_membrane_white", "concrete"), encoding="utf-8")
    library = load_library()
    rows = [
        f'  - {{code: {library[name].code}, name: {name}, group: x, description: "x"}}'
        for name in ("concrete", "basalt")
    ]
    (folder / "mat.yaml").write_text("data_version: 1.0.0\nmaterials:\n" + "\n".join(rows) + "\n", encoding="utf-8")
    return folder


def test_darker_concrete_is_warmer_by_day_and_the_same_basalt_has_the_same_day(before):
    job = next(file for file in starter_files() if file.name == "job.yaml")
    concrete, basalt = days_of(load_library(before), load_library(), ("concrete", "basalt"), job)
    change, hour = concrete.change
    # 0.44 more of at most 1000 W/m2 is absorbed; air and sky take 15 W/m2K or more of it, the ground some.
    assert 5 < change < 0.44 * 1000 / 15 and 11 < hour < 17
    assert np.abs(basalt.after - basalt.before).max() < 1e-9
    assert 278 < concrete.air.min() < concrete.air.max() < 300


def test_largest_change_keeps_its_sign():
    hours = np.array([0.0, 8.0, 16.0])
    day = Day("x", hours, np.array([280.0, 290.0, 300.0]), np.array([281.0, 287.0, 302.0]), np.zeros(3))
    assert day.change == (-3.0, 8.0)


def test_command_draws_and_refuses_a_material_that_the_folder_lacks(before, tmp_path):
    picture = tmp_path / "days.png"
    done = CliRunner().invoke(main, [str(before), str(picture), "concrete"], catch_exceptions=False)
    assert done.exit_code == 0 and done.output.startswith("concrete") and picture.stat().st_size > 5_000
    done = CliRunner().invoke(main, [str(before), str(picture), "granite"])
    assert done.exit_code == 2 and "ht/granite.yaml" in done.output
    assert set(SHOWN) <= set(load_library().names) and len(SHOWN) == 10
