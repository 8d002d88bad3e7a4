"""A pixel read by wavelength, against the whole truth."""

import shutil

import h5py
import numpy as np
import pytest

from skyshine.mat.budget.budget import PIXEL_SOURCES, error_budget
from skyshine.mat.budget.built_tables import Tables
from skyshine.mat.budget.pixel import Scenes, pixel_radiance
from skyshine.mat.budget.truth import Prepared
from skyshine.mat.job.load import load_job
from skyshine.mat.scene.grids import path_grid
from skyshine.materials.library import load_library


@pytest.fixture(scope="module")
def job(build_inline, tiny_job, tmp_path_factory):
    """The edge of the CO2 band, where reflectance meets light in a part of the band alone."""
    text = tiny_job()
    for before, after in (
        ("[10.0, 10.2]", "[4.17, 4.22]"),
        ("[asphalt_road]", "[grass_dry, paint_olive_on_aluminium]"),
        ("tolerance: 5 K", "tolerance: 2 K"),
        ("slope_deg: [0, 45], time: [00:00, 12:00]", "slope_deg: [0, 90], time: [00:00, 06:00, 12:00, 18:00]"),
    ):
        assert before in text, before
        text = text.replace(before, after)
    file = tmp_path_factory.mktemp("wavelengths") / "job.yaml"
    file.write_text(text, encoding="utf-8")
    build_inline(load_job(file), jobs=1)
    return file


@pytest.fixture(scope="module")
def prepared(job):
    return Prepared.of(load_job(job), 1, 1)


def rms(error):
    return float(np.sqrt(np.mean(np.square(error))))


@pytest.mark.validation  # 6 s: a build and lines of sight by wavelength
def test_a_pixel_by_wavelength_errs_by_a_hundredth_of_its_radiance(job, prepared):
    tables = Tables.open(job.parent / "built", 1, 1, "sun", prepared.loaded.trimmed)
    scenes = Scenes.drawn(
        prepared,
        load_library(),
        tables.materials,
        path_grid(prepared.loaded.trimmed),
        tables.surface_axes,
        shades=tables.shades,
        source="sun",
        scenes=6,
        seed=3,
    )
    truth = scenes.truth.of(scenes.views, scenes.circumstances, tables.finish)
    # At the true temperatures, which coarse axes would hide.
    read = pixel_radiance(tables, scenes.truth, scenes.views, scenes.circumstances, truth.kelvin)
    assert rms(read - truth.radiance) < 0.01 * rms(truth.radiance)


@pytest.mark.validation  # 6 s: two budgets
def test_wavelengths_at_the_wrong_place_show_under_their_own_name(job, prepared, tmp_path):
    def budget(folder):
        return error_budget(prepared, folder, load_library(), source="sun", scenes=3, seed=11)

    honest = budget(job.parent / "built")
    copy = shutil.copytree(job.parent / "built", tmp_path / "built")
    with h5py.File(copy / "s01b01.atmq.h5", "r+") as opened:
        shares = opened["source_wavelength_share"]
        shares[...] = np.roll(shares[...], 5, axis=1)
    wrong = budget(copy)
    changed = {name for name in honest.errors if not np.array_equal(wrong.errors[name], honest.errors[name])}
    assert changed & set(PIXEL_SOURCES) == {"reflected_wavelengths"} and "pixel" in changed
    first, of_honest = (budget.errors["reflected_wavelengths"][:, 0] for budget in (wrong, honest))
    assert rms(first) > 2 * rms(of_honest)
