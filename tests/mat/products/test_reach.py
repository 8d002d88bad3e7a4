"""What a check says of tolerances is what a build finds."""

import pytest
import yaml

from skyshine.mat.builder.tasks import run_task
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.plan import Kind, make_plan
from skyshine.mat.products import reach
from skyshine.materials.library import load_library
from skyshine.schemas.errors import CheckFailed, InputError


@pytest.fixture
def job(tmp_path, tiny_job):
    """Loads the tiny job with some keys of its grids changed."""

    def loaded(**grids):
        content = yaml.safe_load(tiny_job().replace("[00:00, 12:00]", "['00:00', '12:00']"))
        for name, keys in grids.items():
            content[name] = content[name] | keys if isinstance(keys, dict) else keys
        (tmp_path / "job.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
        return load_job(tmp_path / "job.yaml")

    return loaded


def test_temperatures_that_too_few_nodes_hold_are_refused_as_the_build_refuses_them(job, tmp_path):
    loaded = job(surface_grid={"tolerance": "0.5 K", "most_nodes": 500})
    with pytest.raises(InputError, match=r"surface_grid\.tolerance 0.5 K cannot be held with 500 nodes") as refused:
        reach.tolerance_notes(loaded, ["asphalt_road"])
    assert refused.value.line and "\n" not in str(refused.value)
    plan = make_plan(loaded, load_library())
    task = next(task for task in plan.tasks if task.kind is Kind.TEMPERATURE)
    with pytest.raises(CheckFailed) as failed:
        run_task(task, loaded, tmp_path, plan.materials, True)
    assert str(failed.value) in str(refused.value)


def test_temperatures_that_enough_nodes_hold_are_not_remarked_on(job):
    assert (
        reach.tolerance_notes(job(surface_grid={"tolerance": "0.5 K", "most_nodes": 200_000}), ["asphalt_road"]) == []
    )
    assert reach.tolerance_notes(job(), ["asphalt_road"]) == []


def test_a_sample_tells_of_many_materials_with_numbers(job, monkeypatch):
    monkeypatch.setattr(reach, "_MATERIALS", 1)
    names = ["asphalt_road", "concrete", "shrub", "soil_sand"]
    (note,) = reach.tolerance_notes(job(surface_grid={"tolerance": "0.5 K", "most_nodes": 2000}), names)
    assert "0.5 K: 4 materials in 2,000 nodes: the build will likely end" in note
    unwritten = job(surface_grid={"most_nodes": 2000})
    object.__setattr__(unwritten.trimmed.surface_grid, "tolerance", "0.5 K")  # as by default with axes of its own
    (note,) = reach.tolerance_notes(unwritten, names)
    assert "are likely within" in note and "the file states its error" in note


def test_channels_need_the_nodes_from_which_placing_starts(job):
    with pytest.raises(InputError, match=r"atmosphere_grid\.most_nodes: found 40; allowed: at least \d+, from which"):
        reach.tolerance_notes(job(atmosphere_grid={"most_nodes": 40}), [])


@pytest.mark.parametrize("band", [[10.0, 10.2], [0.5, 0.52]])
def test_tolerances_of_channels_finer_than_any_build_held_are_refused(band, job):
    bands = [{"wavelength_um": band}]
    with pytest.raises(InputError, match=r"found 1e-5 K, .* of the radiance of band 1; no build held less"):
        reach.tolerance_notes(job(bands=bands, atmosphere_grid={"tolerance": "1e-5 K"}), [])
    (note,) = reach.tolerance_notes(job(bands=bands, atmosphere_grid={"tolerance": "0.004 K"}), [])
    assert "found 0.004 K" in note and "is safer" in note
    assert reach.tolerance_notes(job(bands=bands, atmosphere_grid={"tolerance": "0.1 K"}), []) == []


@pytest.mark.parametrize(
    ("band", "elevation", "tolerance", "notes"),
    [
        ([3.7, 3.9], [-20, 60], "0.5 K", 1),
        ([3.7, 3.9], [-20, 60], "1 K", 0),
        ([3.7, 3.9], [10, 60], "0.5 K", 0),
        ([3.0, 5.0], [-20, 60], "0.3 K", 0),
        ([10.0, 10.2], [-20, 60], "0.3 K", 0),
    ],
)
def test_a_low_sun_that_outweighs_emission_is_remarked_on(band, elevation, tolerance, notes, job):
    """As builds of these bands ended, or held."""
    loaded = job(
        bands=[{"wavelength_um": band}],
        atmosphere_grid={"tolerance": tolerance, "source_elevation_deg": elevation},
    )
    assert ["more light of a low Sun" in note for note in reach.tolerance_notes(loaded, [])] == [True] * notes
