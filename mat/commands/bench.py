"""``mat bench``: error against run time, measured."""

from __future__ import annotations

import click

from skyshine.mat.commands.absorption_bench import absorption
from skyshine.mat.commands.atmosphere_bench import atmosphere
from skyshine.mat.commands.batch import batch
from skyshine.mat.commands.leaving_out import leaving_out
from skyshine.mat.commands.stability import stability
from skyshine.mat.commands.surface_bench import surface
from skyshine.schemas.commands import echo_table, emit_json, json_option
from skyshine.schemas.quantity import quantity


@click.group("bench", invoke_without_command=True, epilog="Example: mat bench --quick --out bench")
@click.option("--out", type=click.Path(file_okay=False), help="Folder for bench.json and bench.png.")
@click.option("--quick", is_flag=True, help="Narrow bands and few materials: within three minutes on two cores.")
@click.option(
    "--textures", nargs=2, type=click.Path(), metavar="JOB TRUTH", help="Classifiers too, as 'tmm bench' takes them."
)
@json_option
@click.pass_context
def command(
    context: click.Context, out: str | None, quick: bool, textures: tuple[str, str] | None, as_json: bool
) -> None:
    """Error against run time, measured side by side in one run: of one part, or without a name of all."""
    if context.invoked_subcommand is None:
        from skyshine.mat.commands.whole_bench import run

        run(quick, out, textures, as_json)


command.add_command(absorption)
command.add_command(surface)
command.add_command(atmosphere)
command.add_command(batch)
command.add_command(stability)
command.add_command(leaving_out)


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
