"""The bench of atmospheric quantities: its ladders fall, its states keep their air, its figures are those of the files
that it writes.
"""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.bench import lowtran

sys.path.insert(0, str(Path(__file__).parent))
import atmosphere_ladder as bench
from atmosphere import atmosphere


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bench")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bench, "QUICK_BANDS", {"narrow": (11.0, 11.1)})
        patch.setattr(bench, "POINTS", (2, 8))
        patch.setattr(bench, "DIRECTIONS", (2, 8))
        patch.setattr(bench, "STREAMS", (2, 6))
        patch.setattr(bench, "_MOST_NODES", 10)
        done = CliRunner().invoke(atmosphere, ["--quick", "--json", "--out", str(folder)], catch_exceptions=False)
    found = json.loads(done.stdout)
    assert found == json.loads((folder / "atmosphere-bench.json").read_text(encoding="utf-8"))
    assert (folder / "atmosphere-bench.png").read_bytes()[:4] == b"\x89PNG"
    return found


@pytest.mark.validation  # 9 s
def test_what_is_finer_errs_less(result):
    for rungs in result["bands"]["narrow"]["ladders"].values():
        coarse, fine = rungs[0]["errors_rms"], rungs[-1]["errors_rms"]
        assert all(0 < fine[kind]["value"] < coarse[kind]["value"] for kind in fine)


def test_more_and_fewer_levels_hold_the_same_air():
    state = AtmosphericState.from_profile("us_standard", aerosol=Aerosol("none"))
    fine = bench.halved(state)
    np.testing.assert_array_equal(bench.thinned(fine, np.arange(0, fine.altitude.size, 2)).altitude, state.altitude)
    column = [one._column(one.number_density, 0.0) for one in (state, fine)]
    assert column[1] == pytest.approx(column[0], rel=1e-3)


def test_the_peer_reads_the_source_of_light_from_its_cards():
    state = bench.thinned(AtmosphericState.from_profile("us_standard", aerosol=Aerosol("none")), [0, 5, 10])
    dark, lit = (lowtran.Sight(0.0, 30.0, 5e3, sun=sun) for sun in (None, (40.0, 25.0)))
    cards = [lowtran._cards(state, sight, 800.0, 900.0, 1, lowtran.Haze()).splitlines() for sight in (dark, lit)]
    assert [int(lines[0][10:15]) for lines in cards] == [1, 2] and [int(lines[0][15:20]) for lines in cards] == [0, 1]
    assert len(cards[1]) == len(cards[0]) + 2
    assert [float(cards[1][-3][k : k + 10]) for k in (0, 10)] == [25.0, 50.0]  # azimuth, zenith angle
