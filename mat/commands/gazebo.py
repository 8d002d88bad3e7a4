"""``mat export --to gazebo``: heat signatures for the thermal camera of Gazebo."""

from __future__ import annotations

from pathlib import Path

import click

from skyshine.mat.commands import completions
from skyshine.mat.commands.sight_options import hour_option, sight_options
from skyshine.schemas.errors import InputError


@click.command(epilog="Example: mat export demo/built --to gazebo --hour 14 --band b02 --out media")
@click.argument("folder", type=click.Path(path_type=Path))
@hour_option(required=True)
@sight_options("Name of the band; required if the folder has several.")
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

    if elevation >= 0:
        raise InputError(f"found --elevation {elevation:g}; allowed: below 0, for level faces are looked down on")
    moment = Moment(hour, Sight(distance, elevation, heading, altitude), band, state, source)
    for path in write_heat_signatures(folder, out, moment, unknown_material):
        click.echo(path)
