"""``mat spectrum`` against line by line: 5 km of tropical air at sea level, each gas by itself."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from skyshine.mat.cli import main

REFERENCE = Path(__file__).parents[3] / "data" / "line_by_line_tropical_5km.csv"
LIMIT = 0.003  # rms per 5 cm^-1 interval


@pytest.fixture(scope="module")
def reference():
    lines = [line for line in REFERENCE.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


@pytest.mark.parametrize(
    "gas",
    ["CH4", "H2O_continuum", *(pytest.param(gas, marks=pytest.mark.validation) for gas in ("H2O", "CO2"))],  # 2 s each
)
def test_each_gas_agrees_through_the_command(gas, reference, capsys):
    place = "--profile tropical --co2-ppm 330 --altitude 0 --elevation 0 --range 5 --wavenumber 700:1250 --json"
    place += " --water-continuum mt_ckd_4.3"
    with pytest.raises(SystemExit) as stop:
        main.main(["spectrum", *place.split()])
    shown = json.loads(capsys.readouterr().out)
    assert stop.value.code == 0
    middle = (reference["low[cm-1]"] + reference["high[cm-1]"]) / 2
    np.testing.assert_allclose(shown["wavenumber"]["values"], middle)
    error = np.array(shown["transmittance_by_gas"][gas]["values"]) - reference[gas]
    assert np.sqrt(np.mean(error**2)) <= LIMIT
