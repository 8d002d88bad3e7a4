"""The front of a job: what the next second and the next kelvin buy, and the page that shows it."""

import copy
import itertools
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from skyshine.mat.bench.charts import _LETTER, Mark, front_chart, seconds_text
from skyshine.mat.bench.front import _one_line, unbeaten
from skyshine.mat.bench.front_page import render
from skyshine.mat.bench.front_sentences import sentences
from skyshine.mat.bench.rungs import STAGES
from skyshine.schemas.documents import MAPPING
from skyshine.schemas.errors import InputError
from skyshine.schemas.quantity import quantity


def rung(name, seconds, error, **settings):
    return {
        "name": name,
        "asked": quantity(1.0, "K"),
        "chosen": False,
        "error": quantity(error, "K"),
        "rms": quantity(error / 3, "K"),
        "maximum": quantity(error * 2, "K"),
        "time": quantity(seconds, "s"),
        "modelled": False,
        "uncertainty": quantity(0.1 * seconds, "s"),
        "wall_time": quantity(seconds, "s"),
        "stages": dict.fromkeys(STAGES, quantity(seconds / len(STAGES), "s")),
        "size": quantity(1e6 / error, "byte"),
        "floor": quantity(0.15, "K"),
        "by_band": [
            {"wavelength": quantity([8.0, 12.0], "um"), "error": quantity(error / 2, "K"), "floor": quantity(0.07, "K")}
        ],
        "sets": [],
        "on_the_front": True,
    } | settings


@pytest.fixture
def rungs():
    return [
        rung("5 K", 10.0, 2.0),
        rung("1 K", 20.0, 1.0),
        rung("as written", 30.0, 1.5, chosen=True, on_the_front=False),
        rung("0.1 K", 60.0, 0.2),
    ]


@pytest.fixture
def front(rungs):
    peer = {
        "peer": "LOWTRAN7",
        "work": "a line of sight, 8-12 um",
        "error": quantity(0.01, "1"),
        "time": quantity(0.5, "s"),
        "time_of_this_job": quantity(1e-5, "s"),
        "note": "1 point beside steps of 5 cm^-1",
    }
    return {
        "job": "a <wall> & more",
        "method": "how",
        "rungs": rungs,
        "parts": [
            {
                "part": "half the <nodes>",
                "key": "atmosphere_grid.tolerance",
                "error": quantity(1.7, "K"),
                "rms": quantity(0.6, "K"),
                "saved": quantity(3.0, "s"),
            }
        ],
        "cannot_run": {"0.01 K": "no affordable grid <meets> it"},
        "sentences": sentences(rungs, "K"),
        "peers": [peer],
        "absent": {"PythonicDISORT": "it is not <installed>"},
    }


def test_a_reason_names_no_file_that_is_not_there():
    in_setting, in_image = (InputError("found '5 K'", file=Path("jobs") / file) for file in (MAPPING, "wall.png"))
    assert _one_line(in_setting) == "found '5 K'"
    assert "wall.png" in _one_line(in_image)


def test_points_that_none_beats():
    assert unbeaten([(1, 5), (2, 3), (2, 4), (3, 3), (4, 1)]) == [True, True, False, False, True]


def test_a_job_off_the_front_is_told_what_beats_it_and_what_the_next_second_and_kelvin_buy(rungs):
    _, own, second, kelvin, floor = sentences(rungs, "K")
    assert "1.5 K in 30 s" in own and "1 K beats it with 1 K in 20 s" in own
    assert "from 1 K to 0.1 K" in second and "for 40 s more, 0.02 K a second" in second  # 0.8 K in 40 s
    assert "5 K errs 1 K more and saves 10 s, 10 s a kelvin" in kelvin
    assert "0.2 K, has 0.1 K" in floor and "0.15 K" in floor


def test_the_headline_names_the_cheapest_setting_that_errs_little_more_than_the_best(rungs):
    assert sentences(rungs, "K")[0].startswith("Set accuracy: 0.1 K: 99 % of the pixels of this scene are within 0.2 K")
    rungs[2]["error"], rungs[3]["error"] = quantity(0.21, "K"), quantity(0.2, "K")
    assert sentences(rungs, "K")[0].startswith("Leave the accuracy of the job as it is written: 99 %")
    cheap = rung("3 K", 12.0, 0.215, modelled=True)
    headline = sentences([cheap, *rungs], "K")[0]
    assert (
        "Set accuracy: 3 K" in headline
        and "by the model" in headline
        and "least error of all settings is 0.2 K" in headline
    )


def test_a_job_on_the_front_starts_from_its_own_point(rungs):
    rungs[1]["chosen"], rungs[2]["chosen"] = True, False
    _, own, second, kelvin, _ = sentences(rungs, "K")
    assert "no other setting beats it" in own and "from 1 K to 0.1 K" in second and "5 K errs" in kelvin


def test_the_ends_of_the_front_say_that_nothing_is_to_be_had():
    alone = [rung("as written", 3.0, 1.0, chosen=True)]
    _, own, second, kelvin, _ = sentences(alone, "K")
    assert "no other setting beats it" in own and "no further" in second and "no time" in kelvin
    assert len(sentences([], "K")) == 1


def test_a_job_that_could_not_be_built_is_said_and_the_front_begins_at_its_cheapest(rungs):
    _, own, second, *_ = sentences([one for one in rungs if not one["chosen"]], "K")
    assert "could not be built" in own and "from 5 K to 1 K" in second


def test_points_that_are_the_same_buy_nothing():
    twins = [rung("as written", 3.0, 1.0, chosen=True), rung("1 K", 3.0, 1.0)]
    assert len(sentences(twins, "K")) == 5


def test_the_page_needs_nothing_else_and_shows_every_setting(front):
    page = render(front)
    for foreign in ("http:", "https:", "src=", "<script", "@import", "url("):
        assert foreign not in page
    assert "@page" in page and "size: A4" in page
    for name in ("5 K", "1 K", "as written", "0.1 K"):
        assert f"<td>{name}" in page
    assert "a &lt;wall&gt; &amp; more" in page and "<wall>" not in page
    assert "0.01 K cannot run" in page and "no affordable grid &lt;meets&gt; it" in page
    assert re.search(r"exact tables</td><td>0.15</td><td>0.07</td>", page)
    assert "half the &lt;nodes&gt;" in page and "20 ± 2" not in page
    assert "PythonicDISORT is absent: it is not &lt;installed&gt;" in page
    assert re.search(r"LOWTRAN7</td><td>0.01 </td><td>500 ms</td><td>10 µs</td>", page)


def test_a_modelled_setting_is_named_with_its_uncertainty_and_an_open_mark(front):
    front["rungs"][1]["modelled"] = True
    page = render(front)
    assert "1 K, modelled" in page and "20 ± 2" in page
    chart = next(picture for picture in re.findall(r"<svg.*?</svg>", page, re.DOTALL) if "against processor" in picture)
    assert chart.count(' fill="#fff" stroke=') == 1


def test_a_page_without_any_setting_names_the_reasons(front):
    empty = front | {"rungs": [], "peers": [], "parts": [], "sentences": sentences([], "K")}
    page = render(empty)
    assert "0.01 K cannot run" in page and "<table" not in page


def test_pictures_are_well_formed_and_shapes_differ_as_colours_do(front):
    pictures = re.findall(r"<svg.*?</svg>", render(front), re.DOTALL)
    for picture in pictures:
        ElementTree.fromstring(picture)
    chart = next(picture for picture in pictures if "against processor seconds" in picture)
    assert chart.count('fill="#fff" stroke="#0072B2"') == 0
    assert chart.count("<circle") == 4 and chart.count("<polygon") == 1  # three settings, the ringed job


def labels_of(chart):
    """Boxes of the bold and plain labels of marks, from their texts."""
    found = re.findall(r'<text x="([\d.]+)" y="([\d.]+)" text-anchor="start"[^>]*>([^<]+)</text>', chart)
    return [(float(x), float(y) - 9, float(x) + _LETTER * len(words), float(y) + 3) for x, y, words in found]


def test_labels_of_a_crowded_front_neither_overlap_nor_leave_the_chart():
    marks = [
        Mark(f"{number}.5 K, 12.3 MB", "circle", x, 0.95 * x, 1.05 * x, 3 * 0.7**number, 0.5, True, True)
        for number, x in enumerate(20 * 1.12**step for step in range(11))
    ]
    boxes = labels_of(front_chart(marks, "K"))
    assert len(boxes) == len(marks)
    for one, other in itertools.combinations(boxes, 2):
        apart = one[2] <= other[0] or other[2] <= one[0] or one[3] <= other[1] or other[3] <= one[1]
        assert apart, (one, other)
    assert all(box[0] >= 56 and box[2] <= 720 for box in boxes)


def test_a_single_point_has_axes():
    chart = front_chart([Mark("as written", "diamond", 3.0, 3.0, 3.0, 0.5, 1.0, True, True)], "K")
    ElementTree.fromstring(chart)
    assert "nan" not in chart and "inf" not in chart


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (2e-8, "20 ns"),
        (2.94e-5, "29.4 µs"),
        (0.0151, "15.1 ms"),
        (17.7, "17.7 s"),
        (4210.0, "4,210 s"),
        (9072.0, "2.5 h"),
    ],
)
def test_seconds_are_short_and_readable(seconds, words):
    assert seconds_text(seconds) == words


def test_rendering_changes_nothing(front):
    before = copy.deepcopy(front)
    render(front)
    assert front == before
