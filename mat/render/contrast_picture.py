"""The contrast of two materials through the day as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from skyshine.mat.job.fields import clock_text
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.render.contrast import Contrast
from skyshine.schemas.chart_style import BLACK, GREEN, chart_style, hours_of_day, name_lines, new_figure, save_figure


def draw_contrast(results: Sequence[Contrast], material: str, background: str, picture: Path) -> Path:
    """Draw apparent temperatures and their difference in each band, with the crossovers.

    Raises
    ------
    InputError
        The picture cannot be written.
    """
    with chart_style():
        figure = new_figure(6.4 * len(results) + 0.4, 5.2)
        axes = figure.subplots(2, len(results), squeeze=False, sharex=True)
        for column, result in enumerate(results):
            upper, lower = axes[:, column]
            upper.plot(result.hours, result.material - ZERO_CELSIUS, label=material)
            upper.plot(result.hours, result.background - ZERO_CELSIUS, label=background)
            upper.set(title=result.band, ylabel="apparent temperature, °C")
            lower.axhline(0.0, color=BLACK, lw=0.8)
            lower.plot(result.hours, result.contrast, color=GREEN, label="difference")
            for hour in result.crossovers:
                lower.axvline(hour, color=BLACK, lw=0.8, ls="--")
                text = clock_text(round(hour * 60) / 60 % 24)
                lower.annotate(text, (hour, 1.0), xycoords=("data", "axes fraction"), fontsize=8, rotation=90, va="top")
            hours_of_day(lower)
            lower.set_ylabel("contrast, K")
        for axis in axes[0]:
            name_lines(axis)
        return save_figure(figure, picture)
