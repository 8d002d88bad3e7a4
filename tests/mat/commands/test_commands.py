"""The commands on a built job: results, JSON, exit statuses, clear lines."""

import json
import re
import shutil

import numpy as np
import pytest
import yaml

from skyshine.mat.cli import COMMANDS, main


@pytest.fixture
def mat(capsys):
    """Run ``mat`` with arguments: exit status, standard output, standard error."""

    def run(*arguments):
        with pytest.raises(SystemExit) as stop:
            main.main([str(argument) for argument in arguments])
        shown = capsys.readouterr()
        return stop.value.code, shown.out, shown.err

    return run


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help_with_an_example(mat, name):
    status, shown, _ = mat(name, "--help")
    assert status == 0 and "Example: mat" in shown


def test_check_prints_what_is_built_and_when_the_sources_are_up(mat, small_job):
    status, shown, _ = mat("check", small_job, "--json")
    plan = json.loads(shown)
    assert status == 0 and plan["materials"] == ["asphalt_road", "grass_green"]
    assert sorted(plan["files"]) == ["b01.band.h5", "s01.htt.h5", "s01b01.atmq.h5", "s01b01.lunar_atmq.h5"]
    # Almanac for 29.7 N, 82.0 W on 28 June 2026: the Sun is up from about 05:30 to 19:30 EST.
    (rise, sink) = plan["source_up"]["sun"][0]
    assert rise in ("05:30", "05:35") and sink in ("19:25", "19:30")
    assert any("orientations" in item["what"] for item in plan["left_out"])
    assert plan["size_on_disk"]["value"] > 1e5 and plan["memory_of_a_process"]["value"] > 1e8
    assert plan["elapsed_time"]["1"]["value"] > sum(stage["value"] for stage in plan["estimated_time"].values())
    assert "skipped or approximated" in mat("check", small_job, "--verbose")[1]


def test_check_fits_a_screen_and_says_what_a_build_takes_and_what_takes_half(mat, small_job):
    shown = mat("check", small_job)[1]
    assert len(shown.splitlines()) <= 20 and "files: 1 atmq, 1 lunar_atmq, 1 htt, 1 band" in shown
    for text in ("time: ", "disk: ", "memory: up to ", "--verbose"):
        assert text in shown, text
    assert "accuracy: 0.5 K of a pixel, but for the 5 K of atmosphere_grid and the nodes of surface_grid;" in shown
    assert re.search(r"\n(half of it|less): ", shown)


def test_check_of_many_states_at_many_sites_says_what_they_span(mat, small_job, tmp_path):
    job = yaml.safe_load(small_job.read_text(encoding="utf-8"))
    site = job.pop("site")
    job["site"] = {key: site.pop(key) for key in ("date", "utc_offset_h")}
    job["sites"] = [{"name": f"p{k}", **site, "latitude_deg": 30 + k} for k in range(3)]
    job["surface_grid"]["time"] = ["00:00", "12:00"]
    weathers = ([2, 8], [22, 33])
    job["states"] = [job["states"][0] | {"weather": {"air_temperature_c": celsius}} for celsius in weathers]
    (tmp_path / "job.yaml").write_text(yaml.safe_dump(job), encoding="utf-8")
    status, shown, _ = mat("check", tmp_path / "job.yaml")
    lines = shown.splitlines()
    assert status == 0 and len(lines) <= 20 and "OK (3 sites, p0 to p2)" in lines[0]
    assert lines[1].startswith("6 states: midlatitude_summer; air at the ground 278.1 to 300.6 K")
    assert sum(line.startswith("warning: site p") for line in lines) <= 4
    full = mat("check", tmp_path / "job.yaml", "--verbose")[1]
    assert all(f"site p{k}, state 0{n}: midlatitude_summer" in full for k in range(3) for n in (1, 2))


def test_check_says_which_tables_on_axes_are_built_and_why_it_does_not_know_how_many_nodes_a_tolerance_takes(
    mat, small_job, tmp_path
):
    assert "tables on the five axes of the job too, 4 x 2 x 6 x 4 x 3 nodes" in mat("check", small_job, "--verbose")[1]
    job = tmp_path / "job.yaml"
    text = small_job.read_text(encoding="utf-8").replace("surface_grid:", "surface_grid:\n  tolerance: 0.2 K")
    job.write_text(text, encoding="utf-8")
    shown = mat("check", job, "--verbose")[1]
    assert "until 0.2 K is reached" in shown and "not known before the build" in shown
    assert "at most 40,000,000 nodes" in shown


def test_check_warns_of_weather_far_from_the_profile_and_says_what_the_air_follows(mat, small_job, tmp_path):
    """Midlatitude summer has 294.2 K at sea level."""
    job = tmp_path / "job.yaml"
    text = small_job.read_text(encoding="utf-8").replace("[22, 33]", "[2, 8]").replace("[8, 12]", "[10, 10.2]")
    job.write_text(text, encoding="utf-8")
    status, shown, _ = mat("check", job)
    assert status == 0 and "air at the ground 278.1 K, 60 % (weather, day's mean)" in shown
    assert (
        "\nwarning: state 1: weather of 278.1 K at the ground (day's mean) and the profile midlatitude_summer" in shown
    )
    plan = json.loads(mat("check", job, "--json")[1])
    assert "16.1 K apart" in plan["warnings"][0] and len(plan["warnings"]) == 2  # and the spread of continua
    assert "water vapour continua of MT_CKD differ by" in shown
    assert plan["states"][0]["air_temperature_at_ground"]["value"] == pytest.approx(278.15)


def test_info_shows_versions_axes_and_errors(mat, small_build):
    status, shown, _ = mat("info", small_build / "s01b01.atmq.h5", "--json")
    content = json.loads(shown)
    assert status == 0 and content["attributes"]["filetype"] == "atmq"
    assert (content["attributes"]["state"], content["attributes"]["air"]) == (
        "midlatitude_summer",
        "weather, day's mean",
    )
    assert content["axes"]["share"]["nodes"] > 2 and content["variables"]["thermal_ratio"]["axes"][0] == "share"
    tables = content["grid"]
    assert tables["variables"]["beta_star"]["axes"] == ["range", "altitude", "elevation"]
    assert tables["accuracy"]["rms_kelvin"]["values"]["beta_star"] > 0
    assert tables["axes"]["range"] == {
        "units": "km",
        "nodes": 4,
        "long_name": tables["axes"]["range"]["long_name"],
        "from": 0.001,
        "to": 20.0,
    }
    assert content["accuracy"]["rms_kelvin"]["values"]["beta_star"] > 0
    assert content["cost"]["channels"]["value"] > 0 and content["cost"]["channels"]["units"] == "s"
    plain = mat("info", small_build / "s01b01.atmq.h5")[1]
    assert "beta_star" in plain and "cost, with the files of the same task: compile" in plain


@pytest.mark.parametrize(
    "record", [None, "{", '{"files": []}', '{"files": {"s01.htt.h5": {"stages": 3}}}', "[" * 100_000]
)
def test_info_without_a_sound_record_of_cost(mat, small_build, tmp_path, record):
    shutil.copy(small_build / "s01.htt.h5", tmp_path)
    if record is not None:
        (tmp_path / "build.json").write_text(record, encoding="utf-8")
    status, shown, _ = mat("info", tmp_path / "s01.htt.h5", "--json")
    assert status == 0 and json.loads(shown)["cost"] == {}


def test_a_folder_is_no_database(mat, small_build):
    status, _, complaint = mat("info", small_build)
    assert status == 2 and "is a folder; name one of the files in it" in complaint


def test_verify_is_0_for_good_files_1_for_changed_ones(mat, small_build, tmp_path):
    files = sorted(small_build.glob("*.h5"))
    assert mat("verify", *files)[0] == 0
    import h5py

    changed = tmp_path / "b01.band.h5"
    changed.write_bytes((small_build / "b01.band.h5").read_bytes())
    with h5py.File(changed, "r+") as file:
        file["reflectance"][0] = 0.5
    status, shown, complaint = mat("verify", changed, "--json")
    assert status == 1 and json.loads(shown)["ok"] is False and "1 of 1 files fail" in complaint
    assert mat("verify", tmp_path / "none.h5")[0] == 2


def test_query_gives_a_value_with_its_stated_error(mat, small_build):
    place = ["material=asphalt_road", "altitude=0.5", "azimuth=200", "slope=20", "time=13.5"]
    status, shown, _ = mat("query", small_build / "s01.htt.h5", "temperature", *place, "--json")
    result = json.loads(shown)
    assert (
        status == 0
        and result["units"] == "K"
        and 290 < result["value"] < 345
        and result["stated_error"]["maximum"]["value"] > 0
    )
    assert "temperature = " in mat("query", small_build / "s01.htt.h5", "temperature", *place)[1]


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["temprature", "material=1"], "found the quantity 'temprature'; did you mean 'temperature'?"),
        (
            ["temperature", "material=concrete", "altitude=0", "azimuth=0", "slope=0", "time=1"],
            "found the material 'concrete'",
        ),
        (["temperature", "material=asphalt_road", "azimuth=0", "slope=0", "time=1"], "the axis 'altitude' is missing"),
        (
            ["temperature", "material=asphalt_road", "altitude=9", "azimuth=0", "slope=0", "time=1"],
            "altitude: found 9; allowed: 0 to 1",
        ),
        (
            ["temperature", "material=asphalt_road", "altitude=x"],
            "found 'x' for the axis 'altitude'; allowed: a number",
        ),
        (["temperature", "noon"], "found 'noon'; allowed: AXIS=VALUE"),
    ],
)
def test_a_wrong_query_is_one_clear_line(mat, small_build, arguments, complaint):
    status, _, shown = mat("query", small_build / "s01.htt.h5", *arguments)
    assert status == 2 and complaint in shown and shown.strip().count("\n") == 0


def test_transmittance_follows_from_beta_star(mat, small_build):
    status, _, shown = mat("query", small_build / "s01b01.atmq.h5", "transmittance", "range=1")
    assert status == 2 and "ask for beta_star [km]: transmittance = exp(-5.5 range / beta_star)" in shown


def test_info_draws_several_files_into_a_folder(mat, small_build, tmp_path):
    status, _, _ = mat("info", small_build / "s01.htt.h5", small_build / "b01.band.h5", "--out", tmp_path / "p")
    assert status == 0 and sorted(p.name for p in (tmp_path / "p").iterdir()) == ["b01.band.png", "s01.htt.png"]
    assert mat("info", small_build / "s01.htt.h5", "--out", tmp_path / "x.jpg")[0] == 2
    status, _, message = mat("info", small_build / "s01.htt.h5", "--out", tmp_path / "nowhere" / "x.png")
    assert status == 2 and "cannot be written: No such file or directory" in message
    status, _, message = mat("info", tmp_path / "a.tmm.h5", "--out", tmp_path / "x.png")
    assert status == 2 and "tmm preview" in message


def test_init_writes_a_job_that_checks_and_never_overwrites(mat, tmp_path):
    assert mat("init", tmp_path / "demo")[0] == 0
    status, shown, _ = mat("check", tmp_path / "demo" / "job.yaml", "--verbose")
    assert status == 0 and "yellowstone_road.tmm.h5" in shown and "no texture uses them" in shown
    status, _, complaint = mat("init", tmp_path / "demo")
    assert status == 2 and "exists already" in complaint


def test_init_names_the_schema_by_which_editors_complete_a_job(mat, tmp_path):
    import json

    import jsonschema

    from skyshine.schemas.documents import read_yaml

    assert mat("init", tmp_path, "--example", "street")[0] == 0
    for name, schema in (("job", "mat-job"), ("scene", "mat-scene")):
        first, _ = (tmp_path / f"{name}.yaml").read_text(encoding="utf-8").split("\n", 1)
        assert first == f"# yaml-language-server: $schema={schema}.schema.json"
        rules = json.loads((tmp_path / first.rpartition("=")[2]).read_text(encoding="utf-8"))
        jsonschema.validate(read_yaml(tmp_path / f"{name}.yaml").data, rules)


def test_init_into_a_folder_with_one_of_its_files_writes_none(mat, tmp_path):
    (tmp_path / "mat-scene.schema.json").write_text("{}", encoding="utf-8")
    status, _, complaint = mat("init", tmp_path, "--example", "street")
    assert status == 2 and "mat-scene.schema.json: exists already; name an empty folder" in complaint
    assert [path.name for path in tmp_path.iterdir()] == ["mat-scene.schema.json"]


def test_build_reports_bad_jobs_with_status_2_and_leaves_nothing(mat, tmp_path):
    (tmp_path / "job.yaml").write_text("skyshine: 1\nnaem: x\n", encoding="utf-8")
    status, _, complaint = mat("build", tmp_path / "job.yaml")
    assert status == 2 and f"{tmp_path / 'job.yaml'}:2:1: unknown key 'naem'; did you mean 'name'?" in complaint
    assert [p.name for p in tmp_path.iterdir()] == ["job.yaml"]


def test_build_prints_json(mat, small_job, small_build):
    status, shown, _ = mat("build", small_job, "--json", "--jobs", 1)
    assert status == 0 and all(entry["kept"] for entry in json.loads(shown)["files"].values())


@pytest.mark.parametrize("file", ["s01.htt.h5", "b01.band.h5", "s01b01.atmq.h5"])
def test_every_table_has_a_picture(mat, small_build, tmp_path, file):
    status, _, message = mat("info", small_build / file, "--out", tmp_path / "p.png")
    assert status == 0, message
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")


def test_spectrum_is_drawn(mat, tmp_path):
    arguments = ("spectrum", "--range", 2, "--wavenumber", "1000:1100", "--source", "none", "--out")
    assert mat(*arguments, tmp_path / "s.png")[0] == 0 and (tmp_path / "s.png").is_file()
    assert mat(*arguments, tmp_path / "s.jpg")[0] == 2
    assert mat(*arguments, tmp_path / "nowhere" / "s.png")[0] == 2


def test_a_material_has_a_card(mat, tmp_path):
    """Of glass, which lets light through; a folder that is not there is one line."""
    from PIL import Image

    status, shown, message = mat("materials", "glass_window", "--out", tmp_path / "card.png")
    assert status == 0 and "glass_window" in shown, message
    with Image.open(tmp_path / "card.png") as card:
        assert card.width > 1000 and len(np.unique(np.asarray(card.convert("L")))) > 20
    status, _, message = mat("materials", "glass_window", "--out", tmp_path / "nowhere" / "card.png")
    assert status == 2 and "cannot be written" in message and message.count("\n") == 1


def test_a_state_of_a_job_is_seen_spectrally(mat, tmp_path):
    folder = tmp_path / "demo"
    assert mat("init", folder)[0] == 0
    sight = ("spectrum", "--wavelength", "10:10.1", "--range", 1, "--source", "none")
    status, shown, message = mat(*sight, "--job", folder / "job.yaml")
    assert status == 0 and shown.startswith("wavenumber[cm^-1],transmittance[1]"), message
    status, plain, _ = mat(*sight, "--aerosol-optical-depth", 0.1, "--angstrom-exponent", 1.3)
    assert status == 0 and plain.splitlines()[1] != shown.splitlines()[1]
    for more, complaint in (
        (("--job", folder / "job.yaml", "--aerosol", "rural"), "found job and aerosol; allowed:"),
        (("--job", folder / "job.yaml", "--state", 99), "job.yaml: found state 99; allowed: 1 to"),
        (("--aerosol-optical-depth", -1), "aerosol_optical_depth: found -1"),
        (("--visibility-km", 5, "--aerosol-optical-depth", 1), "allowed: one of them"),
    ):
        status, _, message = mat(*sight, *more)
        assert status == 2 and complaint in message and message.count("\n") == 1
