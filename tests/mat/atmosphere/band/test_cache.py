"""Compiled bands kept by content: same bytes with and without, nothing taken from a broken or foreign file."""

import io
import json
import os
import random
from collections import OrderedDict
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.band import cache as band_cache
from skyshine.mat.atmosphere.band.cache import FOLDER, Origin, cached_compile_band, content_key
from skyshine.mat.atmosphere.band.compile import AirTest, SharedPoints, SimilarAirs, fit_band, over_air
from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.job.load import load_job
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.schemas.digest import digest_of
from skyshine.schemas.kept_arrays import CACHE_VARIABLE, FILE_LIMIT, kept_folder

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
    return points_of_band(TABLE, response)


def compiled(state, band, distance=1.0, **changed):
    settings = {"tolerance": 1e-3, "max_points": 12, "seed": 0, **changed}
    sun = solar_irradiance(band.wavenumber, band.width)
    return cached_compile_band(TABLE, state, band, GRID, sun / distance**2, sun, **settings)


def same(first, second):
    arrays = [(one.index, one.band.weight, one.band.points.wavenumber, one.ladder) for one in (first, second)]
    return all(a.tobytes() == b.tobytes() for a, b in zip(*arrays, strict=True)) and (
        (first.errors, first.band.gases, first.total_points) == (second.errors, second.band.gases, second.total_points)
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


@pytest.fixture
def choices(monkeypatch, result, state, band):
    """Has points be chosen for similar airs by a function that is given; each choice is a row."""
    made = []
    for name in ("_fits", "_choices"):
        monkeypatch.setattr(band_cache, name, OrderedDict())

    def choose(chosen, approximate):
        fit = replace(result, chosen=chosen, approximate=approximate)
        sun = solar_irradiance(band.wavenumber, band.width)[None]
        shared = SharedPoints(chosen, (AirTest.of(fit, state.surface_temperature, sun),), sun.mean(axis=1))
        monkeypatch.setattr(band_cache, "choose_points", lambda *args, **settings: made.append(args) or shared)
        return made

    return choose


def similar(state):
    return SimilarAirs(tuple(replace(state, temperature=state.temperature + shift) for shift in (-5.0, 5.0)), (state,))


def test_similar_airs_share_points_where_these_hold(folder, state, band, monkeypatch, result, choices):
    chosen = choices(result.chosen, result.approximate)
    days = [replace(state, temperature=state.temperature + shift) for shift in (-1.0, 1.0)]
    airs = similar(state)
    first, origin = compiled(days[0], band, similar=airs, tolerance=1.0)
    assert origin is Origin.SIMILAR and len(list(folder.iterdir())) == 2  # the choice, and the band of the state
    assert compiled(days[1], band, similar=airs, tolerance=1.0)[1] is Origin.SHARED_SIMILAR
    assert len(chosen) == 1
    # Another process finds the choice in the folder, and its tests.
    monkeypatch.setattr(band_cache, "_choices", {})
    again, origin = compiled(replace(days[0], surface_temperature=299.0), band, similar=airs, tolerance=1.0)
    assert origin is Origin.SHARED_SIMILAR and len(chosen) == 1
    assert same(first, again) and first.absolute == again.absolute


def test_points_that_fail_in_airs_of_the_cell_or_in_the_own_air_are_not_shared(
    folder, state, band, monkeypatch, result, choices
):
    halves = {kind: 0.5 * values for kind, values in result.approximate.unlit.items()}
    choices(result.chosen, replace(result.approximate, unlit=halves))
    assert compiled(state, band, similar=similar(state))[1] is Origin.FITTED
    monkeypatch.setattr(band_cache, "_choices", {})
    choices(result.chosen, result.approximate)
    humid = replace(state, mole_fraction=state.mole_fraction | {"H2O": 9 * state.mole_fraction["H2O"]})
    assert compiled(humid, band, similar=similar(state), seed=1)[1] is Origin.FITTED


@pytest.mark.parametrize(("fit_error", "origin"), [(1e-4, Origin.FITTED), (4e-4, Origin.SIMILAR)])
def test_shared_points_may_miss_the_tolerance_where_their_number_is_limited(
    folder, state, band, result, fit_error, origin, choices
):
    """By 1.3 times it, which points of the state's own air would miss too; otherwise these are fitted."""
    brighter = {kind: 1.0013 * values for kind, values in result.exact.unlit.items()}
    approximate = replace(result.exact, unlit=brighter, interval_start=np.arange(result.exact.interval_start.size))
    choices(replace(result.chosen, index=result.exact.interval_start[:9], ladder=np.array([fit_error])), approximate)
    shared, found = compiled(state, band, similar=similar(state))
    assert found is origin
    if found is Origin.SIMILAR:
        assert 1e-3 < shared.errors["transmittance"]["rms"] < 1.5e-3


def test_another_state_tolerance_or_seed_is_compiled_anew(folder, state, band):
    compiled(state, band)
    warmer = replace(state, temperature=state.temperature + 1e-9)
    assert not any(
        origin is Origin.CACHE
        for _, origin in (compiled(warmer, band), compiled(state, band, tolerance=2e-3), compiled(state, band, seed=1))
    )


def believed(path, band):
    """What the cache reads from a file, with a good answer for a digest where none holds."""
    return band_cache._read(path, path.stem, band)


def forged(path, **changed):
    """A kept file with other content and a digest to fit it, as a faulty or a hostile program would write it."""
    content = path.read_bytes()[len(band_cache.HEAD) + 65 :]
    with np.load(io.BytesIO(content)) as kept:
        arrays = dict(kept)
    about = json.loads(str(arrays["about"]))
    for name, change in changed.items():
        place = arrays if name in arrays else about
        place[name] = change(place[name])
    arrays["about"] = np.array(json.dumps(about))
    written = io.BytesIO()
    np.savez(written, **arrays)
    digest = digest_of(path.stem, written.getvalue()).encode()
    path.write_bytes(band_cache.HEAD + digest + b"\n" + written.getvalue())


FORGERIES = {
    "weights doubled": {"weight": lambda values: 2 * values},
    "a weight below 0": {"weight": lambda values: values * np.where(np.arange(values.size), 1, -1)},
    "a weight without a number": {"weight": lambda values: np.full_like(values, np.nan)},
    "a weight too few": {"weight": lambda values: values[:-1]},
    "weights of single precision": {"weight": lambda values: values.astype("f4")},
    "a point beyond the band": {"index": lambda values: values + 10**6},
    "a point counted from the end": {"index": lambda values: values - values.max() - 1},
    "a point twice": {"index": lambda values: np.full_like(values, values[0])},
    "points by rows": {"index": lambda values: values[None]},
    "points as fractions": {"index": lambda values: values.astype(float)},
    "another gas": {"gases": lambda names: ["Xe", *names[1:]]},
    "a gas too few": {"gases": lambda names: names[1:]},
    "another number of points": {"total_points": lambda count: count + 1},
    "another quantity": {"errors": lambda errors: {"heat": next(iter(errors.values()))}},
    "errors as text": {"errors": lambda errors: dict.fromkeys(errors, "small")},
    "an error below 0": {"errors": lambda errors: {name: dict.fromkeys(e, -1.0) for name, e in errors.items()}},
    "a ladder without numbers": {"ladder": lambda values: values * np.nan},
}


@pytest.mark.parametrize("forgery", FORGERIES)
def test_content_that_does_not_fit_the_band_is_not_believed(folder, state, band, forgery):
    first, _ = compiled(state, band)
    (file,) = folder.iterdir()
    forged(file)
    assert believed(file, band) is not None  # the forger's hand is right, and what it changes is what is refused
    forged(file, **FORGERIES[forgery])
    assert believed(file, band) is None
    second, origin = compiled(state, band)
    assert origin is not Origin.CACHE and same(first, second) and compiled(state, band)[1] is Origin.CACHE


def test_a_file_of_another_key_is_not_believed(folder, state, band):
    compiled(state, band)
    (file,) = folder.iterdir()
    other = file.with_name(f"{'0' * 64}.npz")
    other.write_bytes(file.read_bytes())
    assert believed(file, band) is not None and believed(other, band) is None


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
def test_only_a_regular_file_of_this_user_is_read(folder, state, band, monkeypatch):
    compiled(state, band)
    (file,) = folder.iterdir()
    whole = file.read_bytes()
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    assert believed(file, band) is None
    monkeypatch.undo()
    assert believed(file, band) is not None
    file.rename(folder / "elsewhere")
    file.symlink_to(folder / "elsewhere")
    assert believed(file, band) is None
    file.unlink()
    file.write_bytes(whole + bytes(FILE_LIMIT))
    assert believed(file, band) is None
    file.unlink()
    os.mkfifo(file)
    assert believed(file, band) is None


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
def test_a_pipe_in_place_of_a_file_is_replaced(folder, state, band):
    compiled(state, band)
    (file,) = folder.iterdir()
    file.unlink()
    os.mkfifo(file)
    assert compiled(state, band)[1] is not Origin.CACHE
    assert file.is_file() and compiled(state, band)[1] is Origin.CACHE


def damaged(content: bytes, draw: random.Random) -> bytes:
    """A file with bits flipped, bytes zeroed, an end lost or two pieces swapped."""
    data, at, length = bytearray(content), draw.randrange(len(content)), draw.choice([1, 4, 16, 200])
    kind = draw.choice(["flip", "zero", "truncate", "swap"])
    if kind == "flip":
        data[at] ^= 1 << draw.randrange(8)
    elif kind == "zero":
        data[at : at + length] = bytes(len(data[at : at + length]))
    elif kind == "truncate":
        del data[at:]
    else:
        other = draw.randrange(len(content))
        data[at : at + length], data[other : other + length] = data[other : other + length], data[at : at + length]
    return bytes(data)


def test_of_3000_damaged_files_none_is_believed_and_none_raises(folder, state, band):
    first, _ = compiled(state, band)
    (file,) = folder.iterdir()
    whole, draw, changed = file.read_bytes(), random.Random(3), 0
    for _ in range(3000):
        content = damaged(whole, draw)
        file.write_bytes(content)
        found = believed(file, band)
        assert found is None if content != whole else same(found, first)
        changed += content != whole
    assert changed > 2500


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
    assert origin is not Origin.CACHE and kept_folder(FOLDER) is None
    second, origin = compiled(state, band)
    assert origin is not Origin.CACHE and same(first, second)


def test_the_key_tells_values_and_shapes_apart():
    keys = [
        content_key(value) for value in (1, 1.0, True, "1", None, [1], [[1]], np.ones(1), np.ones((1, 1)), {"a": 1})
    ]
    assert len(set(keys)) == len(keys)
    assert content_key({"a": 1, "b": 2}) == content_key({"b": 2, "a": 1})


def test_a_fresh_build_takes_the_band_from_the_cache_and_says_so(build_inline, tiny_job, tiny_build, tmp_path):
    job = tmp_path / "job.yaml"
    job.write_text(tiny_job(), encoding="utf-8")
    build_inline(load_job(job), out=tmp_path, fresh=True)
    notes = json.loads((tmp_path / "build.json").read_text(encoding="utf-8"))["files"]["s01b01.atmq.h5"]["notes"]
    assert "compiled band from the cache" in notes
    assert (tmp_path / "s01b01.atmq.h5").read_bytes() == (tiny_build / "s01b01.atmq.h5").read_bytes()
