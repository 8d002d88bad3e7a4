"""Spectra as MODTRAN and tables write them: the same numbers from each form, and what is refused."""

import numpy as np
import pytest

from skyshine.mat.tables.channels import _rounded_shares
from skyshine.mat.tables.other_spectra import read_other_spectrum
from skyshine.schemas.errors import InputError

FREQUENCY = np.arange(1000.0, 1006.0)
TRANSMITTANCE = np.array([0.91, 0.812, 0.7826, 0.9041, 0.5, 0.6891])
THERMAL = np.array([2.0416e-8, 4.2477e-8, 4.8945e-8, 2.2e-8, 9.1e-8, 5.8376e-8])  # W cm-2 sr-1 (cm-1)-1
SCATTERED = np.array([1.9e-10, 1.8e-10, 1.7e-10, 1.6e-10, 1.5e-10, 1.4e-10])
ECHO = "T   6    2    2    1    0    0    0    0    0    0    0    0    0   0.000   0.00\n   36US STANDARD\n"


def radiance_tape7(underscore="_", scattered=True, percent=""):
    """Columns of IEMSCT 1 or 2, some blank, as MODTRAN aligns them."""
    names = ("TOT TRANS", "PTH THRML", "THRML SCT", "SURF EMIS", "SOL SCAT", "SING SCAT", "TOTAL RAD")
    lines = [
        percent
        + "    FREQ"[len(percent) :]
        + "".join(f"{name.replace(' ', underscore):>11}" for name in names)
        + "   DEPTH"
    ]
    for row, frequency in enumerate(FREQUENCY):
        sun = f"{SCATTERED[row]:11.4E}{0:11.4E}" if scattered else " " * 22
        thermal = f"{THERMAL[row]:11.4E}"
        lines.append(f"{frequency:8.2f}{TRANSMITTANCE[row]:11.8f}{thermal}{' ':11}{0:11.4E}{sun}{thermal}{0.1:8.3f}")
    return percent + ECHO.replace("\n", "\n" + percent, 1) + "\n".join([*lines, " -9999."]) + "\n"


def transmission_tape7():
    lines = ["    FREQ COMBIN    H2O   UMIX    -LOG", "    CM-1  TRANS  TRANS  TRANS  COMBIN"]
    for frequency, value in zip(FREQUENCY, TRANSMITTANCE, strict=True):
        lines.append(f"{frequency:8.2f}{value:7.4f}{0.99:7.4f}{1.0:7.4f}{0.1:8.3f}")
    return ECHO + "\n".join([*lines, " -9999."])


def scanned_tape7():
    """tape7.scn by wavelength: W cm-2 sr-1 um-1, 1 per cm-1 being 1e4 / um^2 per um."""
    lines = [" WAVLEN MCRN  TRANS  PTH THRML  THRML SCT  SURF EMIS   SOL SCAT"]
    for frequency, value, thermal, sun in [*zip(FREQUENCY, TRANSMITTANCE, THERMAL, SCATTERED, strict=True)][::-1]:
        per_um = frequency**2 / 1e4
        numbers = (
            f"{1e4 / frequency:12.8f}",
            f"{value:7.4f}",
            f"{thermal * per_um:11.4E}",
            " " * 22,
            f"{sun * per_um:11.4E}",
        )
        lines.append("".join(numbers))
    return ECHO + "\n".join([*lines, " -9999."])


def read(tmp_path, text):
    file = tmp_path / "tape7"
    file.write_text(text)
    return read_other_spectrum(file)


@pytest.mark.parametrize("text", [radiance_tape7(), radiance_tape7(" "), radiance_tape7(percent="%"), scanned_tape7()])
def test_forms_of_tape7_give_the_same_spectrum(tmp_path, text):
    spectrum = read(tmp_path, text)
    assert spectrum.wavenumber == pytest.approx(FREQUENCY)
    assert spectrum.values["transmittance"] == pytest.approx(TRANSMITTANCE)
    assert spectrum.values["path_thermal"] == pytest.approx(1e4 * THERMAL, rel=1e-4)
    assert spectrum.values["path_scattered"] == pytest.approx(1e4 * SCATTERED, rel=1e-4)


def test_columns_without_numbers_are_left(tmp_path):
    assert set(read(tmp_path, radiance_tape7(scattered=False)).values) == {"transmittance", "path_thermal"}


def test_transmission_is_read_from_combin(tmp_path):
    spectrum = read(tmp_path, transmission_tape7())
    assert set(spectrum.values) == {"transmittance"}
    assert spectrum.values["transmittance"] == pytest.approx(TRANSMITTANCE, abs=1e-4)


def test_the_first_of_several_runs_is_read(tmp_path):
    assert read(tmp_path, radiance_tape7() + radiance_tape7()).runs == 2
    assert read(tmp_path, radiance_tape7() + radiance_tape7()).wavenumber.size == FREQUENCY.size


@pytest.mark.parametrize(
    ("unit", "factor"),
    [
        ("W m^-2 sr^-1 (cm^-1)^-1", 1e4 * THERMAL),
        ("W cm^-2 sr^-1 (cm^-1)^-1", THERMAL),
        ("W m^-2 sr^-1 um^-1", 1e4 * THERMAL * FREQUENCY**2 / 1e4),
        ("uW cm^-2 sr^-1 nm^-1", 1e3 * THERMAL * FREQUENCY**2 / 1e4),
    ],
)
def test_csv_with_units_gives_the_same_radiance(tmp_path, unit, factor):
    rows = "".join(f"{1e4 / nu:.9g},{value:.9g}\n" for nu, value in zip(FREQUENCY, factor, strict=True))
    spectrum = read(tmp_path, f"wavelength[um],path_thermal[{unit}]\n" + rows)
    assert spectrum.values["path_thermal"] == pytest.approx(1e4 * THERMAL, rel=1e-6)


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        (radiance_tape7().replace("0.81200000", "0.812x0000"), ":5:10:", "'0.812x0000' as transmittance"),
        (radiance_tape7().replace("0.81200000", "          "), ":5:", "has no transmittance"),
        (radiance_tape7().replace("0.81200000", "1.20000000"), ":5:", "found 1.2 as transmittance"),
        (radiance_tape7().replace(" 1002.00", "  999.00"), ":6:", "rise or fall"),
        (radiance_tape7().replace("TOT_TRANS", "ELSE_HERE"), ":3:", "FREQ or WAVLEN"),
        ("\n".join(radiance_tape7().splitlines()[:4]), ":", "less than 2 rows"),
        ("a,b\n1,2\n3,4\n5,6\n", ":1:", "tape7 of MODTRAN"),
        ("wavenumber[1/mm],transmittance\n1,1\n2,1\n", ":1:1:", "unit '1/mm'"),
        ("wavenumber[cm^-1],path_thermal[K]\n1,1\n2,1\n", ":1:19:", "unit 'K' of path_thermal"),
    ],
)
def test_what_cannot_be_read_is_refused_at_its_place(tmp_path, text, place, message):
    with pytest.raises(InputError) as caught:
        read(tmp_path, text)
    assert message in str(caught.value)
    assert f"tape7{place}" in str(caught.value)


def test_stored_shares_of_a_channel_are_near_the_exact_ones_and_sum_to_one():
    exact = np.random.default_rng(5).dirichlet(np.ones(12), 40)
    stored = _rounded_shares(exact)
    assert stored.sum(axis=1) == pytest.approx(1.0, abs=1e-12)
    assert 0 < np.abs(stored - exact).max() < 5e-4 and np.median(np.abs(stored - exact)) < 3.1e-5
