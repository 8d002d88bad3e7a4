"""Band means of transmittance: what they cost in emitted light, and where a job corrects them by itself."""

import numpy as np
import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.plan.plan import make_plan
from skyshine.mat.scene import averages
from skyshine.mat.scene.averages import averaging_error, weighted_transmittance_bands
from skyshine.materials.library import load_library

BAND = "  - wavelength_um: [10.0, 10.2]\n"
BANDS = "".join(f"  - wavelength_um: {limits}\n" for limits in ("[3, 5]", "[8, 12]", "[0.9, 1.7]"))


def job(folder, tiny_job, extra=""):
    assert BAND in tiny_job()
    (folder / "job.yaml").write_text(tiny_job().replace(BAND, BANDS) + f"{extra}\n", encoding="utf-8")
    return load_job(folder / "job.yaml")


def test_the_error_is_that_of_the_integrals_of_a_path(tmp_path, tiny_job, monkeypatch):
    """One path of 1 km, a body of 300 K: (5) against (6) with the flat mean, by the public spectrum."""
    import skyshine.mat

    monkeypatch.setattr(averages, "_RANGES", np.array([1.0]))
    loaded = job(tmp_path, tiny_job)
    spectrum = skyshine.mat.spectrum(
        wavelength=(3, 5), range=1, elevation=0, altitude=0.0, atmosphere=loaded.trimmed.states[0].profile
    )
    wavelength, tau = 1e4 / np.asarray(spectrum.wavenumber), np.asarray(spectrum.transmittance)
    second = 14387.768775
    planck = lambda kelvin: wavelength**-5 / np.expm1(second / (wavelength * kelvin))  # noqa: E731
    step = wavelength**2  # of equal steps of wavenumber, in wavelength
    flat = np.sum(step * tau) / np.sum(step)
    emitted = np.sum(step * planck(300.0) * tau) / np.sum(step * planck(300.0))
    slope = np.sum(step * (planck(300.5) - planck(299.5)))
    expected = abs(emitted - flat) * np.sum(step * planck(300.0)) / slope
    assert averaging_error(loaded.trimmed, 1) == pytest.approx(expected, rel=0.1)


def test_by_default_the_bands_where_the_mean_errs_are_corrected(tmp_path, tiny_job):
    """3-5 um errs by .8 to 1 K, 8-12 um by less than .1 K; light below 2.5 um is not emitted."""
    loaded = job(tmp_path, tiny_job)
    assert 0.6 < averaging_error(loaded.trimmed, 1) < 1.2 and averaging_error(loaded.trimmed, 2) < 0.15
    assert averaging_error(loaded.trimmed, 3) == 0.0
    assert weighted_transmittance_bands(loaded.trimmed) == {1}
    files = [name for task in make_plan(loaded, load_library()).tasks for name in task.files]
    assert [name for name in files if "thermal" in name] == ["s01b01.thermal_atmq.h5"]


@pytest.mark.parametrize(("extra", "bands"), [("[]", set()), ("[weighted_transmittance]", {1, 2, 3})])
def test_a_job_that_says_which_tables_it_wants_gets_them(tmp_path, tiny_job, extra, bands):
    assert weighted_transmittance_bands(job(tmp_path, tiny_job, f"extra_tables: {extra}").trimmed) == bands


def test_tables_in_channels_hold_it_themselves(tmp_path, tiny_job):
    loaded = job(tmp_path, tiny_job, "accuracy: 1 K")
    assert loaded.trimmed.atmosphere_grid.in_channels and averaging_error(loaded.trimmed, 1) > 0.6
    assert weighted_transmittance_bands(loaded.trimmed) == set()
