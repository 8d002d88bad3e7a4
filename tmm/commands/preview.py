"""``tmm preview``: the content of texture databases, and a picture of one."""

from __future__ import annotations

import click

from skyshine.schemas.commands import json_option
from skyshine.schemas.errors import InputError


@click.command(epilog="Example: tmm preview build/yellowstone_road.tmm.h5 --out materials.png")
@click.argument("files", type=click.Path(), nargs=-1, required=True)
@click.option("--out", type=click.Path(), help="Draw FILE into this PNG file.")
@click.option(
    "--image", type=click.Path(), help="With --out: image of the texture; by default the file of its name near FILE."
)
@json_option
def command(files: tuple[str, ...], out: str | None, image: str | None, as_json: bool) -> None:
    """Show the content of FILE: texture, materials, levels and quality, or the classes of a trained model; of several
    FILES the share of each material, in each file and in all together.

    With --out, draw texture, materials with a legend, and confidence of FILE side by side.
    """
    from skyshine.tmm.commands.content import show_content, show_shares
    from skyshine.tmm.report.preview import draw

    if out is None:
        if image is not None:
            raise InputError("found --image without --out; name the picture to draw")
        if len(files) == 1:
            show_content(files[0], as_json)
        else:
            show_shares(files, as_json)
        return
    if len(files) > 1:
        raise InputError(f"found --out with {len(files)} files; allowed: one file; draw each by itself")
    draw(files[0], out, image)
    click.echo(out)
