"""Bands of several settings from one sample: those that each setting compiles alone."""

import time

import numpy as np
import pytest

from skyshine.mat.atmosphere.band import cache as band_cache
from skyshine.mat.bench import shared_compile
from skyshine.mat.bench.sample import cache_in, with_spectral_tolerance
from skyshine.mat.job.load import load_job
from skyshine.mat.scene.compiled import StateBand


def test_bands_from_one_sample_are_those_compiled_alone(tiny_job, tmp_path, monkeypatch):
    (tmp_path / "job.yaml").write_text(tiny_job(), encoding="utf-8")
    loaded, taken, take = load_job(tmp_path / "job.yaml"), [], band_cache.SampledBand.of
    monkeypatch.setattr(band_cache.SampledBand, "of", lambda *given: taken.append(given) or take(*given))
    # A clock by which samples alone take time: 100 s each.
    monkeypatch.setattr(time, "process_time", lambda: 100.0 * len(taken))
    settings = [(with_spectral_tolerance(loaded, tolerance), tmp_path / str(tolerance)) for tolerance in (1e-3, 0.05)]
    seconds = shared_compile._compiled(settings, (1, 1))
    assert len(taken) == 1 and seconds == [100.0, 100.0]  # each setting as if it were compiled alone
    bands = []
    for number, (of_setting, cache) in enumerate(settings):
        with monkeypatch.context() as patch, cache_in(cache):
            patch.setattr(band_cache, "_cached_fit", None)  # it is read, not compiled
            shared = StateBand.of(of_setting.on_date_of_state(1), 1, 1).compiled
        bands.append(shared)
        if number:
            band_cache._fits.clear()
            with cache_in(None):
                alone = StateBand.of(of_setting.on_date_of_state(1), 1, 1).compiled
            assert np.array_equal(alone.index, shared.index) and alone.errors == shared.errors
            assert alone.band.weight == pytest.approx(shared.band.weight)
    assert bands[1].index.size < bands[0].index.size
