"""Options of the commands that look at faces from a distance: which tables they read, and the line of sight."""

from __future__ import annotations

from collections.abc import Callable

import click

from skyshine.mat.commands import completions
from skyshine.mat.commands.model_options import axis_option, in_order
from skyshine.mat.job.atmosphere import AtmosphereGrid
from skyshine.mat.job.surface import SurfaceGrid
from skyshine.schemas.commands import Command

job_option = click.option(
    "--job", type=click.Path(), help="Job whose state gives the air, weather, surroundings, Sun and Moon."
)
state_option = click.option(
    "--state", type=click.IntRange(1), default=1, show_default=True, help="State of the job, counted from 1."
)


def hour_option(required: bool, note: str = "") -> Callable[[Command], Command]:
    """Adds ``--hour``, that of the pictures of a scene."""
    return click.option(
        "--hour", type=click.FloatRange(0, 24), required=required, metavar="NUMBER", help=f"Local clock time, h{note}."
    )


def sight_options(band_help: str) -> Callable[[Command], Command]:
    """Adds ``--band``, ``--state``, ``--source``, and those of a line of sight; the parameter of ``--range`` is
    `distance`.
    """
    options = [
        click.option("--band", shell_complete=completions.bands, metavar="NAME", help=band_help),
        state_option,
        click.option("--source", type=click.Choice(["sun", "moon"]), default="sun", show_default=True),
        axis_option(AtmosphereGrid, "range_km", "--range distance", 1.0),
        axis_option(AtmosphereGrid, "elevation_deg", "--elevation", -45.0),
        axis_option(SurfaceGrid, "azimuth_deg", "--heading", 0.0, what="Azimuth of the line of sight"),
        axis_option(SurfaceGrid, "altitude_km", "--altitude", note="; by default the lowest of the tables"),
    ]
    return in_order(options)
