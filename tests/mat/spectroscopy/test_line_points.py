"""Spectra summed line by line, through the public function."""

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.spectroscopy.linebyline import point_cross_sections
from skyshine.mat.spectroscopy.lines import read_lines
from skyshine.schemas.errors import InputError


def record(molecule, wavenumber, strength, width=0.07, self_width=0.09, energy=100.0):
    """A line in HITRAN's 160 columns (Rothman et al. 2005, table 1)."""
    text = f"{molecule:2d}1{wavenumber:12.6f}{strength:10.3E}{1.0:10.3E}" + f"{width:.4f}"[1:]
    text += f"{self_width:5.3f}{energy:10.4f}{0.7:4.2f}{0.0:8.6f}"
    return text.ljust(160)


@pytest.fixture
def lines(tmp_path):
    """Water vapour at 2500.5 and carbon dioxide at 2502.25 cm^-1, in lists that begin and end far from there."""
    folder = tmp_path / "lines"
    folder.mkdir()
    for number, name, place in ((1, "H2O", 2500.5), (2, "CO2", 2502.25)):
        rows = [record(number, 500.0, 1e-30), record(number, place, 3e-22), record(number, 20000.0, 1e-30)]
        (folder / f"{number:02d}_{name}.par").write_text("\n".join(rows) + "\n")
    return folder


@pytest.fixture
def line(lines):
    def make(**settings):
        place = {"profile": "us_standard", "aerosol": "none", "range": 0.5, "source": "none", "co2_ppm": 400.0}
        return skyshine.mat.spectrum(wavenumber=(2500, 2504), line_by_line=lines, **{**place, **settings})

    return make


def test_bins_hold_the_lines_that_lie_in_them(line):
    """Carbon dioxide has one line, in the third bin of 1 cm^-1: there it absorbs most, water vapour in the first."""
    result = line()
    np.testing.assert_allclose(result.wavenumber, [2500.5, 2501.5, 2502.5, 2503.5])
    assert np.argmin(result.transmittance_by_gas["CO2"]) == 2
    assert np.argmin(result.transmittance_by_gas["H2O"]) == 0


def test_transmittance_is_the_mean_of_beer_and_lambert_over_each_bin(line, lines):
    """Level air of one pressure and temperature, summed at every wavenumber without grids."""
    result = line(resolution=0.5)
    wavenumber = np.linspace(2500, 2504, 40001)[:-1] + 5e-5
    listed = read_lines(lines / "02_CO2.par").between(2400, 2600)
    section = point_cross_sections(listed, wavenumber, [101325.0], [288.15], 4e-4, 2)[0, 0]
    column = 400e-6 * 101325.0 / (1.380649e-23 * 288.15) * 500.0
    expected = np.exp(-section * column).reshape(8, -1).mean(axis=1)
    assert expected.min() < 0.9
    np.testing.assert_allclose(result.transmittance_by_gas["CO2"], expected, atol=2e-4)


def test_fine_bins_average_to_coarse_ones(line):
    """Black bodies and smooth coefficients are those of the middle of a bin."""
    fine, coarse = line(resolution=0.25), line(resolution=1.0)
    for name in ("transmittance", "path_thermal", "sky_irradiance"):
        np.testing.assert_allclose(
            getattr(fine, name).reshape(4, 4).mean(axis=1), getattr(coarse, name), rtol=2e-3, err_msg=name
        )


def test_gases_without_records_are_those_of_the_band_model(line):
    """N2O absorbs at 2500 cm^-1 and has no list here: the interval's mean, the same in all of its bins."""
    result = line(range=5.0)
    band = skyshine.mat.spectrum(
        wavenumber=(2500, 2504), profile="us_standard", aerosol="none", range=5.0, source="none", co2_ppm=400.0
    )
    found = result.transmittance_by_gas["N2O"]
    assert np.ptp(found) < 1e-12 and found[0] < 1
    assert 1 - found[0] == pytest.approx(1 - band.transmittance_by_gas["N2O"][0], rel=0.2)
    assert "line by line: H2O, CO2; by interval means of the band model: " in result.attributes["absorption"]
    assert "N2O" in result.attributes["absorption"]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"resolution": 0.001}, "at least 0.01"),
        ({"resolution": 3.0}, "whole number of bins"),
        ({"resolution": np.nan}, "whole number of bins"),
    ],
)
def test_bins_that_do_not_fit_are_refused(line, settings, message):
    with pytest.raises(InputError, match=message):
        line(**settings)


def test_a_folder_without_water_is_refused(tmp_path):
    with pytest.raises(InputError, match="H2O, CO2"):
        skyshine.mat.spectrum(wavenumber=(1000, 1005), line_by_line=tmp_path)


def test_finer_bins_of_the_band_model_name_what_they_need():
    with pytest.raises(InputError, match="line_by_line with a folder of HITRAN records"):
        skyshine.mat.spectrum(wavenumber=(1000, 1005), resolution=0.5)


@pytest.mark.shared_data
def test_band_model_is_the_mean_of_lines(shared_data):
    """One of its intervals in the window at 10 um, 2 km at sea level: H2O, CO2 and CH4 of HITRAN2012."""
    place = {"wavenumber": (940, 945), "profile": "tropical", "range": 2.0, "source": "none"}
    band = skyshine.mat.spectrum(**place)
    fine = skyshine.mat.spectrum(**place, line_by_line=shared_data / "lines", resolution=5.0)
    for name in ("H2O", "CO2"):
        np.testing.assert_allclose(fine.transmittance_by_gas[name], band.transmittance_by_gas[name], atol=0.003)
    np.testing.assert_allclose(fine.transmittance, band.transmittance, atol=0.005)
