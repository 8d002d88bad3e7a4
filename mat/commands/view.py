"""``mat view``: a page that shows built databases in the infrared."""

from pathlib import Path

import click

from skyshine.mat.commands.model_options import axis_option
from skyshine.mat.job.atmosphere import AtmosphereGrid
from skyshine.schemas.errors import InputError

METRES_PER_TEXEL = 0.25  # [m], of an aerial photograph


@click.command(epilog="Example: mat view built --out view")
@click.argument("source", metavar="FOLDER|SCENE", type=click.Path())
@click.option("--out", required=True, type=click.Path(file_okay=False), help="Output folder of the page.")
@click.option("--texture", default=None, help="Name of the texture to show; by default the first.")
@axis_option(AtmosphereGrid, "altitude_km", "--altitude", note="; by default 1 km above the surface")
@click.option(
    "--metres-per-texel",
    type=click.FloatRange(min=0.0, min_open=True),
    default=None,
    metavar="M",
    help=f"Size of a texel on the ground.  [default: {METRES_PER_TEXEL}]",
)
def command(source: str, out: str, texture: str | None, altitude: float | None, metres_per_texel: float | None) -> None:
    """Write a page that shows a built FOLDER, or the SCENE of a scene file, in the infrared.

    Of a folder the page shows a texture, of a scene its surface from the first place of its camera,
    with no cast shadows except the shade of the photograph. The page opens from the file in any browser with
    WebGL2 without network access. Time of day, band, source, palette, range and gain are set on it; the
    temperature under the pointer and the time of a frame are shown.
    """
    if Path(source).suffix.lower() in (".yaml", ".yml"):
        options = {"--texture": texture, "--altitude": altitude, "--metres-per-texel": metres_per_texel}
        for option, value in options.items():
            if value is not None:
                raise InputError(f"{option} goes with a folder; a scene file states it; leave it out")
        click.echo(_scene(Path(source), Path(out)))
        return
    from skyshine.mat.gpu.viewer import plan_of_folder, write_viewer

    size = METRES_PER_TEXEL if metres_per_texel is None else metres_per_texel
    plan = plan_of_folder(Path(source), texture=texture, altitude=altitude, metres_per_texel=size)
    click.echo(write_viewer(plan, Path(out)))


def _scene(source: Path, out: Path) -> Path:
    from skyshine.mat.gpu.scene_view import write_scene_viewer
    from skyshine.mat.render.scene_file import load_scene

    return write_scene_viewer(load_scene(source), out)
