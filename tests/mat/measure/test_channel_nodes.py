"""Where more nodes of tables in channels are placed."""

import numpy as np
import pytest

from skyshine.mat.measure.channel_nodes import _blamed, _by_interval, _growth, placed_channels
from skyshine.mat.quantities.channels.nodes import ChannelNodes, NodeCounts
from skyshine.schemas.errors import CheckFailed


def test_an_interval_errs_as_its_own_reads():
    edges = np.array([0.0, 1.0, 2.0, 3.0])
    at = np.array([0.5, 0.6, 2.5, 9.0, 0.1])
    error = np.array([0.2, 0.4, 1.0, 7.0, np.nan])
    found = _by_interval(edges, at, error)
    assert found[0] == pytest.approx(0.398) and np.isnan(found[1]) and found[2] == 1.0


def test_intervals_grow_with_the_root_of_their_error_and_carry_their_neighbours():
    growth = _growth(np.array([0.01, 0.01, 0.01, 4.0, 0.6, 100.0]))
    assert growth[0] < 1 and growth[1] < 1  # idle
    assert growth[2] == pytest.approx(1.5)  # three quarters of its neighbour's
    assert growth[3] == 2.0 and growth[4] == 4.0 and growth[5] == 4.0
    assert np.all(_growth(np.full(3, np.nan)) == 1)
    assert np.all(_growth(np.array([np.nan, 4.0, np.nan])) == 2.0)


def test_a_read_blames_the_part_that_changes_it_most():
    whole = [{"beta_star": np.array([0.9, 0.0])}]
    thinned = {"share": [{"beta_star": np.array([1.2, 0.0])}], "height_root": [{"beta_star": np.array([0.9, 3.0])}]}
    blamed = _blamed(whole, thinned)
    np.testing.assert_allclose(blamed["share"][0]["beta_star"], [0.9, 0.0])  # all of the error it has
    np.testing.assert_allclose(blamed["height_root"][0]["beta_star"], [0.0, 1.0])  # a third of the change


def test_nodes_crowd_where_intervals_are_asked_for():
    nodes = ChannelNodes.of(NodeCounts(share=5), (0.0, 1.0))
    finer = nodes.with_spacing("share", np.array([0.0, 0.5, 1.0]), np.array([2.0, 6.0]))
    assert finer.share.tolist() == pytest.approx([0, 0.25, 0.5, *(0.5 + np.arange(1, 7) / 12)])
    assert finer.size == nodes.size // 5 * 9 and finer.direction is not None


def test_coarser_tolerances_start_from_fewer_nodes():
    half = NodeCounts().scaled(0.5)
    assert (half.share, half.height, half.ground) == (10, 12, 4) and NodeCounts().scaled(1.0) == NodeCounts()
    assert NodeCounts().scaled(0.01) == NodeCounts(4, 4, 4, 4, 4)


class Lines:
    """Lines of sight on which a table has given errors."""

    def __init__(self, **errors):
        self._errors = {name: np.array(values) for name, values in errors.items()}

    def errors(self, tables, scale):
        return {name: self._errors.get(name, np.zeros(3)) for name in tables}


class Table:
    """What `Lines` read, whatever it has."""

    def clamped(self):
        return self


@pytest.mark.parametrize("path", [[0.0, np.nan, 0.1], [np.nan] * 3])
@pytest.mark.parametrize("first", ["beta_star", "direct_radiance"])
def test_a_read_that_is_not_a_number_holds_no_tolerance(path, first):
    nodes = ChannelNodes.of(NodeCounts(), (0.0, 1.0))
    good, bad = Lines(), Lines(**{first: path})
    kept = placed_channels(lambda _: Table(), [good, good], nodes, None, 1.0, max_nodes=10**6)
    assert kept.nodes is nodes and (kept.p99, kept.largest) == (0.0, 0.0)
    with pytest.raises(CheckFailed, match="cannot be held in channels: .* nan"):
        placed_channels(lambda _: Table(), [bad, good], nodes, None, 1.0, max_nodes=10**6)
