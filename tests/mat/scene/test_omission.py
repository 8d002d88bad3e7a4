"""What is left out of a band's tables: within the job's bound, nothing at 0, nothing that has no bound, and it says
so.
"""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.job.atmosphere import AtmosphereGrid
from skyshine.mat.job.model import Accuracy, Job
from skyshine.mat.radiometry.blackbody import SpectralResponse, band_radiance
from skyshine.mat.scene.omission import Omission

LONG, SHORT = SpectralResponse.rectangular(8.0, 12.0), SpectralResponse.rectangular(0.5, 0.7)
STATE = AtmosphericState.from_profile("us_standard", clouds=[CloudLayer("ice", 9e3, 10e3, 30.0, 0.1)])


def decided(tolerance, response=LONG, state=STATE, grid=None, scattered=(1.0, 2e-3)):
    job = Job.model_construct(accuracy=Accuracy(negligible_k=tolerance), atmosphere_grid=grid or AtmosphereGrid())
    return Omission.of(job, ["sun", "moon"], state, response, np.array(scattered))


def test_a_kelvin_is_that_of_the_ground():
    found = decided(0.01)
    low, high = band_radiance(LONG, np.array([287.65, 288.65]))  # US Standard 1976: 288.15 K at the ground
    assert found.radiance == pytest.approx(high - low, rel=1e-3)
    hot = decided(0.01, state=replace(STATE, surface_temperature=330.0))
    assert hot.radiance == pytest.approx(float(np.diff(band_radiance(LONG, np.array([299.5, 300.5])))[0]), rel=1e-3)


def test_what_is_left_out_stays_within_the_tolerance():
    for tolerance in np.geomspace(1e-5, 1.0, 20):
        found = decided(tolerance)
        assert all(found.bound(source) <= tolerance for source in ("sun", "moon"))
    assert decided(0.02).scattered.keys() == {"moon"} and not decided(1e-3).scattered
    assert dict(decided(1.0, scattered=(1e-3, 1e-3)).scattered.items()).keys() == {
        "sun",
        "moon",
    }


def test_zero_leaves_nothing_out():
    found = decided(0.0, scattered=(0.0, 0.0))
    assert not found.scattered and found.text("moon") == ""


def test_nothing_unbounded_is_left_out():
    assert not decided(1.0, scattered=(np.inf, np.nan)).scattered
    visible = decided(1.0, response=SHORT)  # where kelvin mean nothing
    assert not visible.scattered and visible.radiance == 0.0


def test_the_file_says_what_is_left_out():
    found = decided(0.02)
    assert found.text("moon").startswith("scattered light of the moon (") and found.text("sun") == ""
