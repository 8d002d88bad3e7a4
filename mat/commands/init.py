"""``mat init``: a starter job."""

import click

from skyshine.mat.commands import completions


@click.command(epilog="Example: mat init demo && mat build demo/job.yaml")
@click.argument("folder", type=click.Path())
@click.option(
    "--example",
    shell_complete=completions.examples,
    default="starter",
    show_default=True,
    help="Name of the job: airfield, dead_sea, desert_vehicle, frames, ship, street, urban_canyon, year.",
)
def command(folder: str, example: str) -> None:
    """Write a starter job, with the picture it needs, into FOLDER. Files that are there already are not touched.

    The JSON Schemas beside it let editors with a YAML language server complete and check its keys.
    """
    from pathlib import Path

    from skyshine.mat.api.examples import starter_files
    from skyshine.schemas.starter import write_starter

    target = Path(folder)
    files = {file.name: file for file in starter_files(example)}
    write_starter(target, files, f"name an empty folder, or build it: mat build {target / 'job.yaml'}")
    click.echo(f"{target / 'job.yaml'}: edit it, then run: mat build {target / 'job.yaml'}")
