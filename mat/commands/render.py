"""``mat render``: pictures of a scene."""

import click

from skyshine.schemas.commands import allow_outside_option, emit_json, json_option, progress


@click.command(epilog="Example: mat init demo && mat build demo/job.yaml && mat render demo/scene.yaml")
@click.argument("scene", type=click.Path())
@click.option(
    "--out", type=click.Path(file_okay=False), help="Output folder; by default 'rendered' beside the scene file."
)
@click.option(
    "--buffers", is_flag=True, help="SCENE is a frame file: depth, normals and ids that another renderer has drawn."
)
@allow_outside_option
@json_option
def command(scene: str, out: str | None, buffers: bool, as_json: bool) -> None:
    """Draw SCENE from built databases: radiance and apparent temperature by hour and band.

    The folder then contains, for each hour and band, the apparent temperature as a 16-bit PNG with 100 values a kelvin,
    the radiance as EXR in W m^-2 sr^-1 and, for a band with a sensor, its counts; and the day in one picture and as
    animations. With --buffers, it contains the same for each frame of the other renderer, and a picture of 16 of them.
    """
    from skyshine.mat.api.frame import Frame
    from skyshine.mat.api.scene import Scene

    drawn = Frame(scene) if buffers else Scene(scene)
    files = drawn.render(out, progress=progress)
    notes = drawn.notes if isinstance(drawn, Frame) else []
    if as_json:
        emit_json({"files": [str(file) for file in files], "notes": notes})
        return
    for note in notes:
        click.echo(f"note: {note}")
    for file in files[:1] if buffers else [file for file in files if "_day" in file.stem]:
        click.echo(file)
    click.echo(f"{files[0].parent}: {len(files)} files")
