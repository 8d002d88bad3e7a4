"""``mat export``: databases in other forms."""

from pathlib import Path

import click

from skyshine.schemas.errors import InputError


@click.command(epilog="Example: mat export --raw built/s01.htt.h5 built/b02.band.h5 --out flat")
@click.argument("files", nargs=-1, required=True, type=click.Path())
@click.option(
    "--raw", is_flag=True, help="Little-endian float32 in one file beside a JSON header, for engines without HDF5."
)
@click.option("--out", required=True, type=click.Path(file_okay=False), help="Folder to write into.")
def command(files: tuple[str, ...], raw: bool, out: str) -> None:
    """Write FILES, or every database of a folder, in another form."""
    from skyshine.mat.tables.raw import export_raw

    if not raw:
        raise InputError("no form is named; allowed: --raw")
    for name in files:
        path = Path(name)
        databases = sorted(path.glob("*.h5")) if path.is_dir() else [path]
        if not databases:
            raise InputError("holds no database; build one with 'mat build'", file=path)
        for database in databases:
            click.echo(export_raw(database, out))
