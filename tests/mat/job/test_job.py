"""Jobs: each bad one gives its one line, times and numbers are read as written, the schema is in step."""

from pathlib import Path

import numpy as np
import pytest

from mat.maintain import job_schema
from skyshine import schemas
from skyshine.mat.job.load import load_job
from skyshine.mat.job.site import local_times_utc
from skyshine.mat.scene.check import check_scene
from skyshine.schemas.errors import InputError

BAD_JOBS = sorted((Path(__file__).parents[2] / "data" / "bad_jobs").glob("*.yaml"))

GOOD = """\
skyshine: 1
name: good
site: {latitude_deg: 48.1, longitude_deg: 11.6, date: 2026-06-21, utc_offset_h: 2}
states:
  - profile: midlatitude_summer
    visibility_km: 1.5e1
    weather: {air_temperature_c: [14, 27]}
bands: [{wavelength_um: [8, 12]}]
materials: [concrete]
accuracy: {spectral_tolerance: 1e-3}
surface_grid: {time: [08:30, 12:30, 23:59]}
"""


@pytest.mark.parametrize("file", BAD_JOBS, ids=lambda file: file.stem)
def test_a_bad_job_gives_the_line_it_states(file):
    expected = file.read_text(encoding="utf-8").splitlines()[0].removeprefix("# expect: ")
    with pytest.raises(InputError) as caught:
        check_scene(load_job(file))
    line = str(caught.value)
    assert expected in line and "\n" not in line
    place = line.removeprefix(f"{file}:").split(":")
    assert int(place[0]) > 1 and int(place[1]) > 0


def test_times_and_numbers_are_read_as_they_are_written(tmp_path):
    (tmp_path / "job.yaml").write_text(GOOD, encoding="utf-8")
    job = load_job(tmp_path / "job.yaml").trimmed
    assert job.surface_grid.time == [8.5, 12.5, 23 + 59 / 60]
    assert job.accuracy.spectral_tolerance == 0.001 and job.states[0].visibility_km == 15.0


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("latitude_deg: 48.1", "latitude_deg: true", "site.latitude_deg: found True; input should be a valid number"),
        ("latitude_deg: 48.1", 'latitude_deg: "29.7"', "found '29.7'; input should be a valid number"),
        ("latitude_deg: 48.1", "latitude_deg: 2_9.7", "found '2_9.7'; input should be a valid number"),
        ("date: 2026-06-21", "date: 0", "site.date: found 0; input should be a valid date"),
        ("date: 2026-06-21", "date: '20260621'", "found '20260621'; input should be a valid date"),
        ("skyshine: 1", "skyshine: true", "skyshine: found True"),
        ("accuracy: {", "accuracy: {seed: true, ", "accuracy.seed: found True; input should be a valid integer"),
        ("accuracy: {", "accuracy: {seed: '1', ", "accuracy.seed: found '1'; input should be a valid integer"),
        (
            "materials:",
            "output: {pictures: 1}\nmaterials:",
            "output.pictures: found 1; input should be a valid boolean",
        ),
    ],
)
def test_text_and_truth_are_no_numbers(tmp_path, old, new, message):
    assert old in GOOD
    (tmp_path / "job.yaml").write_text(GOOD.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_job(tmp_path / "job.yaml")
    assert message in str(caught.value)


def test_whole_numbers_stand_for_numbers_and_the_other_way_round(tmp_path):
    text = GOOD.replace("latitude_deg: 48.1", "latitude_deg: 48").replace("accuracy: {", "accuracy: {seed: 2e3, ")
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    job = load_job(tmp_path / "job.yaml").trimmed
    assert job.site.latitude_deg == 48.0 and job.accuracy.seed == 2000


def test_local_hours_become_utc(tmp_path):
    (tmp_path / "job.yaml").write_text(GOOD, encoding="utf-8")
    site = load_job(tmp_path / "job.yaml").trimmed.site
    times = local_times_utc(site, np.array([0.0, 12.5]))
    assert [str(t) for t in times] == ["2026-06-20T22:00:00", "2026-06-21T10:30:00"]


@pytest.mark.parametrize("name", job_schema.MODELS)
def test_the_json_schemas_are_in_step_with_the_models(name):
    assert schemas.path(name).read_text(encoding="utf-8") == job_schema.schema_text(name)


def undescribed(schema, path=""):
    """Keys of a schema, and of all that it holds, that say nothing of themselves."""
    if isinstance(schema, list):
        return [key for part in schema for key in undescribed(part, path)]
    if not isinstance(schema, dict):
        return []
    own = [f"{path}.{key}" for key, part in schema.get("properties", {}).items() if not part.get("description")]
    return own + [key for name, part in schema.items() for key in undescribed(part, f"{path}/{name}")]


@pytest.mark.parametrize("name", job_schema.MODELS)
def test_every_key_of_a_file_says_what_it_is(name):
    import json

    assert undescribed({"$defs": {"A": {"properties": {"b": {"type": "string"}}}}}) == ["/$defs/A.b"]
    assert undescribed(json.loads(job_schema.schema_text(name))) == []


def test_the_schema_accepts_the_good_job_and_refuses_a_bad_one(tmp_path):
    import json

    import jsonschema

    from skyshine.schemas.documents import read_yaml

    schema = json.loads(schemas.path("mat-job.schema.json").read_text(encoding="utf-8"))
    (tmp_path / "job.yaml").write_text(GOOD, encoding="utf-8")
    document = read_yaml(tmp_path / "job.yaml").data
    jsonschema.validate(document, schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(document | {"nmae": "x"}, schema)
