"""The style of charts: names beside lines, apart and within the chart; hours, compass, colours."""

import colorsys
import itertools

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from skyshine.schemas.chart_style import (
    COLOURS,
    chart_style,
    compass,
    hours_of_day,
    name_lines,
    new_figure,
    save_figure,
    spread,
)
from skyshine.schemas.errors import InputError


def test_spread_keeps_order_gap_and_limits_and_moves_least():
    wanted = [0.0, 0.02, 0.5, 0.99, 1.0, 1.0]
    rows = spread(wanted, 0.1, (0.0, 1.0))
    assert np.diff(rows).min() >= 0.1 - 1e-9 and rows[0] >= 0 and rows[-1] <= 1 + 1e-9
    assert rows[2] == 0.5  # nothing is near
    rng = np.random.default_rng(1)
    for _ in range(20):
        wanted = np.sort(rng.uniform(0, 1, 6))
        rows = np.array(spread(list(wanted), 0.15))
        moved = np.sum((rows - wanted) ** 2)
        for _ in range(50):
            other = rows + rng.normal(0, 0.02, 6)
            if np.diff(other).min() >= 0.15:
                assert np.sum((other - wanted) ** 2) >= moved - 1e-9


def test_names_stand_beside_the_ends_of_their_lines():
    with chart_style():
        figure = new_figure(6, 4)
        axis = figure.add_subplot()
        axis.plot([0, 1], [0, 10], label="up")
        axis.plot([0, 1], [10, 0], label="down")
        axis.plot([0, 0.5, 1], [3, 5, np.nan], label="short")
        axis.axhline(2.0)
        axis.axhline(8.0, color=COLOURS[3], label="level")
        axis.set_xlim(0, 1)
        name_lines(axis)
    texts = {text.get_text(): text for text in axis.texts}
    assert set(texts) == {"up", "down", "short", "level"}
    heights = {name: text.get_position()[1] for name, text in texts.items()}
    assert heights["down"] < heights["short"] < heights["level"] < heights["up"]
    assert texts["short"].xy[0] == pytest.approx(0.5)
    assert {text.arrow_patch.get_edgecolor()[:3] for text in texts.values()} == {to_rgb(c) for c in COLOURS[:4]}


def test_limits_that_are_not_settled_yet_and_logarithms_do_not_move_names():
    """Autoscaling waits for the first drawing: names computed before it stood elsewhere."""
    with chart_style():
        figure = new_figure(6, 4)
        axis = figure.add_subplot()
        axis.semilogy([0, 1], [1e-3, 1e3], label="a")
        axis.semilogy([0, 1], [1.0, 1.0], label="b")
        axis.set_xlim(0, 1)
        name_lines(axis)
    (height,) = (text.get_position()[1] for text in axis.texts if text.get_text() == "b")
    assert height == pytest.approx(0.5, abs=0.01)


def test_hours_are_in_threes_and_faces_by_the_compass():
    axis = new_figure(5, 4).add_subplot()
    hours_of_day(axis)
    compass(axis)
    assert [text.get_text() for text in axis.get_xticklabels()] == [
        "00",
        "03",
        "06",
        "09",
        "12",
        "15",
        "18",
        "21",
        "24",
    ]
    assert [text.get_text() for text in axis.get_yticklabels()][:3] == ["N", "NE", "E"]
    hours_of_day(axis, 20.0, 29.0)
    assert [text.get_text() for text in axis.get_xticklabels()] == ["21", "24", "03"]


def test_lines_differ_in_hue_or_lightness_and_by_dashes_beyond_the_colours():
    tones = [colorsys.rgb_to_hls(*to_rgb(colour))[:2] for colour in COLOURS]
    assert all(np.hypot(a[0] - b[0], a[1] - b[1]) > 0.02 for a, b in itertools.combinations(tones, 2))
    with chart_style():
        looks = [(each["color"], str(each["linestyle"])) for each in matplotlib.rcParams["axes.prop_cycle"]]
    assert len(set(looks)) == len(looks) == 18
    assert matplotlib.rcParams["axes.grid"] is False  # others' charts keep their style


def test_a_picture_that_cannot_be_written_is_named(tmp_path):
    with pytest.raises(InputError, match=r"none.chart.png: cannot be written: No such file or directory; check"):
        save_figure(new_figure(2, 2), tmp_path / "none" / "chart.png")
    with pytest.raises(InputError, match="chart.xyz: cannot be written: "):
        save_figure(new_figure(2, 2), tmp_path / "chart.xyz")
