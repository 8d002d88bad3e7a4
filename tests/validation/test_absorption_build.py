"""`mat lines build` end to end on one interval of real lines: resume, content, same bytes."""

import pytest
from click.testing import CliRunner

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.commands.lines import command

pytestmark = [pytest.mark.validation, pytest.mark.shared_data]

pytest.importorskip("numba")
pytest.importorskip("hapi")


def test_build_resumes_and_repeats(shared_data, tmp_path):
    arguments = ["build", "--lines", str(shared_data / "lines"), "--continua", str(shared_data / "continua")]
    arguments += ["--wavenumber", "2500:2510", "--points", "8", "--parts", str(tmp_path / "parts")]
    first, second = tmp_path / "first.h5", tmp_path / "second.h5"
    CliRunner().invoke(command, [*arguments, "--out", str(first)], catch_exceptions=False)
    parts = {path: path.stat().st_mtime_ns for path in (tmp_path / "parts").iterdir()}
    assert len(parts) == 2
    one = sorted(parts)[0]
    one.write_bytes(one.read_bytes()[:1000])  # a part that a crash left behind is built again
    CliRunner().invoke(command, [*arguments, "--out", str(second)], catch_exceptions=False)
    assert sorted(parts)[1].stat().st_mtime_ns == parts[sorted(parts)[1]]
    assert first.read_bytes() == second.read_bytes()
    table = AbsorptionTable.open(second)
    assert table.coverage == [(2500.0, 2510.0)] and table.size <= 16
    assert table.error[:, 0].max() < 0.01
