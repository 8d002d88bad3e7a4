"""``mat export``: databases in other forms."""

from collections.abc import Iterator
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
    "--axes", is_flag=True, help="Atmospheric files with tables on five axes, whose nodes are placed by --tolerance."
)
@click.option(
    "--tolerance",
    default="0.5 K",
    show_default=True,
    metavar="K",
    help="With --axes: error of interpolation that 99 % of the reads are to keep.",
)
@click.option(
    "--most-nodes",
    type=click.IntRange(32, 200_000_000),
    default=20_000_000,
    show_default=True,
    help="With --axes: nodes that the largest table may have.",
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
    files: tuple[str, ...],
    raw: bool,
    gpu: bool,
    axes: bool,
    tolerance: str,
    most_nodes: int,
    frame: float | None,
    altitude: float | None,
    out: str,
) -> None:
    """Write FILES, or every database of a folder, in another form."""
    if raw + gpu + axes != 1:
        found = "no form is named" if not raw + gpu + axes else "found several forms"
        raise InputError(f"{found}; allowed: one of --raw, --gpu, --axes")
    if not gpu and (frame is not None or altitude is not None):
        raise InputError("--frame and --altitude go with --gpu; name it, or leave them out")
    if (frame is None) != (altitude is None):
        raise InputError("a frame needs its hour and the observer's altitude; give both --frame and --altitude")
    if gpu:
        _export_gpu([Path(name) for name in files], Path(out), frame, altitude)
    elif axes:
        _export_axes(files, Path(out), tolerance, most_nodes)
    else:
        _export_raw(files, out)


def _export_gpu(files: list[Path], out: Path, hour: float | None, altitude: float | None) -> None:
    from skyshine.mat.gpu.export import Frame, export_gpu

    frame = None if hour is None or altitude is None else Frame(hour, altitude)
    export_gpu(files, out, frame, click.echo)


def _export_axes(files: tuple[str, ...], out: Path, tolerance: str, most_nodes: int) -> None:
    from skyshine.mat.exchange.axes import export_axes
    from skyshine.mat.job.accuracy import pixel_kelvin
    from skyshine.mat.job.fields import tolerance_parts

    try:
        kelvin = tolerance_parts(pixel_kelvin(tolerance))[0]
    except ValueError as error:
        raise InputError(f"--tolerance: {error}") from None
    for database in _databases(files, "*atmq.h5"):
        written = export_axes(database, out, kelvin, most_nodes)
        shape = " x ".join(map(str, written.shape))
        short = "" if written.p99 <= kelvin else f"; --tolerance {kelvin:g} K is not reached with {most_nodes:,} nodes"
        click.echo(f"{written.path}: {shape} nodes, {written.p99:.2g} K in 99 % of the reads{short}")


def _export_raw(files: tuple[str, ...], out: str) -> None:
    from skyshine.mat.tables.raw import export_raw

    for database in _databases(files, "*.h5"):
        click.echo(export_raw(database, out))


def _databases(files: tuple[str, ...], pattern: str) -> Iterator[Path]:
    """The files, and those of folders by a pattern of their names."""
    for name in files:
        path = Path(name)
        databases = sorted(path.glob(pattern)) if path.is_dir() else [path]
        if not databases:
            raise InputError(f"holds no database ({pattern}); build one with 'mat build'", file=path)
        yield from databases
