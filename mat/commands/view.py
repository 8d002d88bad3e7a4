"""``mat view``: a page that shows built databases in the infrared."""

from pathlib import Path

import click


@click.command(epilog="Example: mat view built --out view")
@click.argument("folder", type=click.Path())
@click.option("--out", required=True, type=click.Path(file_okay=False), help="Folder to write the page into.")
@click.option("--texture", default=None, help="Name of the texture to show; by default the first.")
@click.option(
    "--altitude", type=float, default=None, metavar="KM", help="Of the observer; by default 1 km above the surface."
)
@click.option(
    "--metres-per-texel",
    type=click.FloatRange(min=0.0, min_open=True),
    default=0.25,
    show_default=True,
    metavar="M",
    help="Size of a texel on the ground.",
)
def command(folder: str, out: str, texture: str | None, altitude: float | None, metres_per_texel: float) -> None:
    """Write a page that shows the texture of the built FOLDER in the infrared.

    The page opens from the file in any browser with WebGL2 and asks for nothing elsewhere. Time of day, band, source,
    range and gain are set on it; the temperature under the pointer and the time of a frame are shown.
    """
    from skyshine.mat.gpu.viewer import plan_of_folder, write_viewer

    plan = plan_of_folder(Path(folder), texture=texture, altitude=altitude, metres_per_texel=metres_per_texel)
    click.echo(write_viewer(plan, Path(out)))
