"""Line by line against HITRAN's own HAPI, and the absorption table against line by line on unseen homogeneous paths."""

import contextlib
import io

import numpy as np
import pytest

pytestmark = [pytest.mark.validation, pytest.mark.shared_data]

pytest.importorskip("numba")
pytest.importorskip("hapi")

from line_by_line_reference import Path, interval_transmittance

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.spectroscopy import linebyline
from skyshine.mat.spectroscopy.continua import Continua
from skyshine.mat.spectroscopy.gases import LineLibrary
from skyshine.mat.spectroscopy.sources import LineSource


@pytest.fixture(scope="module")
def library(shared_data):
    return LineLibrary(shared_data / "lines")


def hapi_cross_sections(lines, wavenumber, pressure, temperature):
    """Voigt cross sections in m2/molecule by HAPI, air broadening, 25 cm-1 wings."""
    with contextlib.redirect_stdout(io.StringIO()):
        import hapi

        columns = {
            "molec_id": np.full(len(lines), lines.molecule),
            "local_iso_id": lines.isotopologue,
            "nu": lines.wavenumber,
            "sw": lines.strength,
            "elower": lines.lower_energy,
            "gamma_air": lines.air_width,
            "gamma_self": lines.self_width,
            "n_air": lines.temperature_exponent,
            "delta_air": lines.shift,
            "a": lines.strength,
        }
        header = {"number_of_rows": len(lines), "table_name": "lines", "default": {}, "order": []}
        data = {name: values.tolist() for name, values in columns.items()}
        hapi.LOCAL_TABLE_CACHE["lines"] = {"header": header, "data": data}
        _, section = hapi.absorptionCoefficient_Voigt(
            SourceTables="lines",
            Environment={"p": pressure / 101325.0, "T": temperature},
            Diluent={"air": 1.0},
            WavenumberGrid=wavenumber,
            WavenumberWing=25.0,
            HITRAN_units=True,
        )
    return section * 1e-4


@pytest.mark.parametrize(
    "gas, low, pressure, temperature, column",
    [
        ("CO2", 2310.0, 101325.0, 296.0, 1e22),
        ("CO2", 2310.0, 5000.0, 220.0, 1e22),
        ("H2O", 1000.0, 101325.0, 296.0, 3e27),
        ("CH4", 3010.0, 20000.0, 250.0, 3e23),
    ],
)
def test_voigt_core_agrees_with_hapi(library, gas, low, pressure, temperature, column):
    lines = library.lines(gas).between(low - 10.0, low + 15.0)
    ours = linebyline.interval_spectrum(lines, low, low + 5.0, [pressure], [temperature])[0, 0]
    theirs = hapi_cross_sections(lines, linebyline.interval_grid(low, low + 5.0), pressure, temperature)
    difference = np.exp(-column * ours) - np.exp(-column * theirs)
    assert np.sqrt(np.mean(difference**2)) <= 2e-4


def test_table_agrees_with_line_by_line_on_paths_it_has_not_seen(library, shared_data):
    continua, table = Continua(shared_data / "continua"), AbsorptionTable.open()
    rng = np.random.default_rng(11)
    errors = {"H2O": [], "CO2": [], "CH4": []}
    lows = rng.choice(np.concatenate([np.arange(750.0, 1300.0, 5), np.arange(1900.0, 3400.0, 5)]), 24, replace=False)
    for low in lows:
        points = table.points(low, low + 5.0)
        altitude = rng.uniform(0.0, 15e3)
        pressure, temperature = 101325.0 * np.exp(-altitude / 8e3), 300.0 - 5.5e-3 * altitude + rng.uniform(-15, 15)
        humidity = min(
            0.03, rng.uniform(0.1, 1.0) * 611.0 * np.exp(17.7 * (temperature - 273) / (temperature - 29)) / pressure
        )
        path = Path(pressure, temperature, 10 ** rng.uniform(2, 5), {"H2O": humidity, "CO2": 4e-4, "CH4": 1.9e-6})
        sections = points.cross_sections(pressure, temperature, humidity)
        for gas, found in errors.items():
            expected = interval_transmittance(library, continua, path, gas, low, low + 5.0)
            mean = points.weight @ np.exp(-path.column(gas) * sections[gas][0]) / 5.0
            found.append(mean - expected)
    for gas, found in errors.items():
        assert np.sqrt(np.mean(np.square(found))) <= 0.003, gas
        assert np.abs(found).max() <= 0.015, gas


@pytest.mark.parametrize("gas", ["H2O", "CO2", "CH4"])
def test_interpolation_in_pressure_and_temperature_adds_little(library, shared_data, gas):
    continua, table = Continua(shared_data / "continua"), AbsorptionTable.open()
    source = LineSource(gas, library, continua)
    rng = np.random.default_rng(5)
    errors = []
    for low in (1000.0, 1250.0, 2100.0, 2350.0, 3000.0):
        points = table.points(low, low + 5.0)
        pressure = np.sort(101325.0 * 10 ** rng.uniform(-4, 0, 8))
        temperature = rng.uniform(200.0, 315.0, 8)
        interpolated = points.cross_sections(pressure, temperature, 0.0, gases=[gas])[gas]
        for p, t, section in zip(pressure, temperature, interpolated, strict=True):
            direct = source.cross_sections(points.wavenumber, [p], [t])[:, 0, 0]
            if direct.max() < 1e-33:
                continue
            for depth in (0.3, 1.0, 3.0):
                column = depth / np.exp(np.mean(np.log(direct)))
                errors.append(points.weight @ (np.exp(-column * section) - np.exp(-column * direct)) / 5.0)
    assert np.sqrt(np.mean(np.square(errors))) < 5e-4
    assert np.abs(errors).max() < 4e-3  # hot bands of CO2 in the stratosphere, where they absorb next to nothing
