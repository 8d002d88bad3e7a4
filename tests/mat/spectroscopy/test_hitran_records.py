"""Reading of HITRAN 160-column records, on records made up here."""

import gzip
import lzma

import numpy as np
import pytest

from skyshine.mat.spectroscopy.lines import read_lines
from skyshine.schemas.errors import InputError


def record(molecule=2, isotopologue="1", wavenumber=2349.1433, strength=3.5e-18, shift=-0.0028):
    text = f"{molecule:2d}{isotopologue}{wavenumber:12.6f}{strength:10.3e}{2.0:10.3e}"
    text += (
        f"{0.0745:.4f}"[1:]
        + f"{0.099:5.3f}"
        + f"{16.3897:10.4f}"
        + f"{0.71:4.2f}"
        + f"{shift:8.6f}".replace("0.", ".")[:8]
    )
    return text.ljust(160)


@pytest.mark.parametrize(
    "suffix, opener, end", [(".par", open, "\n"), (".par.gz", gzip.open, "\n"), (".par.xz", lzma.open, "\r\n")]
)
def test_reads_plain_and_compressed(tmp_path, suffix, opener, end):
    path = tmp_path / f"02_test{suffix}"
    with opener(path, "wb") as file:
        file.write((record(wavenumber=2400.0) + end + record(isotopologue="0") + end).encode())
    lines = read_lines(path)
    assert lines.molecule == 2 and len(lines) == 2
    assert lines.wavenumber.tolist() == [2349.1433, 2400.0]
    assert lines.isotopologue.tolist() == [10, 1]
    assert lines.strength[0] == 3.5e-18
    assert (lines.air_width[0], lines.self_width[0], lines.lower_energy[0]) == (0.0745, 0.099, 16.3897)
    assert (lines.temperature_exponent[0], lines.shift[0]) == (0.71, -0.0028)


def test_last_record_may_lack_its_line_end(tmp_path):
    path = tmp_path / "02.par"
    path.write_text(record() + "\n" + record(wavenumber=2350.0))
    assert len(read_lines(path)) == 2


def test_between_takes_both_ends(tmp_path):
    path = tmp_path / "02.par"
    path.write_text("".join(record(wavenumber=v) + "\n" for v in (2300.0, 2310.0, 2320.0)))
    assert read_lines(path).between(2300.0, 2310.0).wavenumber.tolist() == [2300.0, 2310.0]


@pytest.mark.parametrize(
    "text, message",
    [
        ("too short\n", "9 characters; HITRAN records have 160"),
        (record() + "\n" + record()[:100] + "\n", "not every record has 160"),
        (record().replace("3.500E-18", "3.5x0E-18").replace("3.500e-18", "3.5x0e-18") + "\n", "160-column format"),
        (record(isotopologue="Z") + "\n", "160-column format"),
        (record() + "\n" + record(molecule=6) + "\n", "contains molecules [2, 6]"),
    ],
)
def test_bad_files_are_refused(tmp_path, text, message):
    path = tmp_path / "bad.par"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_lines(path)
    assert message in str(caught.value) and str(path) in str(caught.value)


def test_files_of_two_molecules_are_refused(tmp_path):
    (tmp_path / "a.par").write_text(record() + "\n")
    (tmp_path / "b.par").write_text(record(molecule=6) + "\n")
    with pytest.raises(InputError, match="one molecule"):
        read_lines([tmp_path / "a.par", tmp_path / "b.par"])


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        read_lines(tmp_path / "absent.par")


def test_wavenumbers_come_ordered(tmp_path):
    values = np.random.default_rng(0).uniform(2000, 2400, 50).round(3)
    path = tmp_path / "02.par"
    path.write_text("".join(record(wavenumber=v) + "\n" for v in values))
    assert np.all(np.diff(read_lines(path).wavenumber) >= 0)
