"""``mat export``: databases, atmospheres and materials in the formats of others."""

from __future__ import annotations

import importlib
from pathlib import Path

import click
from click.shell_completion import CompletionItem

from skyshine.mat.commands.model_options import axis_option
from skyshine.mat.commands.sight_options import hour_option
from skyshine.mat.job.atmosphere import AtmosphereGrid
from skyshine.schemas.errors import InputError, nearest

FORMS = {
    "raw": "Little-endian float32 in one file beside a JSON header, for engines without HDF5.",
    "axes": "Atmospheric files with tables on five axes, whose nodes are placed by a tolerance.",
    "netcdf": "The states of folders as cubes by date, for analysis with xarray and other readers of CF.",
    "gpu": "Half-float textures, u16 codes and the shader that evaluates a pixel from them.",
    "gazebo": "Heat signatures for the thermal camera of Gazebo.",
    "lut": "A look-up table for ISOFIT over water vapour, aerosol and geometry.",
    "openmaterial": "Materials as files of ASAM OpenMATERIAL 3D.",
}
_HOMES = {"gazebo": "gazebo", "lut": "lut", "openmaterial": "openmaterial"}  # modules of their own


class _Forms(click.Group):
    """A group whose commands are named by ``--to``."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        form, remaining = _form_of(args)
        if form is None and ctx.resilient_parsing:  # a shell completes a word
            ctx.meta["after_to"] = args[-1:] == ["--to"]
            return super().parse_args(ctx, [])
        if form is None and any(word in ctx.help_option_names for word in remaining):
            return super().parse_args(ctx, ["--help"])
        if form is None:
            raise InputError(f"no format is named; allowed: --to {', --to '.join(FORMS)}")
        if form not in FORMS:
            raise InputError(f"found --to '{form}'; {nearest(form, FORMS)}")
        return super().parse_args(ctx, [form, *remaining])

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        name, command, remaining = super().resolve_command(ctx, args)
        return f"--to {name}", command, remaining

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        words = FORMS if ctx.meta.get("after_to") else {"--to": "Format to write."}
        return [CompletionItem(word, help=text) for word, text in words.items() if word.startswith(incomplete)]

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(FORMS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in _HOMES:
            return super().get_command(ctx, name)
        command: click.Command = importlib.import_module(f"skyshine.mat.commands.{_HOMES[name]}").command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Formats"):
            formatter.write_dl(list(FORMS.items()))


def _form_of(args: list[str]) -> tuple[str | None, list[str]]:
    """The word after ``--to``, and the other words."""
    for at, word in enumerate(args):
        if word == "--to" and at + 1 < len(args):
            return args[at + 1], args[:at] + args[at + 2 :]
        if word.startswith("--to="):
            return word.removeprefix("--to="), args[:at] + args[at + 1 :]
    return None, args


@click.group(
    "export",
    cls=_Forms,
    subcommand_metavar="--to FORMAT ...",
    epilog="Example: mat export built --to gpu --hour 14 --altitude 4 --out textures",
)
def command() -> None:
    """Write databases, atmospheres or materials in another format.

    'mat export --to FORMAT --help' shows the options of one."""


out_option = click.option(
    "--out", required=True, type=click.Path(file_okay=False, path_type=Path), help="Output folder."
)


@command.command("gpu", epilog="Example: mat export built --to gpu --hour 14 --altitude 4 --out textures")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@hour_option(required=False, note=": write one frame at this time, each atmosphere of which has at most 64 kB")
@axis_option(AtmosphereGrid, "altitude_km", "--altitude", note="; with --hour")
@out_option
def gpu(files: tuple[Path, ...], hour: float | None, altitude: float | None, out: Path) -> None:
    """Write FILES, or every database of a folder, as half-float textures, u16 codes and the shader of a pixel."""
    from skyshine.mat.api.export import export
    from skyshine.mat.gpu.export import Frame

    if (hour is None) != (altitude is None):
        raise InputError("a frame needs its hour and the observer's altitude; give both --hour and --altitude")
    moment = None if hour is None or altitude is None else Frame(hour, altitude)
    export(files, "gpu", out, frame=moment, report=click.echo)


@command.command("axes", epilog="Example: mat export built --to axes --tolerance '0.3 K' --out tables")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--tolerance",
    default="0.5 K",
    show_default=True,
    metavar="K",
    help="99th-percentile interpolation error to reach.",
)
@click.option(
    "--most-nodes",
    type=click.IntRange(32, 200_000_000),
    default=20_000_000,
    show_default=True,
    help="Maximum number of nodes of the largest table.",
)
@out_option
def axes(files: tuple[Path, ...], tolerance: str, most_nodes: int, out: Path) -> None:
    """Write atmospheric FILES, or those of a folder, with tables on five axes whose nodes a tolerance places."""
    from skyshine.mat.api.export import export

    export(files, "axes", out, tolerance=tolerance, most_nodes=most_nodes, report=click.echo)


@command.command("raw", epilog="Example: mat export built --to raw --out flat")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@out_option
def raw(files: tuple[Path, ...], out: Path) -> None:
    """Write FILES, or every database of a folder, as little-endian float32 beside a JSON header."""
    from skyshine.mat.api.export import export

    export(files, "raw", out, report=click.echo)


@command.command("netcdf", epilog="Example: mat export built --to netcdf --out cubes")
@click.argument("folders", nargs=-1, required=True, type=click.Path(path_type=Path))
@out_option
def netcdf(folders: tuple[Path, ...], out: Path) -> None:
    """Write the states of FOLDERS of `mat build` as netCDF by date: temperatures at whole hours, and the quantities of
    each band on five axes."""
    from skyshine.mat.api.export import export

    export(folders, "netcdf", out, report=click.echo)
