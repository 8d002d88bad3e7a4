"""``tmm init``: a starter job."""

import click


@click.command(epilog="Example: tmm init demo && tmm classify demo/job.tmm.yaml")
@click.argument("folder", type=click.Path())
def command(folder: str) -> None:
    """Write a starter job, with the picture it needs, into FOLDER. Files that are there already are not touched.

    The JSON Schema beside it lets editors with a YAML language server complete and check its keys.
    """
    from importlib import resources
    from pathlib import Path

    from skyshine.schemas.starter import write_starter

    target, source = Path(folder), Path(str(resources.files("skyshine.examples"))) / "textures"
    files = {"job.tmm.yaml": source / "job.tmm.yaml", "yellowstone_road.png": source / "yellowstone_road.png"}
    write_starter(target, files, "name an empty folder")
    click.echo(f"{target / 'job.tmm.yaml'}: edit it, then run: tmm classify {target / 'job.tmm.yaml'}")
