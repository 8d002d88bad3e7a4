"""Options of the commands that look at faces from a distance: which tables they read, and the line of sight."""

from __future__ import annotations

from collections.abc import Callable

import click

from skyshine.mat.commands import completions
from skyshine.schemas.commands import Command


def sight_options(elevation: click.FloatRange, band_help: str) -> Callable[[Command], Command]:
    """Adds ``--band``, ``--state``, ``--source``, and those of a line of sight; the parameter of ``--range`` is
    `distance`.
    """
    options = [
        click.option("--band", shell_complete=completions.bands, metavar="NAME", help=band_help),
        click.option("--state", type=click.IntRange(1), default=1, show_default=True, help="State, counted from 1."),
        click.option("--source", type=click.Choice(["sun", "moon"]), default="sun", show_default=True),
        _number("--range", "distance", click.FloatRange(0), 1.0, "Length of the line of sight, km."),
        _number("--elevation", "elevation", elevation, -45.0, "Elevation of the line of sight, degree."),
        _number(
            "--heading",
            "heading",
            click.FloatRange(-360, 360),
            0.0,
            "Azimuth of the line of sight, degrees clockwise from north.",
        ),
        click.option(
            "--altitude",
            type=float,
            metavar="KM",
            help="Altitude of the surfaces; by default the lowest of the tables.",
        ),
    ]

    def add(command: Command) -> Command:
        for option in reversed(options):
            command = option(command)
        return command

    return add


def _number(
    option: str, name: str, limits: click.FloatRange, default: float, help_text: str
) -> Callable[[Command], Command]:
    return click.option(option, name, type=limits, default=default, show_default=True, help=help_text)
