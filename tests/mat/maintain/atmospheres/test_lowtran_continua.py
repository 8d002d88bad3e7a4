"""The program that derives LOWTRAN7's continua from a Fortran source."""

import numpy as np
import pytest

pytest.importorskip("numba")

from click.testing import CliRunner

from mat.maintain.atmospheres import lowtran_continua
from skyshine import atmospheres


def block(unit, arrays):
    rows = [f"      BLOCK DATA {unit}"]
    for name, values in arrays.items():
        rows.append(f"      DATA {name} /")
        texts = [f"{value:.4E}" for value in values]
        rows += [
            f"     C {', '.join(texts[i : i + 5])}{',' if i + 5 < len(texts) else '/'}" for i in range(0, len(texts), 5)
        ]
    return "\n".join([*rows, "      END", ""])


@pytest.fixture
def source(tmp_path):
    """A source with tables of the form of LOWTRAN7's, from -20 to 30 cm-1 for water vapour."""
    water = {"SF296": [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "SF260": [2.0, 4.0, 6.0, 8.0, 15.0, 12.0]}
    text = ""
    for unit, values in water.items():
        text += block(unit, {"V1": [-20.0], "S0000": values[:2], "S0001": values[2:]})
    text += block("BFH2O", {"V1": [-20.0], "F0000": [0.1, 0.2], "F0001": [0.3, 0.4, 0.5, 0.6]})
    text += block("C4D", {"C401": np.arange(1, 115), "C4115": np.arange(115, 134), "C8": [1.0]})
    oxygen = {"V1O2": [1395.0], "V2O2": [1400.0], "DVO2": [5.0], "NPTO2": [2.0]}
    text += block("BO2C", {**oxygen, "O2S0": [0.0, 1e-6], "O2A": [0.0, 1e-3], "O2B": [0.0, 2e-5]})
    file = tmp_path / "lowtran7.f"
    file.write_text(text, encoding="ascii")
    return file


def columns_and_rows(file):
    head, *rows = [line for line in file.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    return head, np.loadtxt(rows, delimiter=",")


def test_tables_start_at_zero_wavenumber_and_keep_their_order(source):
    wavenumber, self_continuum, foreign, exponent = lowtran_continua.water_vapour(source)
    assert wavenumber.tolist() == [0, 10, 20, 30]
    unit = 1e-24 * 1013 / 1013.25
    # The correction of SUBROUTINE TRANS at 0 cm-1 is 1 - 0.2333 / (1 + 5.25^2) = 0.99183.
    assert self_continuum[0] == pytest.approx(3.0 * 0.99183 * unit, rel=1e-5, abs=0)
    assert foreign[0] == pytest.approx(0.3 * unit, rel=1e-6, abs=0)
    assert (296 / 260) ** exponent == pytest.approx([2.0, 2.0, 3.0, 2.0])


def test_the_window_correction_is_as_the_source_says():
    # "FACTOR OF 0.78 @ 1000" (SUBROUTINE TRANS)
    assert lowtran_continua.window_correction(np.array([1000.0]))[0] == pytest.approx(0.78, abs=0.003)
    assert lowtran_continua.window_correction(np.array([1050.0]))[0] == pytest.approx(0.7667, abs=1e-4)


def test_the_far_wings_follow_the_earlier_exponential_and_are_a_hundredth_of_it_at_one_micrometre():
    """SUBROUTINE FUDGE: within 5 % of the original from 0 to 3000 cm-1, 0.01 of it near 10,000 cm-1."""
    wavenumber = np.array([0.0, 1000.0, 2000.0, 3000.0, 10000.0])
    ratio = lowtran_continua.far_wings(wavenumber) / (3.159e-8 * np.exp(-2.75e-4 * wavenumber))
    assert np.all(np.abs(ratio[:4] - 1) < 0.06) and ratio[4] == pytest.approx(0.01, rel=0.1)


def test_the_program_writes_the_three_files_in_the_form_of_the_packaged_ones(source, tmp_path):
    done = CliRunner().invoke(lowtran_continua.main, [str(source), "--out", str(tmp_path)], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    for name in ("lowtran7.csv", "lowtran7_n2.csv", "lowtran7_o2.csv"):
        packaged = atmospheres.path(f"continuum/{name}")
        assert columns_and_rows(tmp_path / name)[0] == columns_and_rows(packaged)[0]
    _, nitrogen = columns_and_rows(tmp_path / "lowtran7_n2.csv")
    assert nitrogen[[0, -1], 0].tolist() == [2080, 2740]
    # 133 per km of air of one atmosphere and 273.15 K.
    assert nitrogen[-1, 1] * 2.6868e25 * 1e3 == pytest.approx(133, rel=1e-6)
