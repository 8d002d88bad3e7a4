"""``tmm preview``: a picture of a mapped texture."""

import click


@click.command(epilog="Example: tmm preview build/yellowstone_road.tmm.h5 --out materials.png")
@click.argument("file", type=click.Path())
@click.option("--out", type=click.Path(), required=True, help="PNG file to write.")
@click.option("--image", type=click.Path(), help="Image of the texture; by default the file of its name near FILE.")
def command(file: str, out: str, image: str | None) -> None:
    """Draw texture, materials with a legend, and confidence of FILE side by side."""
    from skyshine.tmm.report.preview import draw

    draw(file, out, image)
    click.echo(out)
