"""``mat build``: build the databases of a job."""

from typing import Any

import click

from skyshine.schemas.commands import allow_outside_option, emit_json, json_option, log_lines, progress
from skyshine.schemas.progress import silent

# What a quantity's error has beside that of the nodes, which are placed to the tolerance.
_ADDS = {
    "ambient_radiance_harmonics": "accuracy.tilted_faces_k adds to the error of the nodes",
    "shaded_temperature": "the response to shade has no nodes to add",
}


@click.command(epilog="Example: mat build demo/job.yaml --jobs 2")
@click.argument("job", type=click.Path())
@click.option("--out", type=click.Path(), help="Output folder; by default the one that the job names.")
@click.option(
    "--jobs", type=click.IntRange(1, 256), default=None, help="Number of worker processes (default: CPU count)."
)
@click.option("--fresh", is_flag=True, help="Build everything again; without it, finished files are kept.")
@click.option(
    "--executor", metavar="dask:ADDRESS", help="Send the tasks to a Dask cluster; files come back to the output folder."
)
@click.option("--part", metavar="I/N", help="Build one of N disjoint parts of the states, for job arrays.")
@click.option(
    "--pictures/--no-pictures",
    default=None,
    help="Draw pictures of all files when they are ready, also those of an earlier build; by default as the job says.",
)
@click.option(
    "words",
    "--verbose",
    flag_value="verbose",
    help="Print one line per finished file to standard error instead of a progress bar.",
)
@click.option("words", "--quiet", flag_value="quiet", help="Print only warnings and errors.")
@allow_outside_option
@json_option
def command(job: str, words: str | None, as_json: bool, **settings: Any) -> None:
    """Build the databases of JOB. Files that the same job has built before are kept."""
    from skyshine.mat.api.build import build

    built = build(job, progress={"verbose": log_lines, "quiet": silent}.get(words or "", progress), **settings)
    if as_json:
        emit_json({**vars(built), "folder": str(built.folder)})
        return
    for name, entry in built.files.items() if words is None else ():
        click.echo(f"  {name}  {'kept' if entry['kept'] else 'built'}{_reached(entry)}")
    for warning in built.warnings:
        click.echo(f"warning: {warning}")
    if words == "quiet":
        return
    if built.not_of_this_job:
        click.echo(f"  not of this job, left as they are: {', '.join(built.not_of_this_job)}")
    click.echo(f"{built.folder}: {len(built.files)} files in {built.seconds:.1f} s")


def _reached(entry: dict[str, Any]) -> str:
    """What a table reached, and at which cost."""
    cost = f" in {entry['processor_seconds']:.2g} s of processor time" if entry.get("processor_seconds") else ""
    cost = f" with {entry['made_with']}" if "made_with" in entry and not entry["kept"] else cost
    error = entry.get("error_kelvin")
    if error is None:
        return cost
    over = ""
    if "asked" in error:
        reason = _ADDS.get(error["quantity"], "nodes are placed for the radiance of pixels, not for each quantity")
        over = f"; over the {error['asked']:g} K asked: {reason}"
    return f"{cost}: 99 % within {error['p99']:.2g} K, largest {error['maximum']:.2g} K ({error['quantity']}){over}"
