"""Peers at an error that both reach: the setting that is taken, and methods that agree where they must."""

import numpy as np
import pytest

from skyshine.mat.bench import lowtran, peers
from skyshine.mat.bench.peers import Measured, matched
from skyshine.mat.budget.built_tables import Tables
from skyshine.mat.job.load import load_job
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.materials.library import load_library

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
    monkeypatch.setattr(peers, "_FINEST", (144, 4, 12, 0.5))
    monkeypatch.setattr(peers, "_MARCHES", ((48, 4, 6, 0.5),))
    monkeypatch.setattr(peers, "_STEPS", (48,))
    found = peers.surfaces(job, load_library(), ["aluminium_weathered"])
    assert 0 < found.error < 0.5 and found.units == "K" and "48 steps beside 48 steps and 4 days" in found.note


def test_our_streams_give_the_light_of_pythonicdisort(job, monkeypatch):
    pytest.importorskip("PythonicDISORT")
    monkeypatch.setattr(peers, "_SCATTERING_POINTS", 8)
    found = peers.scattering(job, atmospheric_state(job.site, job.states[0]), SpectralResponse.rectangular(0.60, 0.62))
    assert found.error < 2e-3 and found.theirs > found.ours


def test_few_points_give_the_transmittance_of_a_peer_that_errs(job, monkeypatch):
    """In place of LOWTRAN7, whose program is not here, a spectrum that is 0.3 everywhere."""
    sights = [lowtran.Sight(2000.0 + 100 * k, 5.0, 1000.0 + 2000 * k) for k in range(8)]

    def run(_program, _state, of_peer, low, high):
        assert not any(sight.sun for sight in of_peer) and (low, high) == (975.0, 980.0)
        wavenumber = np.arange(low, high + 1, 5.0)
        shape = len(of_peer), wavenumber.size
        return lowtran.PeerSpectra(
            wavenumber, np.full(shape, 0.3), np.zeros(shape), {}, np.full((1, len(of_peer)), 2.0)
        )

    monkeypatch.setattr(lowtran, "run", run)
    found = peers.spectra(None, job, atmospheric_state(job.site, job.states[0]), sights, NARROW)
    assert found.theirs == 2.0 and 0 < found.ours < 2.0
    assert 0.2 < found.error < 0.7 and "points beside steps of 5 cm^-1" in found.note
