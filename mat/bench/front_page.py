"""A front as one HTML page that needs no other file and prints on A4."""

from __future__ import annotations

from typing import Any

from skyshine.mat.bench.charts import Bar, Mark, front_chart, seconds_text, stage_chart, symbol
from skyshine.mat.bench.rungs import STAGES
from skyshine.mat.budget.page import template
from skyshine.schemas.quantity import short

MOST_BANDS = 3  # with a column of their own; the JSON has all
_TEMPLATE = "front.html.j2"
KEYS = {
    "circle": "tolerance of the pixel in kelvin, built; open: modelled",
    "diamond": "the job as written, ringed",
}


def render(front: dict[str, Any]) -> str:
    """Write the page of a front.

    Parameters
    ----------
    front : dict
        Description from `front.describe`.

    Returns
    -------
    str
        HTML with style and charts inside.
    """
    charts = {"front": "", "stages": ""}
    if front["rungs"]:
        reference = front["rungs"][0]
        charts["front"] = front_chart(_marks(front["rungs"]), reference["error"]["units"], reference["floor"]["value"])
        charts["stages"] = stage_chart(_bars(front["rungs"]), STAGES)
    keys = [(symbol(shape), words) for shape, words in KEYS.items()]
    page = template(__package__, _TEMPLATE, {"short": short, "spread": _spread, "seconds": seconds_text})
    bands = front["rungs"][0]["by_band"][:MOST_BANDS] if front["rungs"] else []
    return page.render(front=front, charts=charts, keys=keys, stages=STAGES, bands=bands)


def _spread(values: list[float]) -> str:
    """The least and the most of some values, or the only one."""
    low, high = short(min(values)), short(max(values))
    return low if low == high else f"{low}\u2013{high}"


def _megabytes(rung: dict[str, Any]) -> str:
    return f"{rung['size']['value'] / 1e6:.3g} MB"


def _marks(rungs: list[dict[str, Any]]) -> list[Mark]:
    largest = max(rung["size"]["value"] for rung in rungs)
    return [
        Mark(
            f"{rung['name']}, {_megabytes(rung)}",
            "diamond" if rung["chosen"] else "circle",
            rung["time"]["value"],
            rung["time"]["value"] - min(rung["uncertainty"]["value"], 0.9 * rung["time"]["value"]),
            rung["time"]["value"] + rung["uncertainty"]["value"],
            max(rung["error"]["value"], 1e-6),
            rung["size"]["value"] / largest,
            not rung["modelled"],
            rung["on_the_front"],
        )
        for rung in rungs
    ]


def _bars(rungs: list[dict[str, Any]]) -> list[Bar]:
    return [
        Bar(
            rung["name"],
            [rung["stages"][name]["value"] for name in STAGES],
            f"{short(rung['time']['value'])} s, {short(rung['error']['value'])} {rung['error']['units']}",
        )
        for rung in rungs
    ]
