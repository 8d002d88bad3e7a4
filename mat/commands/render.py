"""``mat render``: pictures of a scene."""

import click

from skyshine.schemas.commands import allow_outside_option, emit_json, json_option, progress


@click.command(epilog="Example: mat init demo && mat build demo/job.yaml && mat render demo/scene.yaml")
@click.argument("scene", type=click.Path())
@click.option(
    "--out", type=click.Path(file_okay=False), help="Output folder; by default 'rendered' beside the scene file."
)
@allow_outside_option
@json_option
def command(scene: str, out: str | None, as_json: bool) -> None:
    """Draw SCENE from built databases: radiance and apparent temperature by hour and band.

    The folder then contains, for each hour and band, the apparent temperature as a 16-bit PNG with 100 values a kelvin,
    the radiance as EXR in W m^-2 sr^-1 and, for a band with a sensor, its counts; and the day in one picture and as
    animations.
    """
    from skyshine.mat.api.scene import Scene

    files = Scene(scene).render(out, progress=progress)
    if as_json:
        emit_json({"files": [str(file) for file in files]})
        return
    pictures = [file for file in files if "_day" in file.stem]
    for file in pictures:
        click.echo(file)
    click.echo(f"{files[0].parent}: {len(files)} files")
