"""`mat spectrum --compare-continua`: what the water vapour continuum is worth, in kelvin."""

import json

import pytest
import yaml

import skyshine.mat
from skyshine.mat.api.continua import compare_continua
from skyshine.mat.cli import main
from skyshine.mat.job.load import load_job


@pytest.fixture
def mat(capsys):
    """Run ``mat`` with arguments that succeed: its standard output."""

    def run(*arguments):
        with pytest.raises(SystemExit) as stop:
            main.main([str(argument) for argument in arguments])
        assert stop.value.code == 0
        return capsys.readouterr().out

    return run


def test_the_older_self_continuum_absorbs_more_in_the_window(mat):
    place = ("--profile", "tropical", "--aerosol", "none", "--altitude", 10, "--elevation", -60)
    sight = ("spectrum", *place, "--wavelength", "10:10.5", "--source", "none")
    about = json.loads(mat(*sight, "--compare-continua", "--json"))
    assert list(about) == ["mt_ckd_4.3_closure", "mt_ckd_4.3", "mt_ckd_2.4", "lowtran7"]
    assert about["mt_ckd_4.3_closure"]["difference"]["value"] == 0
    own, older = about["mt_ckd_4.3"], about["mt_ckd_2.4"]
    assert older["transmittance"]["value"] < own["transmittance"]["value"] - 0.01
    # Seen from 10 km the air is colder than the ground: what absorbs more lowers the temperature, by less than a few K.
    assert -3 < older["difference"]["value"] - own["difference"]["value"] < -0.02
    lines = mat(*sight, "--compare-continua").splitlines()
    assert lines[0] == "water_continuum,transmittance[1],apparent_temperature[K],difference[K]"
    assert [line.split(",")[0] for line in lines[1:]] == list(about)


def test_a_clear_line_of_sight_has_the_temperature_of_its_background():
    effects = compare_continua(
        background=320.0, range=0.0, wavelength=(10.0, 10.5), source="none", profile="subarctic_winter"
    )
    assert [effect.temperature for effect in effects] == pytest.approx([320.0] * 4, abs=0.02)


def test_the_transmittance_is_that_of_the_spectrum():
    sight = {"wavelength": (4.0, 4.1), "range": 2.0, "source": "none"}
    effects = {effect.name: effect for effect in compare_continua(**sight)}
    older = skyshine.mat.spectrum(**sight, water_continuum="mt_ckd_2.4")
    assert effects["mt_ckd_2.4"].transmittance == pytest.approx(older.transmittance.mean())


def test_a_job_of_several_bands_asks_for_limits(mat, tmp_path, capsys):
    mat("init", tmp_path / "demo")
    job = tmp_path / "demo" / "job.yaml"
    sight = ("spectrum", "--job", job, "--range", 1, "--source", "none", "--compare-continua")
    assert len(mat(*sight, "--wavelength", "10:10.2").splitlines()) == 5
    with pytest.raises(SystemExit) as stop:
        main.main([str(argument) for argument in sight])
    assert stop.value.code == 2
    assert "bands; allowed: one band, or limits beside the job" in capsys.readouterr().err


def test_a_job_of_one_band_gives_the_limits(mat, tmp_path):
    mat("init", tmp_path / "demo")
    job = tmp_path / "demo" / "job.yaml"
    text = job.read_text(encoding="utf-8")
    loaded = load_job(job).trimmed
    assert len(loaded.bands) > 1
    one = {**yaml.safe_load(text), "bands": [{"wavelength_um": [10.0, 10.2]}]}
    job.write_text(yaml.safe_dump(one), encoding="utf-8")
    effects = compare_continua(job=job, range=1.0, source="none")
    limited = compare_continua(job=job, range=1.0, source="none", wavelength=(10.0, 10.2))
    assert [effect.temperature for effect in effects] == pytest.approx([effect.temperature for effect in limited])
