"""``mat convert``: databases of older formats in the present one."""

import click

from skyshine.schemas.commands import emit_json, json_option


@click.command(epilog="Example: mat convert old/*.h5 --out built")
@click.argument("files", nargs=-1, required=True, type=click.Path())
@click.option("--out", required=True, type=click.Path(file_okay=False), help="Folder to write into.")
@json_option
def command(files: tuple[str, ...], out: str, as_json: bool) -> None:
    """Write FILES, databases of an older format, in the present format into a folder; their arrays stay the same."""
    from skyshine.mat.tables.convert import convert, parts_lacking
    from skyshine.mat.tables.files import FORMATS
    from skyshine.tmm.classify import model_file
    from skyshine.tmm.database import layout

    versions = {name: [kind.format_version for kind in kinds] for name, kinds in FORMATS.items()}
    versions |= {part.FILETYPE: [part.FORMAT_VERSION] for part in (layout, model_file)}
    converted = []
    for name in files:
        target, old, new = convert(name, out, versions)
        lacking = parts_lacking(target)
        converted.append({"file": str(target), "from": old, "to": new, "lacks": lacking})
        if not as_json:
            lifted = f"{old} to {new}" if old != new else f"is in the present format, {new}"
            rest = f"; lacks {', '.join(lacking)}: build it again for that" if lacking else ""
            click.echo(f"{target}: {lifted}{rest}")
    if as_json:
        emit_json({"files": converted})
