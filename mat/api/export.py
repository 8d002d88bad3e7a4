"""Databases in other formats."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Literal

from skyshine.mat.exchange.axes import export_axes
from skyshine.mat.exchange.cube import export_cubes
from skyshine.mat.gpu.export import Frame, export_gpu
from skyshine.mat.job.accuracy import pixel_kelvin
from skyshine.mat.job.fields import tolerance_parts
from skyshine.mat.tables.raw import export_raw
from skyshine.schemas.errors import InputError, nearest

StrPath = str | os.PathLike[str]
DatabaseFormat = Literal["raw", "axes", "gpu", "netcdf"]


def export(
    files: StrPath | Iterable[StrPath],
    to: DatabaseFormat,
    out: StrPath,
    *,
    frame: Frame | None = None,
    tolerance: str = "0.5 K",
    most_nodes: int = 20_000_000,
    report: Callable[[str], None] | None = None,
) -> list[Path]:
    """Write databases in another format, as `mat export` does.

    Parameters
    ----------
    files : path or iterable of path
        Databases of `mat build`, or folders of them.
    to : {"raw", "axes", "gpu", "netcdf"}
        Little-endian float32 beside a JSON header; atmospheric files with tables on five axes; half-float textures with
        the shader that evaluates a pixel; the states of folders as cubes by date, for analysis.
    out : path
        Folder to write into.
    frame : Frame, optional
        Hour and altitude of one frame, for ``"gpu"``; an atmosphere then takes at most 64 kB.
    tolerance : str
        Error of interpolation that 99 % of the reads keep, for ``"axes"``: 0.05 to 5 K.
    most_nodes : int
        Nodes that the largest table may have, for ``"axes"``.
    report : callable, optional
        Called with a line of text for each file.

    Returns
    -------
    list of Path
        Files written; of ``"raw"`` the headers.

    Raises
    ------
    InputError
        A file is no database, the format is unknown, or a place cannot be written.

    Examples
    --------
    >>> import skyshine.mat
    >>> skyshine.mat.export("demo/built", "raw", "flat")  # doctest: +SKIP
    """
    sources = [Path(files)] if isinstance(files, str | os.PathLike) else [Path(file) for file in files]
    say = report or (lambda _line: None)
    if to == "gpu":
        return export_gpu(sources, Path(out), frame, lambda path: say(str(path)))
    if to == "raw":
        return [_said(export_raw(database, out), say) for database in _databases(sources, "*.h5")]
    if to == "netcdf":
        return [_said(path, say) for folder in sources for path in export_cubes(folder, Path(out))]
    if to != "axes":
        raise InputError(f"found the format '{to}'; {nearest(to, ('raw', 'axes', 'gpu', 'netcdf'))}")
    try:
        kelvin = tolerance_parts(pixel_kelvin(tolerance))[0]
    except ValueError as error:
        raise InputError(f"--tolerance: {error}") from None
    paths = []
    for database in _databases(sources, "*atmq.h5"):
        exported = export_axes(database, Path(out), kelvin, most_nodes)
        shape = " x ".join(map(str, exported.shape))
        short = "" if exported.p99 <= kelvin else f"; --tolerance {kelvin:g} K is not reached with {most_nodes:,} nodes"
        say(f"{exported.path}: {shape} nodes, {exported.p99:.2g} K in 99 % of the reads{short}")
        paths.append(exported.path)
    return paths


def _said(path: Path, say: Callable[[str], None]) -> Path:
    say(str(path))
    return path


def _databases(files: Iterable[Path], pattern: str) -> Iterator[Path]:
    """The files, and those of folders by a pattern of their names."""
    for path in files:
        databases = sorted(path.glob(pattern)) if path.is_dir() else [path]
        if not databases:
            raise InputError(f"contains no database ({pattern}); build one with 'mat build'", file=path)
        yield from databases
