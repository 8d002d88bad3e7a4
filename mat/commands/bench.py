"""``mat bench``: error against run time, measured."""

from __future__ import annotations

from pathlib import Path

import click

from skyshine.mat.commands.absorption_bench import absorption
from skyshine.mat.commands.atmosphere_bench import atmosphere
from skyshine.mat.commands.batch import batch
from skyshine.mat.commands.front import front
from skyshine.mat.commands.leaving_out import leaving_out
from skyshine.mat.commands.parts_bench import parts
from skyshine.mat.commands.stability import stability
from skyshine.mat.commands.surface_bench import surface
from skyshine.schemas.commands import echo_table, emit_json, json_option
from skyshine.schemas.quantity import quantity


class _JobOrPart(click.Group):
    """A group whose first word is a command or a job: a job, or none, is given to the command `front`."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if not args or self._is_for_front(args[0], ctx):
            args = ["front", *args]
        return super().parse_args(ctx, args)

    def _is_for_front(self, word: str, ctx: click.Context) -> bool:
        if word.startswith("-"):
            return word not in ctx.help_option_names
        is_command = word in self.list_commands(ctx)
        return not is_command and (Path(word).is_file() or Path(word).suffix in (".yaml", ".yml"))


@click.group(
    "bench", cls=_JobOrPart, subcommand_metavar="[JOB | COMMAND] ...", epilog="Example: mat bench demo/job.yaml"
)
def command() -> None:
    """Error against run time, measured side by side in one run.

    With a JOB, or for the starter job without one, its own front: see 'mat bench front --help'.
    """


for part in (front, parts, absorption, surface, atmosphere, batch, stability, leaving_out):
    command.add_command(part)


@command.command()
@click.option(
    "--points", type=click.IntRange(1000, 100_000_000), default=1_000_000, show_default=True, help="Query points."
)
@json_option
def loader(points: int, as_json: bool) -> None:
    """Reading: interpolated values a second of one core on five-axis tables of the default size, beside scipy's
    interpolator.

    \b
    Example: mat bench loader --points 1000000
    """
    from skyshine.mat.bench.loader import bench_loader

    # Default nodes: range, altitude, elevation, source elevation, source azimuth; and 60 materials by the surface grid.
    tables = {"atmq": (29, 12, 25, 13, 13), "htt": (60, 8, 24, 10, 48)}
    measured = {name: bench_loader(shape, points) for name, shape in tables.items()}
    if as_json:
        emit_json(
            {
                name: {
                    "nodes": list(bench.shape),
                    "rate": quantity(bench.values_per_second, "s-1"),
                    "rate_scipy": quantity(bench.scipy_values_per_second, "s-1"),
                    "difference": quantity(bench.difference, "1"),
                }
                for name, bench in measured.items()
            }
        )
        return
    rows = [
        [
            name,
            " x ".join(map(str, bench.shape)),
            f"{bench.values_per_second:.3g}",
            f"{bench.scipy_values_per_second:.3g}",
            f"{bench.difference:.1g}",
        ]
        for name, bench in measured.items()
    ]
    echo_table(["table", "nodes", "values/s", "scipy", "difference"], rows)
