"""``mat check``: validate a job and print the plan."""

from __future__ import annotations

import os
import re
from collections import Counter
from itertools import count, groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skyshine.mat.threads import LINEAR_ALGEBRA
from skyshine.schemas.commands import allow_outside_option, emit_json, json_option, progress
from skyshine.schemas.errors import InputError

if TYPE_CHECKING:
    from skyshine.mat.api.check import JobCheck
    from skyshine.mat.job.model import Job
    from skyshine.mat.plan.resources import Resources

MANY_STATES = 12  # beyond these their files are not listed one by one
_LINES = 4  # lines of states and of warnings, without --verbose


@click.command(epilog="Example: mat check demo/job.yaml --scene demo/scene.yaml --out demo/less.yaml")
@click.argument("job", type=click.Path(path_type=Path))
@click.option(
    "--scene",
    type=click.Path(path_type=Path),
    help="Print the table extents that this scene requires, as the key 'needs' of JOB, and the cost of a "
    "build of them.",
)
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    help="With --scene: write a copy of JOB with these needs, in the folder of JOB.",
)
@click.option(
    "--least-share",
    type=click.FloatRange(0, 0.5),
    default=1e-3,
    show_default=True,
    help="With --scene: minimum pixel fraction; rarer materials are replaced by the most similar one.",
)
@click.option("--buffers", is_flag=True, help="JOB is a frame file of mat render --buffers.")
@click.option("--verbose", is_flag=True, help="All files and states, and what is skipped or approximated, with bounds.")
@allow_outside_option
@json_option
def command(
    job: Path, scene: Path | None, out: Path | None, least_share: float, buffers: bool, verbose: bool, as_json: bool
) -> None:
    """Check JOB; print its states, when each light source is up, and the time, disk and memory that a build takes.

    With --scene, cast the rays of its cameras and print the ranges, elevations, altitudes, slopes, azimuths, materials,
    hours, bands and source elevations that its frames read: a job with these needs builds nothing else. With --buffers,
    read all that mat render --buffers reads.
    """
    for name, value in LINEAR_ALGEBRA.items():  # small matrices, for which more threads take longer
        os.environ.setdefault(name, value)
    if buffers:
        _check_frame(job, as_json)
        return
    if scene is not None:
        _check_needs(scene, job, out, least_share, as_json)
        return
    if out is not None:
        raise InputError("found --out without --scene; name the scene whose needs the copy of the job is to have")
    from skyshine.mat.api.check import check

    result = check(job)
    if as_json:
        emit_json(_as_json(result))
    else:
        _print(result, verbose)


def _check_frame(file: Path, as_json: bool) -> None:
    from skyshine.mat.api.frame import Frame

    frame = Frame(file)
    frame.check(progress=progress)
    if as_json:
        emit_json({"frames": len(frame.marks), "hours": frame.hours, "notes": frame.notes})
        return
    click.echo(f"{file}: OK; frames: {len(frame.marks)}")
    for note in frame.notes:
        click.echo(f"note: {note}")


def _check_needs(scene: Path, job: Path, out: Path | None, least_share: float, as_json: bool) -> None:
    from skyshine.mat.api.needs import needs

    result = needs(scene, job, least_share=least_share, progress=progress)
    if out is not None:
        result.write(out)
    if as_json:
        limits = result.needs.limits
        emit_json(
            {
                "needs": {limit.key: limit.value for limit in limits},
                "reasons": {limit.key: limit.reason for limit in limits},
                "replaced_materials": result.needs.replaced,
                "replaced_share": result.needs.replaced_share,
                "notes": list(result.needs.notes),
                "whole": _cost(result.whole),
                "with_needs": _cost(result.reduced),
            }
        )
        return
    click.echo(result.text, nl=False)
    click.echo(f"# with these needs: {result.saving}")
    if out is not None:
        click.echo(f"# {out}; it builds into the folder of {job}, unless its output.folder is changed")


def _cost(plan: JobCheck) -> dict[str, Any]:
    from skyshine.mat.threads import core_count
    from skyshine.schemas.quantity import quantity

    return {
        "size_before_compression": quantity(plan.bytes, "byte"),
        "estimated_time": {stage: quantity(seconds, "s") for stage, seconds in plan.seconds.items()},
        "elapsed_time": {str(cores): quantity(plan.cost.elapsed(cores), "s") for cores in (1, core_count())},
        "size_on_disk": quantity(plan.cost.disk, "byte"),
        "memory_of_a_process": quantity(plan.cost.memory, "byte"),
        "less": [{"change": text, "time": quantity(seconds, "s")} for text, seconds in plan.cost.less],
    }


_UNKNOWN = (
    "their number is not known before the build has computed the {0}: at most {1:,} nodes of 4 bytes in a table;"
    " a build that needs more {2}"
)


def _accuracy(job: Job) -> str:
    """The error of the pixel, and the grids whose keys ask for another."""
    from skyshine.mat.job.fields import tolerance_parts

    pixel = job.accuracy.pixel
    tolerances = {"atmosphere_grid": job.atmosphere_grid.tolerance, "surface_grid": job.surface_grid.tolerance}
    written = [
        f"the {tolerance} of {name}" if tolerance else f"the nodes of {name}"
        for name, tolerance in tolerances.items()
        if tolerance is None or tolerance_parts(tolerance) != tolerance_parts(pixel)
    ]
    but = f", but for {' and '.join(written)}" if written else ""
    return f"accuracy: {pixel} of a pixel{but}; mat report measures it"


def _shares(job: Job) -> str:
    """How the error of the pixel is shared out."""
    accuracy = job.accuracy
    return (
        f"accuracy: {accuracy.pixel} of a pixel, shared out:"
        f" {job.atmosphere_grid.tolerance} in tables of the air,"
        f" {job.surface_grid.tolerance or 'the nodes written'} in those of temperatures,"
        f" {accuracy.spectral_tolerance:.2g} of a value between spectral points,"
        f" {accuracy.tilted_faces_k:.2g} K on tilted faces ({job.ambient_harmonics} harmonics),"
        f" {accuracy.solver_steps} steps of the heat balance, {accuracy.negligible_k:.2g} K omitted; mat"
        " report measures the pixel"
    )


def _as_json(result: JobCheck) -> dict[str, Any]:
    return {
        "sites": list(result.sites),
        "files": result.files,
        "states": result.states,
        "warnings": [*result.warnings, *result.continua],
        "materials": result.materials,
        "surfaces": result.surfaces,
        "left_out": [vars(item) for item in result.left_out],
        "source_up": {source: [list(span) for span in spans] for source, spans in result.source_up.items()},
        **_cost(result),
    }


def _files(result: JobCheck) -> list[str]:
    """A line for each file; of many states one for all files of a kind."""
    by_kind: dict[str, list[str]] = {}
    for name in result.files:
        of_state = (result.sites or len(result.states) > MANY_STATES) and re.fullmatch(r"(?:[^/]+/)?s\d+(.*)", name)
        by_kind.setdefault(of_state[1] if of_state else name, []).append(name)
    return [
        names[0] if len(names) == 1 else f"{names[0]} to {names[-1]}: {len(names)} files" for names in by_kind.values()
    ]


def _states(result: JobCheck) -> list[str]:
    """A line for each run of states that are alike, with their numbers and site."""
    from skyshine.mat.scene.summary import summary_line

    lines: list[str] = []
    numbers, site = count(1), ""
    for (name, text), alike in groupby(result.states, lambda state: (state.get("site", ""), summary_line(state))):
        if name != site:
            numbers, site = count(1), name
        lowest, *others = (f"{number:02d}" for _, number in zip(alike, numbers, strict=False))
        label = f"states {lowest} to {others[-1]}" if others else f"state {lowest}"
        lines.append(f"{f'site {name}, ' if name else ''}{label}: {text}")
    return lines


def _print(result: JobCheck, verbose: bool) -> None:
    from skyshine.mat.scene.summary import summary_text
    from skyshine.mat.threads import core_count

    job, cost = result.loaded.trimmed, result.cost
    of_sites = f" ({len(result.sites)} sites, {result.sites[0]} to {result.sites[-1]})" if result.sites else ""
    click.echo(f"{result.loaded.file}: OK{of_sites}")
    lines = _states(result)
    if not verbose and len(lines) > _LINES:
        lines = [f"{len(result.states)} states: {summary_text(result.states)}"]
    warnings = [*result.continua, *result.warnings]
    hidden = 0 if verbose else max(0, len(warnings) - _LINES)
    for line in [*lines, *(f"warning: {text}" for text in warnings[: len(warnings) - hidden])]:
        click.echo(line)
    if hidden:
        click.echo(f"warning: {hidden} more; --verbose shows them")
    if verbose:
        _print_details(result)
    else:
        of_kind = Counter(name.split(".", 1)[1].removesuffix(".h5") for name in result.files)
        named = ", ".join(f"{number} {kind}" for kind, number in of_kind.items())
        click.echo(f"files: {named}, in {result.loaded.folder / job.output.folder}")
        more = f" and {len(result.materials) - 8} more" if len(result.materials) > 8 else ""
        click.echo(f"materials: {', '.join(result.materials[:8])}{more}")
    for source, spans in result.source_up.items():
        times = ", ".join(f"{start} to {end}" for start, end in spans) or "at no time of the day"
        click.echo(f"{source} up on {result.loaded.trimmed.on_date_of_state(1).site.date}: {times}")
    click.echo(_accuracy(job))
    stages = ", ".join(f"{stage} {seconds:.2g}" for stage, seconds in cost.seconds.items() if seconds >= 0.05)
    cores = core_count()
    click.echo(
        f"time: {_time(cost.elapsed(cores))} on the {cores} cores of this machine, {_time(cost.elapsed(1))} on one"
        + "".join(f", {_time(cost.elapsed(many))} on {many}" for many in (16, 256) if cores < many < 4 * cost.tasks)
    )
    click.echo(f"processor seconds: {cost.total:.0f} ({stages}), estimated within a factor of 1.5")
    click.echo(f"disk: {_size(cost.disk)}; memory: up to {_size(cost.memory)} a process")
    click.echo(_halving(cost))
    if not verbose:
        click.echo("--verbose adds all files, what is skipped or approximated with its bound, and nodes")


def _print_details(result: JobCheck) -> None:
    loaded, job = result.loaded, result.loaded.trimmed
    click.echo("will be built:")
    for line in _files(result):
        click.echo(f"  {line}")
    click.echo(f"materials: {', '.join(result.materials)}")
    for line in result.surfaces:
        click.echo(f"  {line}")
    click.echo("skipped or approximated:" if result.left_out else "skipped or approximated: nothing")
    for item in result.left_out:
        click.echo(f"  {item.what}: {item.why} (error: {item.bound}; to restore: {item.restore})")
    click.echo(_shares(job))
    click.echo(f"size of the tables before compression: {result.bytes / 1e6:.1f} MB")
    if job.atmosphere_grid.writes_tables:
        shape = " x ".join(str(len(nodes)) for nodes in job.atmosphere_axes().values())
        click.echo(f"atmosphere_grid: tables on the five axes of the job too, {shape} nodes")
    if job.surface_grid.tolerance:
        beyond = "stops and names the axis that needs the most" if loaded.insists("surface_grid") else "comes as close"
        click.echo(
            f"surface_grid: nodes are placed until {job.surface_grid.tolerance} is reached;"
            f" {_UNKNOWN.format('temperatures along each axis', job.surface_grid.most_nodes, beyond)}"
        )


def _halving(cost: Resources) -> str:
    """What would take half the time: the first changes that do, or all that are known."""
    changes: list[str] = []
    total = cost.total
    for text, total in cost.less:
        changes.append(text)
        if total <= 0.5 * cost.total:
            return f"half of it: {', '.join(changes)} ({total:.0f} processor seconds)"
    if not changes:
        return "half of it: fewer states or materials"
    return f"less: {', '.join(changes)} ({total:.0f} processor seconds); beyond that fewer states or materials"


def _time(seconds: float) -> str:
    """Seconds in the unit that people say."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


def _size(count: float) -> str:
    if count >= 1e9:
        return f"{count / 1e9:.1f} GB"
    return f"{count / 1e6:.0f} MB" if count >= 1e7 else f"{count / 1e6:.1f} MB"
