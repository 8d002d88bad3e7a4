"""``mat verify``: check databases."""

import click

from skyshine.schemas.commands import emit_json, json_option
from skyshine.schemas.errors import CheckFailed


@click.command(epilog="Example: mat verify built/*.h5")
@click.argument("files", nargs=-1, required=True, type=click.Path())
@json_option
def command(files: tuple[str, ...], as_json: bool) -> None:
    """Check layout, units, finite values, physical laws and digest of FILES; exit status 1 if one fails."""
    from skyshine.mat.tables.verify import problems

    problems_of = {file: problems(file) for file in files}
    if as_json:
        emit_json({"files": problems_of, "ok": not any(problems_of.values())})
    else:
        for file, wrong in problems_of.items():
            for line in wrong or ["OK"]:
                click.echo(f"{file}: {line}")
    bad = [file for file, wrong in problems_of.items() if wrong]
    if bad:
        raise CheckFailed(f"{len(bad)} of {len(files)} files fail: {', '.join(bad)}")
