"""A compiled band that misses its tolerance says so."""

from types import SimpleNamespace

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.compile import EVERYWHERE, CompiledBand
from skyshine.mat.measure.scale import Scale
from skyshine.mat.products.atmosphere import _missed, _SourceTables
from skyshine.mat.tables.atmq import AMBIENT_HARMONICS
from skyshine.mat.tables.gridded import QUANTITIES
from skyshine.mat.tables.stated_error import measure


def test_only_quantities_beyond_the_tolerance_are_named():
    rms = {"transmittance": 2e-4, "path_thermal": 1.9e-2, "ambient": 1e-3}
    errors = {kind: {"max": 1.0, "p95": 1.0, "rms": value} for kind, value in rms.items()}
    compiled = CompiledBand(None, np.arange(7), 1158, errors, np.zeros(7))
    assert _missed(compiled, 1e-3) == "path_thermal (1.9e-02 rms)"
    assert _missed(compiled, 0.02) == ""


def test_errors_of_the_spectral_points_count_as_a_scene_sees_them():
    """Transmittance before the background; path radiance as it is, the worse of emitted and all; light on surfaces by
    what they reflect of it, over pi; of the table's own source alone.
    """
    kinds = {
        "transmittance": 0.01,
        "path_thermal": 0.1,
        "path_radiance": 0.2,
        "sky_irradiance": 3,
        "direct_irradiance": 4,
    }
    absolute = {
        kind: [{EVERYWHERE: dict.fromkeys(("max", "p99", "p95", "rms"), value * share)} for share in (1.0, 1e-6)]
        for kind, value in kinds.items()
    }
    absolute["transmittance"][0]["sky"] = dict.fromkeys(("max", "p99", "p95", "rms"), 0.04)
    compiled = CompiledBand(None, np.arange(7), 1158, {}, np.zeros(7), absolute)
    kelvin, percent = Scale(50.0, 2.0, 0.3), Scale(50.0, 4.0, 0.3)
    job = SimpleNamespace(trimmed=SimpleNamespace(sources=["sun", "moon"]))
    of_band = SimpleNamespace(compiled=compiled)
    asked = SimpleNamespace(
        of_band=of_band, loaded=job, source="sun", irradiance=None, _scales=lambda _: (kelvin, percent)
    )
    none, sky = np.zeros(1), {"sky": np.ones(1, bool)}
    exact = [measure(name, none, none, none, regions=sky) for name in (*QUANTITIES, AMBIENT_HARMONICS)]
    of_sky = 3 * 0.3 / np.pi * 2
    expected = {
        "beta_star": 0.01 * 50 * 2,
        "path_radiance_ratio": 0.2 * 2,
        "ambient_radiance": of_sky,
        "direct_radiance": 4 * 0.3 / np.pi * 2,
        AMBIENT_HARMONICS: of_sky,
    }
    for one in _SourceTables._with_spectral(asked, exact):
        assert one.maximum_kelvin == pytest.approx(expected[one.quantity]), one.quantity
        of_sky = (4 if one.quantity == "beta_star" else 1) * expected[one.quantity]
        assert one.regions["sky"].p99_kelvin == pytest.approx(of_sky), one.quantity
        # Of its one region, which is the worst.
        assert one.p99_kelvin == pytest.approx(of_sky) and one.p99_percent == pytest.approx(2 * of_sky), one.quantity
    asked.source = "moon"
    for one in _SourceTables._with_spectral(asked, exact):
        assert one.p99_kelvin == pytest.approx(1e-6 * expected[one.quantity]), one.quantity
