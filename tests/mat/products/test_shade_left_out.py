"""The response to shade in a built file: with its stated error, or left out as the job says."""

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.left_out import tables_left_out
from skyshine.mat.tables.verify import problems
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError

LEFT_OUT = "needs: {shade: false}\n"


@pytest.fixture(scope="module")
def files(build_surface, tiny_job, tmp_path_factory):
    """The temperature tables of a job and of one that leaves the response out."""
    tables = []
    for text in (tiny_job(), tiny_job() + LEFT_OUT):
        folder = tmp_path_factory.mktemp("shade")
        (folder / "job.yaml").write_text(text, encoding="utf-8")
        tables.append(skyshine.mat.open(build_surface(load_job(folder / "job.yaml"), folder)))
    return tables


def test_both_are_sound_and_hold_the_same_temperatures(files):
    whole, less = files
    assert problems(whole.path) == problems(less.path) == []
    assert np.array_equal(*(file.root.variables["temperature"].data for file in files))
    of_surfaces = [name for name in less.quantities if not name.startswith(("sun_", "moon_"))]
    assert "response_kernel" in whole.quantities and of_surfaces == ["temperature", "cn2"]
    assert less.path.stat().st_size < whole.path.stat().st_size


def test_the_file_states_its_error_under_shade(files):
    whole, less = files
    assert 0 < whole.error("shaded_temperature")["rms"] < 0.5 and less.error("shaded_temperature") == {}
    by_material = whole.root.groups["accuracy"].variables["shade_rms"].data
    assert by_material.shape == (1,) and 0 < by_material[0] < 0.5


def test_only_the_whole_file_is_shaded(files):
    whole, less = files
    assert whole.shaded_temperature(material="asphalt_road", time=12) < whole.temperature(
        material="asphalt_road", time=12
    )
    with pytest.raises(InputError, match="has no response to shade"):
        less.shaded_temperature(material="asphalt_road", time=12)


def test_the_plan_says_what_is_left_out_and_how_to_restore_it(tiny_job, tmp_path):
    for text, said in ((tiny_job() + LEFT_OUT, True), (tiny_job(), False)):
        (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
        left_out = tables_left_out(load_job(tmp_path / "job.yaml"), load_library(), ("asphalt_road",))
        assert any(entry.restore == "needs.shade: true" for entry in left_out) is said
