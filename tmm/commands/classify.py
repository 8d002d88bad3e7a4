"""``tmm classify``: map the textures of a job to materials."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from skyshine.schemas.commands import allow_outside_option, emit_json, json_option, progress
from skyshine.schemas.quantity import quantity
from skyshine.tmm.commands.problems import raise_all

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from skyshine.schemas.errors import InputError
    from skyshine.tmm.job.model import TmmJob
    from skyshine.tmm.mapping.run import Outcome
    from skyshine.tmm.mapping.texture_map import TextureMap
    from skyshine.tmm.mapping.write import Written


@click.command(epilog="Example: tmm classify demo/job.tmm.yaml --out build")
@click.argument("job", type=click.Path())
@click.option("--out", type=click.Path(), help="Output folder; by default the one that the job names.")
@click.option(
    "--fresh", is_flag=True, help="Classify everything again; without it, databases that are still current are kept."
)
@click.option(
    "--jobs",
    type=click.IntRange(1, 256),
    default=1,
    show_default=True,
    help="Number of textures to classify in parallel.",
)
@allow_outside_option
@json_option
def command(job: str, out: str | None, fresh: bool, jobs: int, as_json: bool) -> None:
    """Map the texels of all textures of JOB to materials and write one database for each.

    A texture that cannot be mapped is reported, and the others are finished; the status is 2 then. With --jobs, so many
    processes map one texture each at a time, each in memory of its own.
    """
    from skyshine.materials.library import load_library
    from skyshine.tmm.job.load import load_job

    loaded, folder = load_job(job, load_library())
    reports, problems = [], []
    with progress(len(loaded.textures), "classifying") as advance:
        for report, problem in _results(loaded, folder, out, fresh, jobs):
            reports.append(report)
            if problem is not None:
                problems.append((report["name"], problem))
            advance(1)
    if as_json:
        emit_json({"textures": reports})
    else:
        for report in reports:
            _print(report)
    raise_all(problems, len(reports))


Result = tuple[dict[str, Any], "InputError | None"]


def _results(job: TmmJob, folder: Path, out: str | None, fresh: bool, processes: int) -> Iterator[Result]:
    """Report and problem of each texture, in their order."""
    if processes == 1 or len(job.textures) == 1:
        yield from _classified(job, folder, out, fresh)
        return
    from concurrent.futures import ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool

    from skyshine.schemas.errors import InputError
    from skyshine.schemas.processes import FreshProcesses

    pool = ProcessPoolExecutor(min(processes, len(job.textures)), FreshProcesses())
    alone = [job.model_copy(update={"textures": [entry]}) for entry in job.textures]
    futures = [pool.submit(_in_a_process, single, folder, out, fresh) for single in alone]
    try:
        for future in futures:
            yield from future.result()
    except BrokenProcessPool:
        raise InputError(
            "a process was stopped from outside; memory may have run out: run it again with fewer --jobs, finished"
            " databases are kept"
        ) from None
    finally:
        pool.shutdown(cancel_futures=True)


def _classified(job: TmmJob, folder: Path, out: str | None, fresh: bool) -> Iterator[Result]:
    from skyshine.materials.library import load_library
    from skyshine.tmm.mapping.run import classify

    for outcome in classify(job, folder, out, load_library(), fresh=fresh):
        yield _outcome(outcome), outcome.problem


def _in_a_process(job: TmmJob, folder: Path, out: str | None, fresh: bool) -> list[Result]:
    return list(_classified(job, folder, out, fresh))


def _outcome(outcome: Outcome) -> dict[str, Any]:
    if outcome.mapped is not None and outcome.summary is not None:
        return {"state": "written", **_report(outcome.mapped, outcome.summary, outcome.path)}
    named = {"file": str(outcome.path), "name": outcome.job.name}
    if outcome.problem is not None:
        return {"state": "failed", **named, "error": str(outcome.problem)}
    return {"state": "kept", **named}


def _report(mapped: TextureMap, summary: Written, path: Path) -> dict[str, Any]:
    from skyshine.tmm.mapping.doubts import doubts

    usage = dict(zip(mapped.names, summary.usage.tolist(), strict=True))
    quality = mapped.quality
    return {
        "file": str(path),
        "name": mapped.job.name,
        "way": mapped.job.way,
        "width": mapped.texture.width,
        "height": mapped.texture.height,
        "distinct_colours": mapped.colours.number,
        "usage": {name: quantity(share, "1") for name, share in usage.items()},
        "unknown": quantity(max(1 - sum(usage.values()), 0.0), "1"),
        "mean_confidence": quantity(summary.confidence, "1"),
        "in_shade": None if summary.shade is None else quantity(summary.shade, "1"),
        "expected_accuracy": quantity(summary.confidence_of_known, "1"),
        "held_out_places": quality.areas,
        "held_out_texels": quality.quality.tested,
        "overall_accuracy": quantity(quality.quality.overall_accuracy, "1"),
        "mean_iou": quantity(quality.quality.mean_iou, "1"),
        "calibration_error": quantity(quality.quality.calibration_error, "1"),
        "not_held_out": _not_held_out(mapped),
        "warnings": doubts(mapped, summary),
    }


def _not_held_out(mapped: TextureMap) -> str | None:
    """Why nothing could be held out; None where something was, or there are no seeds."""
    if mapped.seeds is None or mapped.quality.areas:
        return None
    if mapped.seeds.answered.all():
        return "its places were asked for where the map was in doubt; 'tmm suggest --random' asks for a fair sample"
    return "one place a material; draw a second, apart from the first"


def _print(report: dict[str, Any]) -> None:
    if report["state"] == "failed":
        return
    if report["state"] == "kept":
        click.echo(f"{report['file']}: is there already, from the same job and image; kept")
        return
    click.echo(f"{report['file']}: {report['width']} x {report['height']}")
    for name, share in report["usage"].items():
        click.echo(f"  {100 * share['value']:5.1f} %  {name}")
    click.echo(f"  {100 * report['unknown']['value']:5.1f} %  unknown")
    if report["in_shade"] is not None:
        click.echo(f"  {100 * report['in_shade']['value']:5.1f} %  in the shade of the photograph")
    if report["way"] == "seeds":
        click.echo(f"  expected accuracy, by the confidence of its texels: {report['expected_accuracy']['value']:.3f}")
    if report["held_out_places"]:
        click.echo(
            f"  {report['held_out_places']} places of seeds held out (often the clear ones; elsewhere it may be less): "
            f"accuracy {report['overall_accuracy']['value']:.3f}, mean IoU "
            f"{report['mean_iou']['value']:.3f}, calibration error {report['calibration_error']['value']:.3f} "
            f"({report['held_out_texels']} texels)"
        )
    elif report["way"] == "seeds":
        click.echo(f"  accuracy on seeds held out cannot be measured: {report['not_held_out']}")
    for warning in report["warnings"]:
        click.echo(f"  warning: {warning}")
