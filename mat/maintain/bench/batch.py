"""``python -m mat.maintain.bench.batch``: a few of many states in one process, in several, on a Dask cluster."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option, progress
from skyshine.schemas.quantity import quantity

if TYPE_CHECKING:
    from mat.maintain.bench.batch_timing import BatchTiming, Size


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
def batch(job: str, count: int, workers: int, as_json: bool) -> None:
    """Many states: a sample of those of JOB in one process, in several, and on a local Dask cluster, by stage.

    The time of all states is that of the sample, and for each further state what its tasks took without the choice of
    spectral points, which a process makes once for each air; on a machine that does other work it is that machine's.

    \b
    Example: python -m mat.maintain.bench.batch year/every_day.yaml --states 8
    """
    from mat.maintain.bench.batch_timing import Size, bench_batch
    from skyshine.mat.bench.sample import sampled
    from skyshine.mat.job.load import load_job
    from skyshine.mat.plan.plan import make_plan
    from skyshine.materials.library import load_library

    begin = time.perf_counter()
    loaded = load_job(job)
    tasks = len(make_plan(loaded, load_library()).tasks)
    planned = time.perf_counter() - begin
    sampled_job = sampled(loaded, count)
    with progress(3, "building the sample") as advance:
        timings = bench_batch(sampled_job, workers, advance)
    sample, size = Size.of(sampled_job), Size.of(loaded)
    totals = [timing.whole(sample, size) for timing in timings]
    if as_json:
        emit_json(_describe(timings, totals, sample, size, tasks, planned))
    else:
        _print(timings, totals, sample, size, tasks, planned)


def _describe(
    timings: list[BatchTiming], totals: list[float], sample: Size, size: Size, tasks: int, planned: float
) -> dict[str, Any]:
    """Timings of the sample, and seconds of the whole batch by place, as plain values."""
    return {
        "states": size.states,
        "airs": size.airs,
        "sampled_states": sample.states,
        "sampled_airs": sample.airs,
        "tasks": tasks,
        "planning": quantity(planned, "s"),
        "places": [
            {
                "name": timing.executor,
                "workers": timing.workers,
                "time": quantity(timing.seconds, "s"),
                "processor_time": quantity(timing.processor_seconds, "s"),
                "same_bytes": timing.identical,
                "speed": quantity(timings[0].seconds / timing.seconds, "1"),
                "further_state": quantity(timing.further, "s"),
                "choice_of_points": quantity(timing.choice, "s"),
                "all_states": quantity(seconds, "s"),
                "all_states_speed": quantity(totals[0] / seconds, "1"),
                "stages": {stage: quantity(spent, "s") for stage, spent in timing.stages.items()},
            }
            for timing, seconds in zip(timings, totals, strict=True)
        ],
    }


def _print(
    timings: list[BatchTiming], totals: list[float], sample: Size, size: Size, tasks: int, planned: float
) -> None:
    click.echo(f"{size.states} states of {size.airs} airs, {tasks} tasks, planned in {planned:.1f} s")
    click.echo(f"{sample.states} states of {sample.airs} airs built, without kept bands:")
    stages = list(timings[0].stages)
    rows = [
        [
            timing.executor,
            f"{timing.seconds:.1f}",
            *_scaling(timings[0].seconds / timing.seconds, timing.workers),
            f"{timing.processor_seconds:.1f}",
            *(f"{timing.stages.get(stage, 0.0):.1f}" for stage in stages),
            "yes" if timing.identical else "no",
        ]
        for timing in timings
    ]
    echo_table(["where", "seconds", "times one", "per worker", "processor s", *stages, "same bytes"], rows)
    click.echo(f"\nall {size.states} states: the sample, and the further states by what its own took a process:")
    rows = [
        [
            timing.executor,
            f"{timing.further:.2f}",
            f"{timing.choice:.1f}",
            f"{seconds / 3600:.2f}",
            *_scaling(totals[0] / seconds, timing.workers),
        ]
        for timing, seconds in zip(timings, totals, strict=True)
    ]
    echo_table(["where", "s a state", "s an air", "hours", "times one", "per worker"], rows)
    if len(timings) < 3:
        click.echo("Dask is not installed: pip install 'skyshine[dask]'")


def _scaling(times: float, workers: int) -> list[str]:
    return [f"{times:.2f}", f"{100 * times / workers:.0f} %"]


if __name__ == "__main__":
    batch()
