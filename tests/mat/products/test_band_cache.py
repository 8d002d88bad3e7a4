"""Compiled bands kept by content: same bytes with and without, nothing taken from a broken or foreign file."""

import json
from collections import OrderedDict
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.band import cache as band_cache
from skyshine.mat.atmosphere.band.cache import CACHE_VARIABLE, Origin, cache_folder, cached_compile_band, content_key
from skyshine.mat.atmosphere.band.compile import fit_band, over_air
from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.sources.sun_and_moon import solar_irradiance
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.builder.build import build
from skyshine.mat.job.load import load_job
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import SpectralResponse

GRID = PathGrid([0.0, 1.0, 10.0], [0.01, 2.0], [-30.0, 0.0, 60.0], [10.0, 50.0], [0.0, 180.0])
TABLE = AbsorptionTable.open()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    return tmp_path / "bands"


@pytest.fixture(autouse=True)
def compiling(monkeypatch, request):
    """The compilation itself is run once for all tests of this module but the last: here it is a costly constant."""
    if "small_build" not in request.fixturenames:
        result = request.getfixturevalue("result")
        monkeypatch.setattr(band_cache, "fit_band", lambda *args, **settings: result)


@pytest.fixture(scope="module")
def result(state, band):
    sun = solar_irradiance(band.wavenumber, band.width)
    return fit_band(over_air(state), band, GRID, sun, tolerance=1e-3, max_points=12, seed=0)


@pytest.fixture(scope="module")
def state():
    return AtmosphericState.from_profile("us_standard")


@pytest.fixture(scope="module")
def band():
    response = SpectralResponse.rectangular(11.0, 11.06)
    return band_points(TABLE.points(*response.wavenumber_range), response)


def compiled(state, band, distance=1.0, **changed):
    settings = {"tolerance": 1e-3, "max_points": 12, "seed": 0, **changed}
    sun = solar_irradiance(band.wavenumber, band.width)
    return cached_compile_band(TABLE, state, band, GRID, sun / distance**2, sun, **settings)


def same(first, second):
    arrays = [(one.index, one.band.weight, one.band.points.wavenumber, one.ladder) for one in (first, second)]
    return all(a.tobytes() == b.tobytes() for a, b in zip(*arrays, strict=True)) and (
        (first.errors, first.dropped, first.band.gases, first.total_points)
        == (second.errors, second.dropped, second.band.gases, second.total_points)
    )


def test_the_second_time_gives_the_same_to_the_last_bit(folder, state, band):
    first, origin = compiled(state, band)
    assert origin is not Origin.CACHE and len(list(folder.iterdir())) == 1
    second, origin = compiled(state, band)
    assert origin is Origin.CACHE and same(first, second)


def test_states_of_one_air_share_the_points_and_have_errors_of_their_own(folder, state, band, monkeypatch, result):
    fits = []
    monkeypatch.setattr(band_cache, "_fits", OrderedDict())
    monkeypatch.setattr(band_cache, "fit_band", lambda *args, **settings: fits.append(args) or result)
    first, origin = compiled(state, band)
    assert origin is Origin.FITTED
    warmer = replace(state, surface_temperature=state.surface_temperature + 20)
    second, origin = compiled(warmer, band, distance=1.01)
    assert len(fits) == 1 and origin is Origin.SHARED
    assert np.array_equal(first.index, second.index) and np.array_equal(first.band.weight, second.band.weight)
    assert first.errors["path_thermal"] != second.errors["path_thermal"]
    assert first.errors["direct_irradiance"]["rms"] == pytest.approx(
        second.errors["direct_irradiance"]["rms"], rel=1e-12
    )
    other = replace(state, temperature=state.temperature + 1.0)
    assert compiled(other, band)[1] is Origin.FITTED and len(fits) == 2


def test_another_state_tolerance_or_seed_is_compiled_anew(folder, state, band):
    compiled(state, band)
    warmer = replace(state, temperature=state.temperature + 1e-9)
    assert not any(
        origin is Origin.CACHE
        for _, origin in (compiled(warmer, band), compiled(state, band, tolerance=2e-3), compiled(state, band, seed=1))
    )


@pytest.mark.parametrize(
    "damage", [lambda b: b[: len(b) // 2], lambda b: b"", lambda b: b[:200] + b"\xff" * 40 + b[240:]]
)
def test_a_broken_file_counts_as_absent_and_is_replaced(folder, state, band, damage):
    first, _ = compiled(state, band)
    (file,) = folder.iterdir()
    file.write_bytes(damage(file.read_bytes()))
    second, origin = compiled(state, band)
    assert origin is not Origin.CACHE and same(first, second) and compiled(state, band)[1] is Origin.CACHE


def test_several_writers_at_once_leave_one_whole_file(folder, state, band):
    with ThreadPoolExecutor(4) as threads:
        results = [one.result()[0] for one in [threads.submit(compiled, state, band) for _ in range(4)]]
    assert all(same(results[0], other) for other in results)
    assert len(list(folder.iterdir())) == 1 and compiled(state, band)[1] is Origin.CACHE


def test_a_folder_that_cannot_be_made_or_is_switched_off_costs_nothing_but_time(tmp_path, monkeypatch, state, band):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "file"))
    first, origin = compiled(state, band)
    monkeypatch.setenv(CACHE_VARIABLE, "")
    assert origin is not Origin.CACHE and cache_folder() is None
    second, origin = compiled(state, band)
    assert origin is not Origin.CACHE and same(first, second)


def test_the_key_tells_values_and_shapes_apart():
    keys = [
        content_key(value) for value in (1, 1.0, True, "1", None, [1], [[1]], np.ones(1), np.ones((1, 1)), {"a": 1})
    ]
    assert len(set(keys)) == len(keys)
    assert content_key({"a": 1, "b": 2}) == content_key({"b": 2, "a": 1})


def test_a_fresh_build_takes_the_band_from_the_cache_and_says_so(small_job, small_build, tmp_path):
    job = tmp_path / "job.yaml"
    job.write_text(small_job.read_text(encoding="utf-8") + "output: {pictures: false}\n", encoding="utf-8")
    build(load_job(job), out=tmp_path, jobs=1, fresh=True)
    notes = json.loads((tmp_path / "build.json").read_text(encoding="utf-8"))["files"]["s01b01.atmq.h5"]["notes"]
    assert "compiled band from the cache" in notes
    assert (tmp_path / "s01b01.atmq.h5").read_bytes() == (small_build / "s01b01.atmq.h5").read_bytes()
