"""A compiled band that misses its tolerance says so."""

import numpy as np

from skyshine.mat.atmosphere.band.compile import CompiledBand
from skyshine.mat.products.atmosphere import _missed


def test_only_quantities_beyond_the_tolerance_are_named():
    rms = {"transmittance": 2e-4, "path_thermal": 1.9e-2, "ambient": 1e-3}
    errors = {kind: {"max": 1.0, "p95": 1.0, "rms": value} for kind, value in rms.items()}
    compiled = CompiledBand(None, np.arange(7), 1158, errors, {}, np.zeros(7))
    assert _missed(compiled, 1e-3) == "path_thermal (1.9e-02 rms)"
    assert _missed(compiled, 0.02) == ""
