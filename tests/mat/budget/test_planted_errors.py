"""A table that is made wrong shows under its own name in the error budget, and under no other."""

import functools
import shutil

import h5py
import numpy as np
import pytest

from skyshine.mat.budget import unmodelled
from skyshine.mat.budget.budget import PIXEL_SOURCES, error_budget
from skyshine.mat.budget.measurement import Measurement
from skyshine.mat.budget.pixel import Scenes
from skyshine.mat.budget.sizes import kelvin
from skyshine.mat.budget.summary import describe
from skyshine.mat.budget.truth import FacetTruth, Prepared
from skyshine.mat.job.load import load_job
from skyshine.materials.library import load_library

# Rows in which several sources meet.
OF_GROUND = {"aureole", "seen_faces", "tilted_sky", "reflected_wavelengths"}  # read through the table too
TOGETHER = {"tables", "pixel", "all", "transmittance_extrapolation", "radiance_extrapolation", "face"}


@pytest.fixture(scope="module")
def job(build_inline, tiny_job, tmp_path_factory):
    """Two materials on walls and level."""
    text = tiny_job()
    for before, after in (
        ("[asphalt_road]", "[asphalt_road, concrete]"),
        ("[0.01, 1]", "[0.001, 1]"),
        ("slope_deg: [0, 45], time: [00:00, 12:00]", "slope_deg: [0, 90], time: [00:00, 06:00, 12:00, 18:00]"),
    ):
        assert before in text
        text = text.replace(before, after)
    file = tmp_path_factory.mktemp("street") / "job.yaml"
    file.write_text(text, encoding="utf-8")
    build_inline(load_job(file), jobs=1)
    return file


@pytest.fixture(scope="module")
def budget_of(job):
    """Budget of a folder: all have the same views, the truth of which is computed once, and no rows of other air."""
    prepared, library, known = Prepared.of(load_job(job), 1, 1), load_library(), {}
    of_no_table = (
        (Scenes, "drawn"),
        (FacetTruth, "lines"),
        (FacetTruth, "temperatures_among"),
        (unmodelled, "sunlit_sky"),
    )
    computed = [functools.partial(once, known, name, getattr(owner, name)) for owner, name in of_no_table]

    def budget(folder):
        with pytest.MonkeyPatch.context() as patch:
            for (owner, name), compute in zip(of_no_table, computed, strict=True):
                patch.setattr(owner, name, lambda *given, compute=compute, **named: compute(*given, **named))
            for rows_of_air in ("of_weather", "of_continua"):
                patch.setattr(Measurement, rows_of_air, lambda _: {})
            return error_budget(prepared, folder, library, source="sun", scenes=12, seed=23)

    return budget


def once(known, name, compute, *given, **named):
    if name not in known:
        known[name] = compute(*given, **named)
    return known[name]


@pytest.fixture(scope="module")
def honest(budget_of, job):
    return budget_of(job.parent / "built")


@pytest.fixture
def planted(budget_of, job, tmp_path):
    """The budget of a copy of the databases, some arrays of which are changed: (file, array, change)."""

    def measured(*changes):
        copy = shutil.copytree(job.parent / "built", tmp_path / "built")
        for file, quantity, change in changes:
            with h5py.File(copy / file, "r+") as opened:
                opened[quantity][...] = change(opened[quantity][...])
        return budget_of(copy)

    return measured


def rms(error):
    return float(np.sqrt(np.mean(np.square(error))))


def changed(wrong, honest):
    """Sources whose errors differ."""
    assert set(wrong.errors) == set(honest.errors)
    return {name for name in honest.errors if not np.array_equal(wrong.errors[name], honest.errors[name])} - TOGETHER


def test_the_views_have_all_circumstances(honest):
    around, views = honest.circumstances, honest.views
    assert around.in_shade.any() and around.walled.any() and views.near.any() and not views.near.all()
    assert np.any(around.in_shade & (views.source_elevation > 0))


def test_a_response_of_nothing_shows_as_shade_and_surroundings(honest, planted):
    """Both are read from the kernel: without it a surface in the shade is some kelvin too warm."""
    wrong = planted(("s01.htt.h5", "response_kernel", np.zeros_like))
    assert changed(wrong, honest) == {"shade", "surroundings", "aureole", "seen_faces"}
    # Times six hours apart give the response a start that is some kelvin off.
    assert rms(wrong.errors["shade"]) > 4 * rms(honest.errors["shade"])
    warm = kelvin(wrong, wrong.errors["shade"])[wrong.circumstances.in_shade & (wrong.views.source_elevation > 20)]
    assert warm.max() > 2


def test_sunlight_too_weak_shows_as_shade(honest, planted):
    """Light that walls take depends on it too, where the diffuse part is bounded by that of an even sky."""
    wrong = planted(("s01.htt.h5", "direct_normal_irradiance", lambda light: 0.5 * light))
    assert changed(wrong, honest) <= {"shade", "surroundings", "aureole", "seen_faces"}
    moved = {name: rms(wrong.errors[name] - honest.errors[name]) for name in ("shade", "surroundings")}
    assert moved["shade"] > 2 * rms(honest.errors["shade"]) and moved["surroundings"] < 0.1 * moved["shade"]


def test_three_wrong_tables_show_under_their_names(honest, planted):
    """A sky too cold behind walls as surroundings, air too warm along paths as path radiance, beyond and within 100 m,
    and a reflectance by temperature as reflectance.
    """
    wrong = planted(
        ("s01.htt.h5", "sky_irradiance", lambda sky: 0.5 * sky),
        ("s01b01.atmq.h5", "thermal_ratio", lambda ratio: 1.3 * ratio),
        ("b01.band.h5", "reflectance_planck", lambda rho: rho + 0.05),
    )
    names = {"surroundings", "path_radiance_table", "near_range", "reflectance"}
    for name in names:
        assert rms(wrong.errors[name]) > 2 * rms(honest.errors[name]), name
    assert np.all(wrong.errors["near_range"][~wrong.views.near] == 0)
    assert np.all(wrong.errors["path_radiance_table"][wrong.views.near] == 0)
    for name in ("beta_star_table", "direct_table", "compiled_band", "normalisation"):
        assert rms(wrong.errors[name]) == pytest.approx(rms(honest.errors[name]), rel=1e-3), name


def test_air_too_opaque_and_harmonics_too_large_show_under_their_names(honest, planted):
    wrong = planted(
        ("s01b01.atmq.h5", "log_mean_extinction", lambda log: log + 0.3),
        ("s01b01.atmq.h5", "thermal_harmonics", lambda light: 1.2 * light),
    )
    for name in ("beta_star_table", "tilted_sky"):
        assert rms(wrong.errors[name] - honest.errors[name]) > rms(honest.errors[name]), name
    for name in ("temperature_table", "compiled_band", "reflectance", "solver_steps"):
        assert rms(wrong.errors[name]) == pytest.approx(rms(honest.errors[name]), rel=1e-6), name


def test_wavelengths_of_emission_show_as_emitted_transmittance(honest, planted):
    wrong = planted(("s01b01.atmq.h5", "thermal_wavelength_share", lambda share: np.roll(share, 4, axis=1)))
    moved = wrong.errors["emitted_transmittance"] - honest.errors["emitted_transmittance"]
    assert rms(moved) > 0.3 * rms(honest.errors["emitted_transmittance"])
    assert changed(wrong, honest) <= {"emitted_transmittance", "near_range", "reflected_wavelengths"}


@pytest.mark.validation  # 15 s: two jobs
def test_air_beside_the_weather_shows_as_weather_of_the_air(job, tmp_path):
    """Weather 16 K warmer than the profile that paths keep; the truth keeps it too, so it is no source of the pixel."""

    def row(*changes):
        text = job.read_text(encoding="utf-8")
        for before, after in changes:
            assert before in text
            text = text.replace(before, after)
        file = tmp_path / "job.yaml"
        file.write_text(text, encoding="utf-8")
        prepared = Prepared.of(load_job(file), 1, 1)
        budget = error_budget(prepared, job.parent / "built", load_library(), source="sun", scenes=4, seed=2)
        return budget.errors.get("weather_of_the_air"), budget.notes

    followed, notes = row()
    beside, _ = row(("[22, 33]", "[38, 49]"), ("    weather:", "    air: profile\n    weather:"))
    assert rms(beside) > 1.5 * rms(followed) > 0 and notes == []
    of_noon, notes = row(("    weather:", "    air_times: [12:00]\n    weather:"))
    assert of_noon is None and "its air is that of one time" in notes[0]
    assert "weather_of_the_air" not in PIXEL_SOURCES


def test_the_sources_sum_to_the_pixel(honest):
    """Errors are small, so what they are together is nearly their sum."""
    total = sum(honest.errors[name] for name in PIXEL_SOURCES if name in honest.errors)
    assert rms(total - honest.errors["pixel"]) < 0.2 * rms(honest.errors["pixel"])


def test_a_sentence_names_the_largest_source(honest, planted):
    """Temperatures 20 K too warm. The response departs from linear where a surface begins so warm."""
    wrong = planted(("s01.htt.h5", "temperature", lambda kelvins: kelvins + 20))
    moved = {name: rms(wrong.errors[name] - honest.errors[name]) for name in changed(wrong, honest)}
    assert set(moved) <= {"temperature_table", "shade", "surroundings", *OF_GROUND} and "temperature_table" in moved
    assert all(size < 0.3 * moved["temperature_table"] for name, size in moved.items() if name != "temperature_table")
    described = describe(wrong)
    assert "the largest source of the latter is temperature table (" in described["dominant"]
    assert described["regions"]["beside a wall"]["views"] == wrong.circumstances.walled.sum()
    assert described["errors"]["pixel"]["temperature"]["rms"]["value"] > 10


def moved(wrong, honest, name):
    return rms(wrong.errors[name] - honest.errors[name]) / rms(honest.errors[name])


def test_an_aureole_that_stays_in_the_shade_shows_as_aureole(honest, planted):
    """Without the share shaded faces keep all of the sky's light around the Sun: some kelvin times their shade."""
    wrong = planted(("s01.htt.h5", "aureole_share", np.zeros_like))
    assert changed(wrong, honest) <= {"aureole", "seen_faces", "shade", "surroundings"}
    assert planted_share(wrong, honest) > 0.5
    sunlit = ~honest.circumstances.shaded
    assert sunlit.any() and np.all(wrong.errors["shade"][sunlit] == honest.errors["shade"][sunlit])


def planted_share(wrong, honest):
    """By how much shaded faces by day are warmer, over what the response to shade errs there."""
    rows = honest.circumstances.in_shade & (honest.views.source_elevation > 10)
    return rms(wrong.errors["shade"][rows] - honest.errors["shade"][rows]) / rms(honest.errors["shade"][rows])


def test_ground_that_shade_does_not_cool_shows_as_seen_faces(honest, planted):
    """Without a response the ground in the shade is as warm as in the open: of the row its reflected light is left."""
    wrong = planted(("s01.htt.h5", "response_kernel", np.zeros_like))
    tilted = honest.views.normal[:, 2] < 0.9
    rows = tilted & honest.circumstances.in_shade & (honest.views.source_elevation > 10)
    assert rows.any() and np.all(honest.errors["seen_faces"][rows] > 0)
    assert np.all(np.abs(honest.errors["seen_faces"][honest.views.normal[:, 2] > 0.9999]) < 1e-6)
    assert rms(wrong.errors["seen_faces"][rows]) < 0.5 * rms(honest.errors["seen_faces"][rows])


def test_a_lobe_too_narrow_shows_as_lobe(honest, planted):
    wrong = planted(("b01.band.h5", "shininess", lambda exponent: 16 * exponent))
    assert moved(wrong, honest, "lobe") > 0.3


def test_a_coarse_depth_buffer_and_coarse_pixels_show_under_their_names(honest, budget_of, job, monkeypatch):
    from skyshine.mat.budget import unmodelled

    fine = unmodelled.depth_buffer_range
    monkeypatch.setattr(unmodelled, "depth_buffer_range", lambda *given: fine(*given, bits=12))
    monkeypatch.setattr(unmodelled, "PIXEL_RAD", 10 * unmodelled.PIXEL_RAD)
    wrong = budget_of(job.parent / "built")
    assert changed(wrong, honest) == {"depth_buffer", "aliasing"}
    assert rms(wrong.errors["depth_buffer"]) > 100 * rms(honest.errors["depth_buffer"])
    assert rms(wrong.errors["aliasing"]) > 1.5 * rms(honest.errors["aliasing"])


def test_vertices_of_the_other_material_show_as_vertices(honest, budget_of, job, monkeypatch):
    """Without textures there is no row. Vertices of each pixel's own material err by the height of a face alone; of the
    other, by the difference of their emission: what one material is too warm the other is too cold.
    """
    from skyshine.mat.budget import measurement

    names = ("vertices_centre", "vertices_nearest")
    assert not set(names) & set(honest.errors)
    other = np.eye(2)[::-1]
    monkeypatch.setattr(measurement, "vertex_materials", lambda *_: dict(zip(names, (other, np.eye(2)), strict=True)))
    wrong = budget_of(job.parent / "built")
    swapped, right = (kelvin(wrong, wrong.errors.pop(name)) for name in names)
    assert changed(wrong, honest) == set()
    assert np.abs(right).max() < 0.7 and rms(swapped) > 3 * rms(right)
    clear = np.abs(swapped).min(axis=1) > 3 * np.abs(right).max()
    assert clear.sum() > 3 and np.all(swapped[clear, 0] * swapped[clear, 1] < 0)
