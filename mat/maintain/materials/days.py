"""Draws the day of ten materials with their numbers of an earlier library and with those of today.

Of a library of the history, such as the one before its materials were named for what they are::

    git archive 69f5757 materials | tar x -C BEFORE
    python -m mat.maintain.materials.days BEFORE/materials days.png

Both have today's heat balance, level, under the starter job's sky: what differs are the materials.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np

from skyshine.mat.api.examples import starter_files
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.scene.surface import surface_inputs, surface_materials
from skyshine.mat.surface.column import from_scene
from skyshine.materials.library import ENVIRONMENT, MaterialLibrary, load_library
from skyshine.schemas.arrays import Floats
from skyshine.schemas.chart_style import chart_style, hours_of_day, name_lines, new_figure, save_figure

# Those whose sample was another thing than their name said, and two whose conductivity was wrong.
SHOWN = (
    "galvanised_new",
    "steel_bare",
    "roof_membrane_white",
    "roof_fibre_cement",
    "roof_tile_terracotta",
    "pvc_white",
    "grass_dry",
    "conifer",
    "basalt",
    "asphalt_road",
)
_COLUMNS = 5  # panels in a row


@dataclass(frozen=True, eq=False)
class Day:
    """Surface temperatures of a material before and after, and of the air, at times of the day; (N,) each.

    Attributes
    ----------
    hours : ndarray
        Local clock [h].
    before, after, air : ndarray
        [K]
    """

    name: str
    hours: Floats
    before: Floats
    after: Floats
    air: Floats

    @property
    def change(self) -> tuple[float, float]:
        """The largest change [K], with its sign, and its time [h]."""
        difference = self.after - self.before
        index = int(np.argmax(np.abs(difference)))
        return float(difference[index]), float(self.hours[index])


def days_of(before: MaterialLibrary, after: MaterialLibrary, names: Sequence[str], job: Path) -> list[Day]:
    """The days of materials, level, under the sky of a job's first state."""
    _, (sun, weather, sky) = surface_inputs(job)
    days = []
    for name in names:
        pair = surface_materials([library[name] for library in (before, after)])
        earlier, later = (from_scene(material, sun, weather, sky, sun.altitude, 0.0, 0.0) for material in pair)
        hours = np.array(later.time, float)
        start = np.interp(hours, np.array(earlier.time, float), earlier.temperature, period=24.0)
        clock = np.arange(weather.air_temperature.size) * (24.0 / weather.air_temperature.size)
        air = np.interp(hours, clock, weather.air_temperature, period=24.0)
        days.append(Day(name, hours, start, later.temperature, air))
    return days


def draw(days: Sequence[Day], picture: Path) -> None:
    """One panel per day, all with the same temperature axis; the title states the largest change."""
    rows = -(-len(days) // _COLUMNS)
    low = min(min(curve.min() for curve in (day.before, day.after, day.air)) for day in days) - ZERO_CELSIUS
    high = max(max(curve.max() for curve in (day.before, day.after, day.air)) for day in days) - ZERO_CELSIUS
    with chart_style():
        figure = new_figure(3.4 * _COLUMNS, 2.9 * rows)
        for number, day in enumerate(days, 1):
            axes = figure.add_subplot(rows, _COLUMNS, number, ylim=(low - 2, high + 2))
            change, hour = day.change
            axes.set_title(f"{day.name}\n{change:+.1f} K at {hour:.1f} h", fontsize=9)
            for label, values in (("air", day.air), ("before", day.before), ("after", day.after)):
                axes.plot(day.hours, values - ZERO_CELSIUS, label=label, linewidth=1)
            if number % _COLUMNS == 1:
                axes.set_ylabel("level surface, °C")
            hours_of_day(axes)
            name_lines(axes)
        save_figure(figure, picture)


@click.command()
@click.argument("before", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.argument("picture", type=click.Path(dir_okay=False, path_type=Path))
@click.argument("names", nargs=-1)
def main(before: Path, picture: Path, names: tuple[str, ...]) -> None:
    """Draw the day of materials by the library of the folder BEFORE and by the packaged one to PICTURE.

    Example: python -m mat.maintain.materials.days BEFORE/materials days.png
    """
    os.environ.pop(ENVIRONMENT, None)
    names = names or SHOWN
    missing = [name for name in names if not (before / "ht" / f"{name}.yaml").is_file()]
    if missing:
        raise click.BadParameter(f"found no ht/{missing[0]}.yaml in {before}; allowed: materials of both libraries")
    job = next(file for file in starter_files() if file.name == "job.yaml")
    days = days_of(load_library(before), load_library(), names, job)
    draw(days, picture)
    for day in days:
        change, hour = day.change
        click.echo(f"{day.name:<24} {change:+6.1f} K at {hour:4.1f} h; highest {day.after.max() - ZERO_CELSIUS:5.1f} C")


if __name__ == "__main__":
    main()
