"""``mat check``: validate a job and print the plan."""

import re
from itertools import groupby

import click

from skyshine.schemas.commands import allow_outside_option, emit_json, json_option
from skyshine.schemas.quantity import quantity

MANY_STATES = 12  # beyond these their files are not listed one by one


@click.command(epilog="Example: mat check demo/job.yaml")
@click.argument("job", type=click.Path())
@allow_outside_option
@json_option
def command(job: str, as_json: bool) -> None:
    """Check JOB; print what will be built, what is left out and why, which source is up when, and the size."""
    from skyshine.mat.job.load import load_job
    from skyshine.mat.plan.cost import estimate
    from skyshine.mat.plan.physics import physics_left_out
    from skyshine.mat.plan.plan import make_plan
    from skyshine.mat.plan.size import check_size
    from skyshine.mat.plan.twins import twins_left_out
    from skyshine.mat.scene.check import check_scene
    from skyshine.mat.scene.sources import source_hours
    from skyshine.mat.scene.summary import state_summaries
    from skyshine.materials.library import load_library

    loaded = load_job(job)
    plan = make_plan(loaded, load_library())
    check_size(loaded, plan)
    check_scene(loaded)
    left_out = [*plan.left_out, *twins_left_out(loaded, plan.materials), *physics_left_out(loaded)]
    hours = source_hours(loaded.trimmed.on_date_of_state(1))
    states = state_summaries(loaded.trimmed)
    cost = estimate(loaded, plan)
    if as_json:
        emit_json(_as_json(plan, left_out, hours, states, cost))
    else:
        _print(loaded, plan, left_out, hours, states, cost)


_UNKNOWN = (
    "how many it takes is not known before the build has computed the {0}, so size and time come on top: at most {1:,}"
    " nodes, 4 bytes each, in a table; a build that cannot hold it with so many stops and names the axis that takes the"
    " most"
)


def _table(grid: str) -> str:
    return "air along each axis" if grid == "atmosphere_grid" else "temperatures along each axis"


def _tolerance_text(tolerance) -> str:
    if isinstance(tolerance, str):
        return tolerance
    named = {name: value for name, value in tolerance if value is not None}
    if len(named) == len(type(tolerance).model_fields) and len(set(named.values())) == 1:
        return next(iter(named.values()))
    return ", ".join(f"{value} of {name}" for name, value in named.items()) or "nothing"


def _as_json(plan, left_out, hours, states, cost) -> dict:
    return {
        "files": [name for task in plan.tasks for name in task.files],
        "states": states,
        "materials": list(plan.materials),
        "left_out": [vars(item) for item in left_out],
        "source_up": {source: [list(span) for span in spans] for source, spans in hours.items()},
        "size_before_compression": quantity(plan.bytes, "byte"),
        "estimated_time": {stage: quantity(seconds, "s") for stage, seconds in cost.items()},
    }


def _files(plan, states: int) -> list[str]:
    """A line for each file; of many states one for all files of a kind."""
    by_kind: dict[str, list[str]] = {}
    for name in (name for task in plan.tasks for name in task.files):
        of_state = states > MANY_STATES and re.fullmatch(r"s\d+(.*)", name)
        by_kind.setdefault(of_state[1] if of_state else name, []).append(name)
    return [
        names[0] if len(names) == 1 else f"{names[0]} to {names[-1]}: {len(names)} files" for names in by_kind.values()
    ]


def _print(loaded, plan, left_out, hours, states, cost) -> None:
    from skyshine.mat.scene.summary import summary_line

    click.echo(f"{loaded.file}: holds")
    for line, numbers in groupby(range(1, len(states) + 1), lambda number: summary_line(states[number - 1])):
        first, *others = (f"{number:02d}" for number in numbers)
        click.echo(f"{f'states {first} to {others[-1]}' if others else f'state {first}'}: {line}")
    click.echo("will be built:")
    for line in _files(plan, len(states)):
        click.echo(f"  {line}")
    click.echo(f"materials: {', '.join(plan.materials)}")
    click.echo("left out:" if left_out else "left out: nothing")
    for item in left_out:
        click.echo(f"  {item.what}: {item.why} (error: {item.bound}; to restore: {item.restore})")
    for source, spans in hours.items():
        times = ", ".join(f"{start} to {end}" for start, end in spans) or "at no time of the day"
        click.echo(f"{source} up on {loaded.trimmed.on_date_of_state(1).site.date}: {times}")
    click.echo(f"size of the tables before compression: {plan.bytes / 1e6:.1f} MB")
    stages = ", ".join(f"{stage} {seconds:.2g}" for stage, seconds in cost.items() if seconds)
    click.echo(f"processor time, estimated within a factor of two: {sum(cost.values()):.0f} s ({stages})")
    for name in ("atmosphere_grid", "surface_grid"):
        grid = getattr(loaded.trimmed, name)
        if grid.tolerance:
            click.echo(
                f"{name}: nodes are placed until {_tolerance_text(grid.tolerance)} holds;"
                f" {_UNKNOWN.format(_table(name), grid.most_nodes)}"
            )
