"""``tmm usage``: share of each material in textures."""

import click

from skyshine.schemas.commands import emit_json, json_option
from skyshine.schemas.quantity import quantity


@click.command(epilog="Example: tmm usage build/*.tmm.h5 --json")
@click.argument("files", type=click.Path(), nargs=-1, required=True)
@json_option
def command(files: tuple[str, ...], as_json: bool) -> None:
    """Print the share of each material in the texels of FILES: of each file, and of all together."""
    from skyshine.tmm.database.usage import library_usage, read_usage

    shares = {file: read_usage(file) for file in files}
    total = library_usage(files)
    if as_json:
        emit_json(
            {
                "files": {
                    file: {name: quantity(share, "1") for name, share in usage.items()}
                    for file, usage in shares.items()
                },
                "all": {name: quantity(share, "1") for name, share in total.items()},
            }
        )
        return
    for file, usage in [*shares.items(), *([("all", total)] if len(files) > 1 else [])]:
        click.echo(f"{file}:")
        for name, share in sorted(usage.items(), key=lambda item: -item[1]):
            click.echo(f"  {100 * share:5.1f} %  {name}")
