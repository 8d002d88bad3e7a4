"""Options of the commands that look at faces from a distance: which tables they read, and the line of sight."""

from __future__ import annotations

from collections.abc import Callable

import click

from skyshine.mat.commands import completions
from skyshine.mat.commands.model_options import axis_option
from skyshine.mat.job.atmosphere import AtmosphereGrid
from skyshine.mat.job.surface import SurfaceGrid
from skyshine.schemas.commands import Command


def sight_options(band_help: str) -> Callable[[Command], Command]:
    """Adds ``--band``, ``--state``, ``--source``, and those of a line of sight; the parameter of ``--range`` is
    `distance`.
    """
    options = [
        click.option("--band", shell_complete=completions.bands, metavar="NAME", help=band_help),
        click.option("--state", type=click.IntRange(1), default=1, show_default=True, help="State, counted from 1."),
        click.option("--source", type=click.Choice(["sun", "moon"]), default="sun", show_default=True),
        axis_option(AtmosphereGrid, "range_km", "--range distance", 1.0),
        axis_option(AtmosphereGrid, "elevation_deg", "--elevation", -45.0),
        click.option(
            "--heading",
            type=click.FloatRange(-360, 360),
            default=0.0,
            show_default=True,
            help="Azimuth of the line of sight, degrees clockwise from north.",
        ),
        axis_option(SurfaceGrid, "altitude_km", "--altitude", note="; by default the lowest of the tables"),
    ]

    def add(command: Command) -> Command:
        for option in reversed(options):
            command = option(command)
        return command

    return add
