"""``mat init``: a starter job."""

import shutil

import click

from skyshine.schemas.errors import InputError


@click.command(epilog="Example: mat init demo && mat build demo/job.yaml")
@click.argument("folder", type=click.Path())
@click.option(
    "--example",
    default="starter",
    show_default=True,
    help="Which job: airfield, dead_sea, desert_vehicle, ship, street, urban_canyon, year.",
)
def command(folder: str, example: str) -> None:
    """Write a starter job, with the picture it needs, into FOLDER. Files that are there already are not touched."""
    from pathlib import Path

    from skyshine.mat.api.examples import starter_files

    target = Path(folder)
    files = starter_files(example)
    for file in files:
        if (target / file.name).exists():
            raise InputError(
                f"exists already; name an empty folder, or build it: mat build {target}", file=target / file.name
            )
    try:
        target.mkdir(parents=True, exist_ok=True)
        for file in files:
            shutil.copyfile(file, target / file.name)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}; name another folder", file=target) from None
    click.echo(f"{target / 'job.yaml'}: edit it, then run: mat build {target / 'job.yaml'}")
