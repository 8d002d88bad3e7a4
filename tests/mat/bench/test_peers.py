"""Peers at an error that both reach: the setting that is taken, and methods that agree where they must."""

import numpy as np
import OpenImageIO as oiio
import pytest

from skyshine.mat.bench import energyplus, lowtran, peer_light, peer_surfaces, peers
from skyshine.mat.bench.equal_error import Measured, matched
from skyshine.mat.bench.peer_texels import texels
from skyshine.mat.budget.built_tables import Tables
from skyshine.mat.job.load import load_job
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.materials.library import load_library
from skyshine.tmm import map_texture, write_texture
from skyshine.tmm.job.model import TextureJob

NARROW = SpectralResponse.rectangular(10.2, 10.25)


@pytest.fixture(scope="module")
def job(small_job):
    return load_job(small_job).trimmed


def test_each_takes_its_quickest_setting_at_the_error_that_both_reach():
    ours = [Measured("quick", 1.0, 0.5), Measured("good", 2.0, 0.1), Measured("better", 5.0, 0.01)]
    theirs = [Measured("rough", 3.0, 0.4), Measured("slow", 50.0, 0.2), Measured("quicker", 30.0, 0.2)]
    error, setting, peer_setting = matched(ours, theirs)
    assert (error, setting.name, peer_setting.name) == (0.2, "good", "quicker")


def test_reads_of_scipy_and_xarray_are_ours(job, small_build):
    found = peers.reading(Tables.open(small_build, 1, 1, "sun", job).surface)
    assert [comparison.peer for comparison in found] == ["scipy", "xarray"]
    assert all(comparison.error < 1e-9 and comparison.ours > 0 for comparison in found)


def test_marching_in_time_comes_to_our_temperatures(job, monkeypatch):
    monkeypatch.setattr(peer_surfaces, "_FINEST", (144, 4, 12, 0.5))
    monkeypatch.setattr(peer_surfaces, "_MARCHES", ((48, 4, 6, 0.5),))
    monkeypatch.setattr(peer_surfaces, "_STEPS", (48,))
    monkeypatch.setattr(energyplus, "program", lambda: None)
    (found,) = peer_surfaces.surfaces(job, load_library(), ["aluminium_weathered"])
    assert 0 < found.error < 0.5 and found.units == "K" and "48 steps beside 48 steps and 4 days" in found.note


def test_our_streams_give_the_light_of_pythonicdisort(job, monkeypatch):
    pytest.importorskip("PythonicDISORT")
    monkeypatch.setattr(peer_light, "_SCATTERING_POINTS", 8)
    found = peer_light.scattering(
        job, atmospheric_state(job.site, job.states[0]), SpectralResponse.rectangular(0.60, 0.62)
    )
    assert found.error < 2e-3 and found.theirs > found.ours


def test_few_points_give_the_transmittance_of_a_peer_that_errs(job, monkeypatch):
    """In place of LOWTRAN7, whose program is not here, a spectrum that is 0.3 everywhere."""

    def run(_program, state, sights, low, high):
        assert not any(sight.sun for sight in sights) and (low, high) == (975.0, 980.0)
        assert all(state.altitude[0] <= sight.altitude for sight in sights)
        wavenumber = np.arange(low, high + 1, 5.0)
        shape = len(sights), wavenumber.size
        return lowtran.PeerSpectra(wavenumber, np.full(shape, 0.3), np.zeros(shape), {}, np.full((1, len(sights)), 2.0))

    monkeypatch.setattr(lowtran, "run", run)
    found = peer_light.spectra(None, job, atmospheric_state(job.site, job.states[0]), NARROW)
    assert found.theirs == 2.0 and 0 < found.ours < 2.0
    assert 0.2 < found.error < 0.7 and "points beside steps of 5 cm^-1" in found.note


def test_energyplus_takes_another_error_than_ours_at_each_number_of_steps(job, monkeypatch):
    """In place of EnergyPlus, which is not here, temperatures that err by what they are asked to."""

    def hourly(steps, _days, _tolerance):
        return np.full((3, 24), 10.0 + (0.0 if steps == 60 else 1.2 / steps)), 1e-3 * steps

    monkeypatch.setattr(energyplus, "hourly", hourly)
    monkeypatch.setattr(energyplus, "program", lambda: "there")
    monkeypatch.setattr(peer_surfaces, "_FINEST", (144, 4, 12, 0.5))
    monkeypatch.setattr(peer_surfaces, "_STEPS", (24,))
    (found,) = peer_surfaces.surfaces(job, load_library(), [])
    # Ours errs by more than 1.2 / 30 K: the quickest of EnergyPlus that errs no more is taken.
    assert found.error > 0.04 and 1.2 / (1e3 * found.theirs) <= found.error and 0 < found.ours < found.theirs


def test_texels_of_scikit_learn_are_judged_by_the_seeds_that_it_has_not_seen(tmp_path):
    pytest.importorskip("sklearn")
    values = np.random.default_rng(1).normal(0, 6, (40, 80, 3))
    values += np.where(np.arange(80)[None, :, None] < 40, (60, 140, 50), (120, 120, 125))
    output = oiio.ImageOutput.create(str(tmp_path / "halves.png"))
    assert output.open(str(tmp_path / "halves.png"), oiio.ImageSpec(80, 40, 3, "uint8"))
    assert output.write_image(np.clip(values, 0, 255).astype(np.uint8)) and output.close()
    left, right = (
        [[[x, y], [x + 12, y], [x + 12, y + 8], [x, y + 8]] for x, y in ((start, 3), (start + 16, 25))]
        for start in (4, 46)
    )
    # One place of asphalt is on the grass: every classifier that has not seen it errs there.
    seeds = {"polygons": {"grass_green": left[:1], "asphalt_road": [*right, left[1]]}}
    texture = TextureJob.model_validate({"image": "halves.png", "seeds": seeds})
    library, database = load_library(), tmp_path / "halves.tmm.h5"
    write_texture(map_texture(texture, tmp_path, library), database)
    (found,) = texels(texture, tmp_path, library, database, 2.0)
    assert found.error == pytest.approx(1 / 3, abs=0.02)
    assert found.ours == pytest.approx(2.0 / 3200) and 0 < found.theirs < 1e-3
