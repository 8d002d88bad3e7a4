"""``mat plot``: draw databases."""

import click

from skyshine.schemas.errors import InputError


@click.command(epilog="Example: mat plot built/s01b02.atmq.h5 --out atmosphere.png")
@click.argument("files", nargs=-1, required=True, type=click.Path())
@click.option("--out", required=True, type=click.Path(), help="PNG file to write; with several FILES a folder.")
def command(files: tuple[str, ...], out: str) -> None:
    """Draw FILES: temperatures, atmospheric quantities, band properties."""
    from pathlib import Path

    from skyshine.mat.tables.pictures import draw

    target = Path(out)
    if len(files) == 1 and target.suffix.lower() != ".png":
        raise InputError(f"found --out '{out}'; allowed: a name that ends in .png")
    for file in files:
        if file.endswith(".tmm.h5"):
            raise InputError("contains a texture; draw it with 'tmm preview'", file=file)
    try:
        if len(files) == 1:
            click.echo(draw(files[0], target))
            return
        target.mkdir(parents=True, exist_ok=True)
        for file in files:
            click.echo(draw(file, target / (Path(file).name.removesuffix(".h5") + ".png")))
    except OSError as error:
        raise InputError(
            f"cannot be written: {error.strerror or error}; name another place with --out", file=target
        ) from None
