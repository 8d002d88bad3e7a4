"""The water vapour continuum of MT_CKD 2.4 against the figures of its time and against the packaged file."""

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("netCDF4")
pytestmark = pytest.mark.shared_data

from mat.maintain.atmospheres.water_continua import coefficients
from skyshine import atmospheres
from skyshine.mat.spectroscopy.continua import Continua


@pytest.fixture(scope="module")
def derived(shared_data):
    return np.array(coefficients(Continua(shared_data / "continua")))


def test_the_packaged_file_is_what_the_program_derives(derived):
    lines = atmospheres.path("continuum/mt_ckd_2.4.csv").read_text(encoding="utf-8").splitlines()
    rows = [line for line in lines if not line.startswith("#")][1:]  # the first names the columns
    packaged = np.loadtxt(rows, delimiter=",", unpack=True)
    np.testing.assert_allclose(derived, packaged, rtol=1e-8, atol=0)


def test_the_self_continuum_at_260_kelvin_is_that_of_the_release(derived):
    """Figures printed with MT_CKD 1.00 at 2000 cm-1: 7.720e-6 at 296 K and 1.167e-5 at 260 K, 1e-20 cm3/molecule."""
    wavenumber, self_continuum, _, exponent = derived
    (place,) = np.flatnonzero(wavenumber == 2000.0)
    assert self_continuum[place] == pytest.approx(7.720e-6 * 1e-24, rel=1e-3, abs=0)
    assert self_continuum[place] * (296 / 260) ** exponent[place] == pytest.approx(1.167e-5 * 1e-24, rel=1e-3, abs=0)


def test_the_self_continuum_falls_with_temperature_and_exceeds_the_foreign(derived):
    _, self_continuum, foreign, exponent = derived
    assert np.all(exponent > 0) and np.all(self_continuum > foreign)
