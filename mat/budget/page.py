"""The error budget as one HTML page that needs no other file."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Mapping, Sequence
from importlib import resources
from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine.mat.budget.budget import Budget
from skyshine.mat.budget.frames import FIELDS_OF_VIEW
from skyshine.mat.budget.sizes import kelvin
from skyshine.mat.budget.summary import SLANTS, WHOLE, by_size
from skyshine.schemas.chart_style import BLACK, BLUE, COLOURS, VERMILLION, chart_style, name_lines, new_figure
from skyshine.schemas.quantity import short

if TYPE_CHECKING:
    import jinja2

_TEMPLATE = "report.html.j2"
_LABELS = {"transmittance_extrapolation": "transmittance", "radiance_extrapolation": "path, ambient, direct"}


def render(report: dict[str, Any], budgets: Sequence[Budget]) -> str:
    """Write the page of a report.

    Parameters
    ----------
    report : dict
        Report from `summary.describe_all`.
    budgets : sequence of Budget
        The same, for the plots.

    Returns
    -------
    str
        HTML with style and plots inside.
    """
    filters: dict[str, Callable[..., object]] = {
        "short": short,
        "by_size": by_size,
        "signed": _signed,
        "units": _units,
    }
    page = template(__package__, _TEMPLATE, filters)
    plots = [_plot(described, budget) for described, budget in zip(report["budgets"], budgets, strict=True)]
    pairs = list(zip(report["budgets"], plots, strict=True))
    return page.render(report=report, pairs=pairs, slants=SLANTS, fields=FIELDS_OF_VIEW)


def template(package: str, name: str, filters: Mapping[str, Callable[..., object]]) -> jinja2.Template:
    """A template of a package, whose text is escaped and whose names must all be known."""
    import jinja2

    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters.update(filters)
    return environment.from_string(resources.files(package).joinpath(name).read_text(encoding="utf-8"))


def _signed(value: float) -> str:
    return f"{value:+.2g}".replace("-", "\u2212")


def _units(text: str) -> str:
    return text.replace("^-", "\u207b").replace("\u207b2", "\u207b²").replace("\u207b1", "\u207b¹")


def _plot(described: dict[str, Any], budget: Budget) -> str:
    """Errors by source, by field of view and slant, and by radiance, as SVG."""
    from matplotlib import rc_context

    thermal = np.isfinite(described["errors"]["pixel"]["temperature"]["rms"]["value"] or np.nan)
    key, units = ("temperature", "K") if thermal else ("radiance", "W m$^{-2}$ sr$^{-1}$")
    with chart_style(), rc_context({"svg.hashsalt": "skyshine", "svg.fonttype": "path"}):
        figure = new_figure(11.5, 4.2)
        bars, lines, cloud = figure.subplots(1, 3, width_ratios=(1.3, 1, 1))
        names = by_size(described["errors"])[::-1]
        rms, p99 = ([described["errors"][name][key][measure]["value"] for name in names] for measure in ("rms", "p99"))
        colours = [VERMILLION if name in WHOLE else BLUE for name in names]
        bars.barh(np.arange(len(names)), rms, color=colours)
        bars.plot(p99, np.arange(len(names)), "k|")
        bars.set(xscale="log", yticks=np.arange(len(names)), xlabel=f"rms error, {units}; stroke: 99th percentile")
        bars.set_yticklabels([name.replace("_", " ") for name in names], fontsize=7)
        bars.grid(visible=False, axis="y")
        table = described["extrapolation"]["rms_kelvin" if thermal else "rms"]
        for (name, values), style in zip(table.items(), ("-", ":"), strict=True):
            for (low, high), column, colour in zip(SLANTS, zip(*values["values"], strict=True), COLOURS, strict=False):
                if None not in column:
                    lines.loglog(
                        FIELDS_OF_VIEW, column, style, color=colour, label=f"{_LABELS[name]}, {low:g} to {high:g}°"
                    )
        lines.set(xlabel="field of view, °", ylabel=f"rms of extrapolation, {units}")
        if lines.lines:
            lines.set_xlim(min(FIELDS_OF_VIEW), max(FIELDS_OF_VIEW))
            lines.set_title("by slant from the horizon")
            name_lines(lines)
        error = budget.errors["pixel"]
        cloud.plot(budget.radiance.ravel(), (kelvin(budget, error) if thermal else error).ravel(), ".", ms=3)
        cloud.axhline(0, color=BLACK, lw=0.5)
        cloud.set(xlabel="radiance, W m$^{-2}$ sr$^{-1}$", ylabel=f"error of the pixel, {units}")
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None})
    return re.sub(r"^.*?(?=<svg)", "", text.getvalue(), count=1, flags=re.DOTALL)
