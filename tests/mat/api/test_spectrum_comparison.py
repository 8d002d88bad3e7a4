"""A spectrum beside that of a file: bins, differences, and the command."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import skyshine.mat
from skyshine.mat.commands.spectrum import command
from skyshine.mat.tables.pictures import draw_comparison
from skyshine.schemas.errors import InputError


@pytest.fixture(scope="module")
def line():
    return skyshine.mat.spectrum(profile="us_standard", range=2, wavenumber=(900, 960), source="none")


def written(folder, wavenumber, transmittance):
    file = folder / "other.csv"
    rows = "".join(f"{nu:.8g},{value:.8g}\n" for nu, value in zip(wavenumber, transmittance, strict=True))
    file.write_text("wavenumber[cm^-1],transmittance\n" + rows)
    return file


def test_a_shift_is_the_difference_of_means_and_the_rms(line, tmp_path):
    comparison = line.compare(written(tmp_path, line.wavenumber, line.transmittance - 0.01))
    assert comparison.difference["transmittance"] == pytest.approx(0.01, abs=1e-7)
    ours, theirs = comparison.means["transmittance"]
    assert ours - theirs == pytest.approx(0.01, abs=1e-7)
    assert comparison.rms["transmittance"] == pytest.approx(0.01, abs=1e-7)


def test_differences_of_both_signs_do_not_cancel_in_the_rms(line, tmp_path):
    sign = np.where(np.arange(line.wavenumber.size) % 2, 1, -1)
    comparison = line.compare(written(tmp_path, line.wavenumber, line.transmittance - 0.02 + 0.01 * sign))
    assert comparison.rms["transmittance"] == pytest.approx(np.sqrt(0.02**2 + 0.01**2), abs=1e-6)


def test_a_finer_file_is_averaged_over_our_bins(line, tmp_path):
    """Points of 1 cm-1 in bins of 5: the mean of five of them."""
    fine = np.arange(900.5, 960)
    values = 0.5 + 0.3 * np.sin(fine)
    comparison = line.compare(written(tmp_path, fine, values))
    width = line.wavenumber[1] - line.wavenumber[0]
    assert comparison.wavenumber == pytest.approx(line.wavenumber)
    assert comparison.reference["transmittance"] == pytest.approx(
        values.reshape(-1, round(width)).mean(axis=1), abs=1e-7
    )


def test_a_coarser_file_has_ours_averaged(line, tmp_path):
    comparison = line.compare(written(tmp_path, [910.0, 930.0, 950.0], [0.5, 0.6, 0.7]))
    assert comparison.wavenumber == pytest.approx([910, 930, 950])
    assert comparison.computed["transmittance"] == pytest.approx(line.transmittance.reshape(3, -1).mean(axis=1))


def test_what_has_no_bin_in_common_is_refused(line, tmp_path):
    with pytest.raises(InputError, match="allowed: spectra with a bin in common"):
        line.compare(written(tmp_path, [2000.0, 2010.0], [0.5, 0.6]))
    lines = skyshine.mat.spectrum(range=[1, 2], wavenumber=(900, 960), source="none")
    with pytest.raises(InputError, match="allowed: a single one"):
        lines.compare(written(tmp_path, [910.0, 930.0], [0.5, 0.6]))


def test_the_command_takes_the_range_of_the_file(line, tmp_path):
    file = written(tmp_path, line.wavenumber, line.transmittance)
    arguments = ["--profile", "us_standard", "--range", "2", "--source", "none", "--compare", str(file)]
    result = CliRunner().invoke(command, [*arguments, "--json"])
    assert result.exit_code == 0, result.output
    content = json.loads(result.output)
    assert content["rms"]["transmittance"] < 1e-7
    assert content["wavenumber"]["values"][0] == pytest.approx(line.wavenumber[0])


def test_a_picture_shows_both(line, tmp_path):
    comparison = line.compare(written(tmp_path, line.wavenumber, line.transmittance - 0.01))
    picture = draw_comparison(comparison, "2 km", tmp_path / "both.png")
    assert picture.stat().st_size > 5000


def test_the_command_writes_a_table_and_prints_means(line, tmp_path):
    file = written(tmp_path, line.wavenumber[:3], line.transmittance[:3])
    table = tmp_path / "table.csv"
    arguments = ["--profile", "us_standard", "--range", "2", "--source", "none", "--compare", str(file)]
    result = CliRunner().invoke(command, [*arguments, "--out", str(table)])
    assert result.exit_code == 0, result.output
    assert "transmittance: mean" in result.output
    assert "transmittance_difference[1]" in table.read_text()
