"""``tmm usage``: share of each material in textures."""

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option
from skyshine.schemas.quantity import quantity


@click.command(epilog="Example: tmm usage build/*.tmm.h5 --json")
@click.argument("files", type=click.Path(), nargs=-1, required=True)
@click.option("--chunks", is_flag=True, help="Of each chunk of 256 x 256 texels instead, row by row.")
@json_option
def command(files: tuple[str, ...], chunks: bool, as_json: bool) -> None:
    """Share of each material in the texels of FILES: of each file, and of all together."""
    from skyshine.tmm.database.usage import library_usage, read_usage

    if chunks:
        _by_chunk(files, as_json)
        return
    each = {file: read_usage(file) for file in files}
    total = library_usage(files)
    if as_json:
        emit_json(
            {
                "files": {
                    file: {name: quantity(share, "1") for name, share in usage.items()} for file, usage in each.items()
                },
                "all": {name: quantity(share, "1") for name, share in total.items()},
            }
        )
        return
    for file, usage in [*each.items(), *([("all", total)] if len(files) > 1 else [])]:
        click.echo(f"{file}:")
        for name, share in sorted(usage.items(), key=lambda item: -item[1]):
            click.echo(f"  {100 * share:5.1f} %  {name}")


def _by_chunk(files: tuple[str, ...], as_json: bool) -> None:
    from skyshine.tmm.database.usage import CHUNK, chunk_usage

    each = {file: chunk_usage(file) for file in files}
    if as_json:
        chunks = {file: {"materials": names, "share": quantity(share, "1")} for file, (names, share) in each.items()}
        emit_json({"chunk_texels": CHUNK, "files": chunks})
        return
    for file, (names, share) in each.items():
        click.echo(f"{file}: percent of the texels of each chunk")
        rows, columns, _ = share.shape
        table = [
            [str(y), str(x), *(f"{100 * part:.1f}" for part in share[y, x])]
            for y in range(rows)
            for x in range(columns)
        ]
        echo_table(("row", "column", *names), table)
