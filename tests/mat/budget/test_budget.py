"""The error budget: it closes where nothing is wrong, and shows what is planted."""

import json
import re
import shutil
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from skyshine.mat.budget.budget import error_budget
from skyshine.mat.budget.built_tables import Tables
from skyshine.mat.budget.circumstances import Circumstances
from skyshine.mat.budget.measurement import Measurement
from skyshine.mat.budget.pixel import PixelTruth, Scenes
from skyshine.mat.budget.runtime_terms import (
    AtmosphereReadings,
    Emission,
    Finish,
    reflection,
    runtime_radiance,
    spectral_radiance,
)
from skyshine.mat.budget.sizes import measures
from skyshine.mat.budget.summary import BITS, PixelScale
from skyshine.mat.budget.truth import FINE_STEPS, FacetTruth, Prepared
from skyshine.mat.cli import main
from skyshine.mat.job.load import load_job
from skyshine.mat.quantities.results import SpectralLines
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError

SCENES = 4


@pytest.fixture(scope="module")
def prepared(small_job):
    return Prepared.of(load_job(small_job), 1, 1)


@pytest.fixture(scope="module")
def budget_of(prepared):
    library = load_library()
    return lambda folder: error_budget(prepared, folder, library, source="sun", scenes=SCENES, seed=3)


@pytest.fixture(scope="module")
def honest(budget_of, small_build):
    """Without the rows of other air, which the page of a report has."""
    with pytest.MonkeyPatch.context() as patch:
        for rows_of_air in ("of_weather", "of_continua"):
            patch.setattr(Measurement, rows_of_air, lambda _: {})
        return budget_of(small_build)


def rms(error):
    return float(np.sqrt(np.mean(np.square(error))))


def test_grey_surface_through_grey_air(honest, prepared):
    """Where neither reflectance nor transmittance varies over the band, the runtime's equations are the integrals."""
    band, views = prepared.exact.band, honest.views.take(slice(3))
    shape = 3, band.weight.size
    generator = np.random.default_rng(4)
    through = np.broadcast_to(np.array([[1e-3], [0.4], [0.98]]), shape)
    lines = SpectralLines(
        through, generator.random(shape), generator.random(shape), np.array([1.0, 2.0, 3.0]), np.ones(3, bool)
    )
    finish = Finish(np.array([0.02, 0.9]), np.array([0.0, 0.7]), np.array([1.0, 40.0]), np.array([1.1, 12.0]))
    kelvin = np.array([[250.0, 300.0], [280.0, 330.0], [310.0, 290.0]])
    bounce = reflection(views, views.normal, finish)
    glow = planck_wavenumber(band.wavenumber, kelvin[..., None]) @ band.radiance_weight
    emission = Emission(glow, finish.reflectance)
    shown = runtime_radiance(AtmosphereReadings.integrated(lines, band), emission, bounce, finish)
    grey = np.repeat(finish.reflectance[:, None], shape[1], axis=1)
    np.testing.assert_allclose(shown, spectral_radiance(lines, band, kelvin, grey, bounce), rtol=1e-12)


def test_other_air_changes_the_pixel_by_its_light(prepared, honest, small_build):
    """On the few points of the tables, which cost little."""
    tables, views = Tables.open(small_build, 1, 1, "sun", prepared.loaded.trimmed), honest.views.take(slice(2))
    air, alone = prepared.reduced, Circumstances.none(2)
    coarser = replace(air, air=replace(air.air, nodes=2, azimuthal=4, spherical=False))
    truth = FacetTruth(replace(prepared, exact=air), load_library(), tables.materials, "sun")
    pixel = PixelTruth.of(Scenes(truth, views, alone), tables)
    kelvin = truth.temperature(views.normal, views.surface_altitude, views.time)
    assert pixel.radiance_in(tables, kelvin, air) == pytest.approx(pixel.radiance + pixel.averages, rel=1e-4)
    change = pixel.radiance_in(tables, kelvin, coarser) - pixel.radiance_in(tables, kelvin, air)
    assert np.any(change != 0) and np.abs(change).max() < 0.1 * pixel.radiance.max()
    # As many steps as the truth has change nothing.
    assert pixel.error(tables, steps=FINE_STEPS) == pytest.approx(pixel.error(tables), rel=1e-6, abs=1e-9)
    assert np.any(np.abs(pixel.error(tables, steps=24) - pixel.error(tables)) > 1e-6)


def test_extrapolation_grows_with_the_field_of_view(honest):
    values = honest.extrapolation["transmittance_extrapolation"]
    assert rms(values[0]) < 0.3 * rms(values[-1])


def test_weights_count_as_repeats():
    assert measures(np.array([1.0, -3.0]), np.array([3.0, 1.0])) == measures(np.array([1.0, 1.0, 1.0, -3.0]))


@pytest.mark.parametrize("bits", BITS)
def test_pixel_scale(bits):
    """(44): the darkest is 0, the brightest the last value; what comes back is within a step."""
    scale = PixelScale.of(2.0, 10.0, bits)
    assert list(scale.pixel([2.0, 10.0])) == [0, 2**bits - 1]
    radiance = np.linspace(2.0, 10.0, 1001)
    back = scale.radiance(scale.pixel(radiance))
    assert np.abs(back - radiance).max() <= 0.5 * scale.step * (1 + 1e-9)
    assert np.all(np.diff(scale.pixel(radiance)) >= 0)
    assert scale.step == pytest.approx(8.0 / 2**bits)


def test_pixel_values_are_rounded_to_the_nearest_integer():
    """Four steps of 1 W m^-2 sr^-1 from 0: x = 1.6 gives the nearest to 1.1, and 0.9 the nearest to 0.4."""
    scale = PixelScale(2, 4.0, 1.0, 0.0)
    assert list(scale.pixel([0.0, 0.9, 1.1, 1.6, 2.4, 3.9, 4.0])) == [0, 0, 1, 1, 2, 3, 3]
    with pytest.raises(ValueError, match="not a number"):
        scale.pixel([1.0, np.nan])


def test_pixel_scale_of_one_radiance():
    scale = PixelScale.of(3.0, 3.0, 8)
    assert scale.radiance(scale.pixel(3.0)) == pytest.approx(3.0, rel=0.01)


@pytest.mark.validation  # 20 s; test_report_page.py of the validation suite opens the page in a browser
def test_page_stands_alone(small_job, small_build, tmp_path):
    """HTML and JSON; nothing is fetched from anywhere."""
    page = tmp_path / "report.html"
    result = CliRunner().invoke(
        main,
        ["report", str(small_job), "--out", str(page), "--scenes", "1"],
        catch_exceptions=False,
        standalone_mode=False,
    )
    assert result.exit_code == 0
    text = page.read_text(encoding="utf-8")
    assert not re.findall(r"""(?:src|href)\s*=\s*["'](?!data:|#)""", text) and "<svg" in text and "@import" not in text
    report = json.loads(page.with_suffix(".json").read_text(encoding="utf-8"))
    errors = report["budgets"][0]["errors"]
    assert errors["all"]["temperature"]["rms"]["value"] > 0 and "misclassification" not in errors
    for name, error in errors.items():
        assert f"<td>{error['temperature']['rms']['value']:.3g}</td>" in text, name
    assert [scale["bits"] for scale in report["budgets"][0]["pixel_scales"]] == list(BITS)


def test_another_band_than_the_job_has(small_job, capsys):
    with pytest.raises(SystemExit) as stop:
        main(["report", str(small_job), "--band", "b02"])
    assert stop.value.code == 2 and "allowed: b01, the bands that the job builds" in capsys.readouterr().err


def test_a_database_is_no_job(small_build, capsys):
    with pytest.raises(SystemExit) as end:
        main(["report", str(next(small_build.glob("*.h5")))])
    assert end.value.code == 2
    assert "is a database; name the job" in capsys.readouterr().err


def test_not_built_yet(prepared, budget_of, tmp_path):
    with pytest.raises(Exception, match="build the job first"):
        budget_of(tmp_path)


def test_a_file_of_another_type_than_its_name_says(small_job, small_build, tmp_path):
    for name in ("s01.htt.h5", "s01b01.atmq.h5"):
        shutil.copy(small_build / name, tmp_path / name)
    shutil.copy(small_build / "s01.htt.h5", tmp_path / "b01.band.h5")
    with pytest.raises(
        InputError, match=r"b01\.band\.h5: is of the file type .htt.; allowed: band; build the job again: mat build"
    ):
        Tables.open(tmp_path, 1, 1, "sun", load_job(small_job).trimmed)
