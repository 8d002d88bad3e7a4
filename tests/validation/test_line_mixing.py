"""The head of CO2's band at 4.3 um, 2385 to 2440 cm-1, on homogeneous paths: against the relaxation matrix with more
bands and lines, and against measured wings.

The measured wings are the factors on Lorentz lines that C. Cousin, R. Le Doucen, C. Boulet and A. Henry found for N2 at
296 and 238 K (1985, Appl. Opt. 24, 3899), as the code of the MIPAS group at Karlsruhe has them, linear in temperature
between.
"""

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("hapi")

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.radiometry.constants import BOLTZMANN
from skyshine.mat.spectroscopy import line_mixing, linebyline
from skyshine.mat.spectroscopy.gases import LineLibrary

pytestmark = [pytest.mark.validation, pytest.mark.shared_data]

EDGES = np.arange(2385.0, 2441.0, 5.0)
STEP = 0.02
PPM = 400.0
# Pressure [Pa], temperature [K], length [m].
PATHS = (
    (101325.0, 296.0, 500.0),
    (101325.0, 296.0, 2e3),
    (101325.0, 296.0, 5e3),
    (101325.0, 250.0, 1e3),
    (90000.0, 275.0, 3e3),
    (70000.0, 260.0, 5e3),
    (40000.0, 240.0, 10e3),
    (30000.0, 238.0, 20e3),
)
LIMIT = 0.03


def wavenumbers():
    return np.arange(EDGES[0], EDGES[-1], STEP) + STEP / 2


def means(section, pressure, temperature, length):
    """Transmittance of each 5 cm^-1."""
    column = PPM * 1e-6 * pressure / (BOLTZMANN * temperature) * length
    return np.exp(-column * section).reshape(EDGES.size - 1, -1).mean(axis=1)


@pytest.fixture(scope="module")
def library(shared_data):
    return LineLibrary(shared_data / "lines")


@pytest.fixture(scope="module")
def whole(shared_data):
    """A library with five times weaker bands and a hundred times weaker lines in its matrices."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(line_mixing, "WEAKEST_BAND", 1e-19)
        patch.setattr(line_mixing, "WEAKEST_LINE", 1e-29)
        made = LineLibrary(shared_data / "lines")
        at_once = made.point_cross_sections("CO2", np.array([2390.0]), [1e5], [250.0], 4e-4)
        assert at_once.min() > 0
    return made


def of(library, path):
    pressure, temperature, _ = path
    return library.point_cross_sections("CO2", wavenumbers(), [pressure], [temperature], 4e-4)[0, 0]


@pytest.mark.parametrize("path", PATHS)
def test_the_bands_left_single_matter_little(library, whole, path):
    error = means(of(library, path), *path) - means(of(whole, path), *path)
    print(f"\n{path}: largest {np.abs(error).max():.4f}")
    assert np.abs(error).max() <= 0.002


def factor(distance, temperature):
    """Cousin et al. 1985."""
    at_296 = np.select(
        [distance <= 0.5, distance <= 20, distance <= 50],
        [1.0, 1.064 * np.exp(-0.1235 * distance), 0.125 * np.exp(-0.0164 * distance)],
        0.146 * np.exp(-0.0196 * distance),
    )
    at_238 = np.select(
        [distance <= 5, distance <= 22, distance <= 50],
        [1.0, 1.968 * np.exp(-0.1354 * distance), 0.160 * np.exp(-0.0214 * distance)],
        0.162 * np.exp(-0.0216 * distance),
    )
    return np.minimum(at_238 + (at_296 - at_238) * (temperature - 238) / 58, 1.0)


@pytest.mark.parametrize("path", PATHS)
def test_wings_are_those_measured_in_nitrogen(library, path):
    pressure, temperature, _ = path
    lines = library.lines("CO2").between(2150, 2700)
    lines = lines.select(lines.strength > 1e-25)
    strength, _, widening = linebyline.line_parameters(lines, np.array([temperature]))
    width = lines.air_width * widening[0] * pressure / linebyline.ATMOSPHERE
    nu, section = wavenumbers(), np.zeros(wavenumbers().size)
    for k in range(len(lines)):
        distance = np.abs(nu - lines.wavenumber[k])
        lorentz = width[k] / np.pi / (distance**2 + width[k] ** 2)
        section += strength[0, k] * lorentz * factor(distance, temperature)
    error = means(of(library, path), *path) - means(section, *path)
    print(f"\n{path}: {' '.join(f'{e:+.3f}' for e in error)}")
    # The first two intervals lie among the last lines, where one factor for all lines says least.
    assert np.abs(error).max() <= 0.12
    assert np.abs(error[EDGES[:-1] >= 2405]).max() <= LIMIT
    if temperature <= 260:
        assert np.abs(error).max() <= 0.05


@pytest.mark.parametrize("path", PATHS)
def test_the_table_holds_the_head_of_the_matrix(whole, path):
    pressure, temperature, length = path
    column = PPM * 1e-6 * pressure / (BOLTZMANN * temperature) * length
    points = AbsorptionTable.open().points(EDGES[0] + 0.1, EDGES[-1] - 0.1)
    air = (np.array([pressure]), np.array([temperature]), np.zeros(1))
    through = np.exp(-column * points.cross_sections(*air, gases=["CO2"])["CO2"][0])
    ours = np.bincount(points.interval, points.weight * through) / np.diff(EDGES)
    error = ours - means(of(whole, path), *path)
    print(f"\n{path}: largest {np.abs(error).max():.4f}")
    assert np.abs(error).max() <= 0.005
