"""The contrast of two materials through the day as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from skyshine.mat.job.fields import clock_text
from skyshine.mat.render.contrast import Contrast
from skyshine.schemas.chart_style import BLACK, GREEN, chart_style, hours_of_day, name_lines, new_figure, save_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_contrast(results: Sequence[Contrast], material: str, background: str, picture: Path) -> Path:
    """Draw apparent temperatures and their difference in each band, with the stated error as a band around it, the
    crossovers, and the night in grey.

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
            upper.plot(result.hours, result.material, label=material)
            upper.plot(result.hours, result.background, label=background)
            upper.set(title="{:g} to {:g} µm".format(*result.wavelength), ylabel="apparent temperature, K")
            lower.axhline(0.0, color=BLACK, lw=0.8)
            step = np.diff(result.hours, prepend=result.hours[0]) > 1.5 * float(np.median(np.diff(result.hours)))
            within = np.where(step, np.nan, result.contrast)  # no band across hours without values
            error = result.stated_error
            lower.fill_between(
                result.hours, within - error, within + error, color=GREEN, alpha=0.25, lw=0, label="_error"
            )
            lower.plot(result.hours, result.contrast, color=GREEN)
            lower.set_title(f"{material} - {background}; band: stated error, {error:.2g} K in 99 %", fontsize=9)
            for axis in (upper, lower):
                _shade_night(axis, result.sun_up)
            for hour in result.crossovers:
                lower.axvline(hour, color=BLACK, lw=0.8, ls="--")
                text = clock_text(round(hour * 60) / 60 % 24)
                lower.annotate(text, (hour, 1.0), xycoords=("data", "axes fraction"), fontsize=8, rotation=90, va="top")
            hours_of_day(lower)
            lower.set_ylabel("contrast, K")
        figure.suptitle(_described(results[0]), fontsize=9, x=0.01, ha="left")
        for axis in axes[0]:
            name_lines(axis)
        return save_figure(figure, picture)


def _shade_night(axis: Axes, sun_up: tuple[float, ...]) -> None:
    """Grey from sunset to sunrise; nothing where the Sun neither rises nor sets."""
    if not sun_up:
        return
    rise, sunset = sun_up
    for begin, end in ((0.0, rise), (sunset, 24.0)) if rise < sunset else ((sunset, rise),):
        axis.axvspan(begin, end, color=BLACK, alpha=0.07, lw=0)


def _described(result: Contrast) -> str:
    """Date, Sun and line of sight in one line."""
    sun = "Sun does not rise or set"
    if result.sun_up:
        sun = "sunrise {}, sunset {}".format(*(clock_text(hour) for hour in result.sun_up))
    sight = result.sight
    return (
        f"{result.date}, {sun}; line of sight: range {sight.range:g} km, elevation {sight.elevation:g}°,"
        f" azimuth {sight.heading:g}°"
    )
