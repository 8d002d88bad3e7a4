"""Charts of a front as SVG text: error against seconds, seconds by stage, seconds beside peers.

Colours are those of the project, which colour-blind readers can distinguish; shapes of marks differ too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise

from skyshine.schemas.chart_style import BLACK, BLUE, ORANGE, PURPLE, SKY, VERMILLION, YELLOW

GREY, PALE = "#8A8A8A", "#DDDDDD"
WIDTH = 720.0  # width of every chart, in units of its own
_FINE = tuple(digit / 10 for digit in range(10, 100, 2))  # where all values lie close together
_LETTER, _LINE = 5.6, 12.0  # room of a letter and of a line of text of 10 units
_LEFT, _RIGHT, _TOP, _BOTTOM = 56.0, 14.0, 12.0, 40.0  # margins, px


@dataclass(frozen=True)
class Mark:
    """A point of the front.

    Attributes
    ----------
    shape : {'circle', 'diamond'}
    x, low, high, y : float
        Seconds, their least and most, and the error.
    weight : float
        0 to 1, by which its area grows.
    built : bool
        Filled; otherwise its time is modelled, and it is open.
    on_front : bool
        No other is better; joined by a line.
    """

    label: str
    shape: str
    x: float
    low: float
    high: float
    y: float
    weight: float
    built: bool
    on_front: bool


@dataclass(frozen=True)
class Bar:
    """A row of stages: seconds of each, and what is written at its ends."""

    label: str
    parts: Sequence[float]
    total: str


Box = tuple[float, float, float, float]
_COLOURS = {"circle": BLUE, "diamond": VERMILLION, "triangle": PURPLE}
_STAGES = (BLUE, ORANGE, VERMILLION, SKY, BLACK, YELLOW, "#BBBBBB")


def front_chart(marks: Sequence[Mark], units: str, floor: float = 0.0, height: float = 235.0) -> str:
    """Error against seconds, both logarithmic, the points that no other beats joined.

    Parameters
    ----------
    marks : sequence of Mark
        Marks of the chart, at least one.
    units : str
        Units of the error.
    floor : float
        Error of means over the band in exact tables, drawn where it is within the chart.
    """
    across = _Scale.of([value for mark in marks for value in (mark.low, mark.high)], _LEFT, WIDTH - _RIGHT)
    errors = [mark.y for mark in marks]
    # A floor far below all errors would leave them little room.
    up = _Scale.of([*errors, *([floor] if floor > min(errors) / 3 else [])], height - _BOTTOM, _TOP)
    parts = [_axes(across, up, height, units)]
    boxes = []
    if floor > 0 and _TOP < up(floor) < height - _BOTTOM:
        parts.append(_line(_LEFT, up(floor), WIDTH - _RIGHT, up(floor), BLACK, dashes="5 4"))
        boxes.append((_LEFT, up(floor) - 1, WIDTH - _RIGHT, up(floor) + 1))
    front = sorted((mark.x, mark.y) for mark in marks if mark.on_front)
    line = " ".join(f"{across(x):.1f},{up(y):.1f}" for x, y in front)
    parts.append(f'<polyline points="{line}" fill="none" stroke="{GREY}" stroke-width="1.5"/>')
    boxes += [_around(across(mark.x), up(mark.y), _radius(mark) + 1) for mark in marks]
    boxes += [(across(mark.low), up(mark.y) - 1, across(mark.high), up(mark.y) + 1) for mark in marks]
    for start, end in pairwise(front):
        # Labels stay off the line, here and there along it.
        (x, y), (dx, dy) = [(across(seconds), up(error)) for seconds, error in (start, end)]
        centres = ((x + share * (dx - x), y + share * (dy - y)) for share in (0.25, 0.5, 0.75))
        boxes += [_around(*centre, 2.0) for centre in centres]
    for mark in marks:
        x, y, radius = across(mark.x), up(mark.y), _radius(mark)
        parts.append(_line(across(mark.low), y, across(mark.high), y, BLACK))
        parts.append(_shape(mark.shape, x, y, radius, filled=mark.built))
        if mark.shape == "diamond":
            parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius + 5:.1f}" fill="none" stroke="{BLACK}"/>')
        ends = across(mark.low), across(mark.high)
        box = _room(mark, x, y, radius + (7 if mark.shape == "diamond" else 1), ends, boxes, height)
        boxes.append(box)
        parts.append(_text(box[0], box[3] - 3, mark.label, bold=mark.shape == "diamond"))
    return _svg("".join(parts), height, f"Error of a pixel, {units}, against processor seconds")


def stage_chart(bars: Sequence[Bar], stages: Sequence[str]) -> str:
    """Seconds of each row by stage, as bars on one scale."""
    margin, right, row = 84.0, 120.0, 13.5
    longest = max(sum(bar.parts) for bar in bars)
    unit = (WIDTH - margin - right) / longest
    parts, x = [], margin
    for stage, colour in zip(stages, _STAGES, strict=True):
        parts.append(_rectangle(x, 3, 9, 9, colour))
        parts.append(_text(x + 12, 11, stage))
        x += 26 + _LETTER * len(stage)
    for number, bar in enumerate(bars):
        x, y = margin, 20 + row * number
        parts.append(_text(margin - 6, y + 9, bar.label, anchor="end"))
        for seconds, colour in zip(bar.parts, _STAGES, strict=True):
            parts.append(_rectangle(x, y, seconds * unit, 11, colour))
            x += seconds * unit
        parts.append(_text(x + 5, y + 9, bar.total))
    return _svg("".join(parts), 22 + row * len(bars), "Processor seconds by stage")


def symbol(shape: str) -> str:
    """One mark, for the key beside a chart."""
    drawn = _shape(shape, 7, 7, 5)
    return f'<svg class="key" viewBox="0 0 14 14" width="12" height="12" aria-hidden="true">{drawn}</svg>'


@dataclass(frozen=True)
class _Scale:
    """A logarithmic axis between two places of a chart."""

    low: float
    high: float
    start: float
    end: float

    @classmethod
    def of(cls, values: Sequence[float], start: float, end: float) -> _Scale:
        """Around positive values, with some room beside them."""
        low, high = min(values), max(values)
        room = max((high / low) ** 0.07, 1.12)
        return cls(math.log(low / room), math.log(high * room), start, end)

    def __call__(self, value: float) -> float:
        return self.start + (math.log(value) - self.low) / (self.high - self.low) * (self.end - self.start)

    @property
    def ticks(self) -> list[float]:
        """Round numbers, about five to nine."""
        decades = range(math.floor(self.low / math.log(10)), math.ceil(self.high / math.log(10)) + 1)
        for digits in ((1,), (1, 3), (1, 2, 5), (1, 1.5, 2, 3, 4, 5, 7), _FINE):
            ticks = [digit * 10.0**decade for decade in decades for digit in digits]
            ticks = [tick for tick in ticks if self.low <= math.log(tick) <= self.high]
            if len(ticks) >= 4:
                break
        return ticks[:: math.ceil(len(ticks) / 9)]


def _axes(across: _Scale, up: _Scale, height: float, units: str) -> str:
    parts = []
    for tick in across.ticks:
        x = across(tick)
        parts.append(_line(x, _TOP, x, height - _BOTTOM, PALE))
        parts.append(_text(x, height - _BOTTOM + 13, f"{tick:g}", anchor="middle"))
    for tick in up.ticks:
        y = up(tick)
        parts.append(_line(_LEFT, y, WIDTH - _RIGHT, y, PALE))
        parts.append(_text(_LEFT - 5, y + 3.5, f"{tick:g}", anchor="end"))
    parts.append(
        f'<rect x="{_LEFT}" y="{_TOP}" width="{WIDTH - _LEFT - _RIGHT}" height="{height - _TOP - _BOTTOM}"'
        f' fill="none" stroke="{GREY}"/>'
    )
    parts.append(
        _text((_LEFT + WIDTH - _RIGHT) / 2, height - 8, "processor seconds of the whole build", anchor="middle")
    )
    middle = (_TOP + height - _BOTTOM) / 2
    label = _text(14, middle, f"error of a pixel, 99 % within, {units}", anchor="middle")
    parts.append(f'<g transform="rotate(-90 14 {middle:.1f})">{label}</g>')
    return "".join(parts)


def _line(x: float, y: float, to_x: float, to_y: float, colour: str, dashes: str = "none") -> str:
    coordinates = f'x1="{x:.1f}" y1="{y:.1f}" x2="{to_x:.1f}" y2="{to_y:.1f}"'
    return f'<line {coordinates} stroke="{colour}" stroke-dasharray="{dashes}"/>'


def _rectangle(x: float, y: float, width: float, height: float, colour: str) -> str:
    return (
        f'<rect x="{x:.2f}" y="{y:.1f}" width="{width:.2f}" height="{height:g}" fill="{colour}" stroke="#fff"'
        ' stroke-width=".5"/>'
    )


def _radius(mark: Mark) -> float:
    return 3.5 + 5.0 * math.sqrt(mark.weight)


def _shape(shape: str, x: float, y: float, radius: float, *, filled: bool = True) -> str:
    colour = _COLOURS[shape]
    style = f'fill="{colour if filled else "#fff"}" stroke="{colour}" stroke-width="1.5"'
    if shape == "circle":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" {style}/>'
    corners = {
        "diamond": [(0, -1.2), (1.2, 0), (0, 1.2), (-1.2, 0)],
        "triangle": [(0, -1.1), (1.0, 0.8), (-1.0, 0.8)],
    }[shape]
    points = " ".join(f"{x + radius * a:.1f},{y + radius * b:.1f}" for a, b in corners)
    return f'<polygon points="{points}" {style}/>'


def _around(x: float, y: float, radius: float) -> Box:
    return x - radius, y - radius, x + radius, y + radius


def _room(
    mark: Mark, x: float, y: float, radius: float, ends: tuple[float, float], occupied: Sequence[Box], height: float
) -> Box:
    """The place of a label beside its mark that covers least of what is drawn."""
    width = (1.12 if mark.shape == "diamond" else 1.0) * _LETTER * len(mark.label) + 2
    after, before, middle = max(x + radius, ends[1]) + 3, min(x - radius, ends[0]) - 3 - width, x - width / 2
    level, above, below = y - _LINE / 2, y - radius - 2 - _LINE, y + radius + 2
    beside = [(after, level), (before, level), (middle, above), (middle, below)]
    diagonal = [(x, y) for x in (after, before) for y in (above, below, above - _LINE, below + _LINE)]
    boxes = [(a, b, a + width, b + _LINE) for a, b in beside + diagonal]

    def covered(box: Box) -> float:
        outside = box[0] < _LEFT or box[2] > WIDTH - _RIGHT or box[1] < _TOP or box[3] > height - _BOTTOM
        return sum(_overlap(box, obstacle) for obstacle in occupied) + (1e4 if outside else 0.0)

    return min(boxes, key=covered)


def _overlap(box: Box, occupied: Box) -> float:
    width = min(box[2], occupied[2]) - max(box[0], occupied[0])
    height = min(box[3], occupied[3]) - max(box[1], occupied[1])
    return max(width, 0.0) * max(height, 0.0)


def seconds_text(value: float) -> str:
    """Seconds as a short number, such as 2 ms."""
    if value >= 1000:
        return f"{value:,.0f} s" if value < 7200 else f"{value / 3600:,.1f} h"
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if value >= 0.999 * size:
            return f"{value / size:.3g} {unit}"
    return f"{value / 1e-9:.3g} ns"


def _text(x: float, y: float, words: str, *, anchor: str = "start", bold: bool = False) -> str:
    weight = ' font-weight="700"' if bold else ""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{weight}>{escape(words)}</text>'


def _svg(content: str, height: float, title: str) -> str:
    return (
        f'<svg viewBox="0 0 {WIDTH:g} {height:g}" role="img" font-size="10" font-family="sans-serif">'
        f"<title>{escape(title)}</title>{content}</svg>"
    )
