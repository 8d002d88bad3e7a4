"""``mat export --to gazebo``: heat signatures for the thermal camera of Gazebo."""

from __future__ import annotations

from pathlib import Path

import click

from skyshine.mat.commands import completions


@click.command(epilog="Example: mat export demo/built --to gazebo --hour 14 --band 8-12 --range 1.5 --out media")
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--hour", type=click.FloatRange(0, 24), required=True, help="Local clock time, h.")
@click.option(
    "--band",
    shell_complete=completions.bands,
    metavar="NAME",
    help="Name of the band; required if the folder has several.",
)
@click.option(
    "--state", type=click.IntRange(1), default=1, show_default=True, help="Number of the state, counted from 1."
)
@click.option("--source", type=click.Choice(["sun", "moon"]), default="sun", show_default=True)
@click.option(
    "--range",
    "distance",
    type=click.FloatRange(0),
    default=1.0,
    show_default=True,
    help="Length of the line of sight, km.",
)
@click.option(
    "--elevation",
    type=click.FloatRange(-90, 0, max_open=True),
    default=-45.0,
    show_default=True,
    help="Elevation of the line of sight, degree.",
)
@click.option(
    "--heading",
    type=click.FloatRange(-360, 360),
    default=0.0,
    show_default=True,
    help="Azimuth of the line of sight, degrees clockwise from north.",
)
@click.option(
    "--altitude", type=float, metavar="KM", help="Altitude of the surfaces; by default the lowest of the tables."
)
@click.option(
    "--unknown-material",
    shell_complete=completions.materials,
    metavar="NAME",
    help="Material of texels without material; by default they are refused.",
)
@click.option("--out", required=True, type=click.Path(file_okay=False, path_type=Path), help="Output folder.")
def command(
    folder: Path,
    hour: float,
    band: str | None,
    state: int,
    source: str,
    distance: float,
    elevation: float,
    heading: float,
    altitude: float | None,
    unknown_material: str | None,
    out: Path,
) -> None:
    """Write heat signatures of the textures in FOLDER, the plugin that reads them, and temperatures of all materials.

    Temperatures are apparent ones of level faces through the air, as the thermal camera of Gazebo, which knows no air,
    takes them: NAME.heat.png between the temperatures that NAME.thermal.sdf states. temperatures.json has one number
    for each material, for visuals of a uniform temperature.
    """
    from skyshine.mat.exchange.gazebo import Moment, write_heat_signatures
    from skyshine.mat.render.contrast import Sight

    moment = Moment(hour, Sight(distance, elevation, heading, altitude), band, state, source)
    for path in write_heat_signatures(folder, out, moment, unknown_material):
        click.echo(path)
