"""``mat bench batch``: a few of many states in one process, in several, on a Dask cluster."""

from __future__ import annotations

import time

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option, progress
from skyshine.schemas.quantity import quantity


@click.command()
@click.argument("job", type=click.Path())
@click.option(
    "--states",
    "count",
    type=click.IntRange(1, 1000),
    default=8,
    show_default=True,
    help="Built, evenly spread over the job's.",
)
@click.option(
    "--workers",
    type=click.IntRange(1, 1000),
    default=2,
    show_default=True,
    help="Processes, and workers of the cluster.",
)
@json_option
def batch(job, count, workers, as_json):
    """Many states: a sample of those of JOB in one process, in several, and on a local Dask cluster, by stage.

    The time of all states is that of the sample, and for each further state what its tasks took without the choice of
    spectral points, which a process makes once for each air; on a machine that does other work it is that machine's.

    \b
    Example: mat bench batch year/every_day.yaml --states 8
    """
    from skyshine.mat.bench.batch import Size, bench_batch, sampled
    from skyshine.mat.job.load import load_job
    from skyshine.mat.plan.plan import make_plan
    from skyshine.materials.library import load_library

    begin = time.perf_counter()
    loaded = load_job(job)
    tasks = len(make_plan(loaded, load_library()).tasks)
    planned = time.perf_counter() - begin
    few = sampled(loaded, count)
    with progress(3, "building the sample") as advance:
        found = bench_batch(few, workers, advance)
    sample, size = Size.of(few), Size.of(loaded)
    whole = [each.whole(sample, size) for each in found]
    if as_json:
        emit_json(
            {
                "states": size.states,
                "airs": size.airs,
                "sampled_states": sample.states,
                "sampled_airs": sample.airs,
                "tasks": tasks,
                "planning": quantity(planned, "s"),
                "places": [
                    {
                        "name": each.place,
                        "workers": each.workers,
                        "time": quantity(each.seconds, "s"),
                        "processor_time": quantity(each.processor_seconds, "s"),
                        "same_bytes": each.same,
                        "speed": quantity(found[0].seconds / each.seconds, "1"),
                        "further_state": quantity(each.further, "s"),
                        "choice_of_points": quantity(each.choice, "s"),
                        "all_states": quantity(seconds, "s"),
                        "all_states_speed": quantity(whole[0] / seconds, "1"),
                        "stages": {stage: quantity(spent, "s") for stage, spent in each.stages.items()},
                    }
                    for each, seconds in zip(found, whole, strict=True)
                ],
            }
        )
        return
    click.echo(f"{size.states} states of {size.airs} airs, {tasks} tasks, planned in {planned:.1f} s")
    click.echo(f"{sample.states} states of {sample.airs} airs built, without kept bands:")
    stages = list(found[0].stages)
    rows = [
        [
            each.place,
            f"{each.seconds:.1f}",
            *_scaling(found[0].seconds / each.seconds, each.workers),
            f"{each.processor_seconds:.1f}",
            *(f"{each.stages.get(stage, 0.0):.1f}" for stage in stages),
            "yes" if each.same else "no",
        ]
        for each in found
    ]
    echo_table(["where", "seconds", "times one", "per worker", "processor s", *stages, "same bytes"], rows)
    click.echo(f"\nall {size.states} states: the sample, and the further states by what its own took a process:")
    rows = [
        [
            each.place,
            f"{each.further:.2f}",
            f"{each.choice:.1f}",
            f"{seconds / 3600:.2f}",
            *_scaling(whole[0] / seconds, each.workers),
        ]
        for each, seconds in zip(found, whole, strict=True)
    ]
    echo_table(["where", "s a state", "s an air", "hours", "times one", "per worker"], rows)
    if len(found) < 3:
        click.echo("Dask is not installed: pip install 'skyshine[dask]'")


def _scaling(times: float, workers: int) -> list[str]:
    return [f"{times:.2f}", f"{100 * times / workers:.0f} %"]
