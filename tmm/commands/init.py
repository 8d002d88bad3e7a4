"""``tmm init``: a starter job."""

import shutil

import click

from skyshine.schemas.errors import InputError


@click.command(epilog="Example: tmm init demo && tmm classify demo/job.tmm.yaml")
@click.argument("folder", type=click.Path())
def command(folder: str) -> None:
    """Write a starter job, with the picture it needs, into FOLDER. Files that are there already are not touched."""
    from importlib import resources
    from pathlib import Path

    target, source = Path(folder), resources.files("skyshine.examples") / "textures"
    files = {"demo.tmm.yaml": "job.tmm.yaml", "yellowstone_road.png": "yellowstone_road.png"}
    for name in files.values():
        if (target / name).exists():
            raise InputError("exists already; name an empty folder", file=target / name)
    try:
        target.mkdir(parents=True, exist_ok=True)
        for name, new in files.items():
            with resources.as_file(source / name) as file:
                shutil.copyfile(file, target / new)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}; name another folder", file=target) from None
    click.echo(f"{target / 'job.tmm.yaml'}: edit it, then run: tmm classify {target / 'job.tmm.yaml'}")
