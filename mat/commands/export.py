"""``mat export``: databases in other forms."""

from pathlib import Path

import click

from skyshine.schemas.errors import InputError


@click.command(epilog="Example: mat export --gpu built --frame 14 --altitude 4 --out textures")
@click.argument("files", nargs=-1, required=True, type=click.Path())
@click.option(
    "--raw", is_flag=True, help="Little-endian float32 in one file beside a JSON header, for engines without HDF5."
)
@click.option(
    "--gpu", is_flag=True, help="Half-float textures, u16 codes and the shader that evaluates a pixel from them."
)
@click.option(
    "--frame",
    type=float,
    default=None,
    metavar="HOUR",
    help="With --gpu: one frame alone, at this local clock time in h; an atmosphere is then at most 64 kB.",
)
@click.option(
    "--altitude", type=float, default=None, metavar="KM", help="With --frame: altitude of the observer above sea level."
)
@click.option("--out", required=True, type=click.Path(file_okay=False), help="Folder to write into.")
def command(
    files: tuple[str, ...], raw: bool, gpu: bool, frame: float | None, altitude: float | None, out: str
) -> None:
    """Write FILES, or every database of a folder, in another form."""
    if raw == gpu:
        raise InputError(
            "found both --raw and --gpu; name one of them" if raw else "no form is named; allowed: --raw, --gpu"
        )
    if not gpu and (frame is not None or altitude is not None):
        raise InputError("--frame and --altitude go with --gpu; name it, or leave them out")
    if (frame is None) != (altitude is None):
        raise InputError("a frame needs its hour and the observer's altitude; give both --frame and --altitude")
    if gpu:
        _export_gpu([Path(name) for name in files], Path(out), frame, altitude)
    else:
        _export_raw(files, out)


def _export_gpu(files: list[Path], out: Path, hour: float | None, altitude: float | None) -> None:
    from skyshine.mat.gpu.export import Frame, export_gpu

    frame = None if hour is None or altitude is None else Frame(hour, altitude)
    export_gpu(files, out, frame, click.echo)


def _export_raw(files: tuple[str, ...], out: str) -> None:
    from skyshine.mat.tables.raw import export_raw

    for name in files:
        path = Path(name)
        databases = sorted(path.glob("*.h5")) if path.is_dir() else [path]
        if not databases:
            raise InputError("holds no database; build one with 'mat build'", file=path)
        for database in databases:
            click.echo(export_raw(database, out))
