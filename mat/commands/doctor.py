"""``mat doctor``: what this installation has and lacks."""

from __future__ import annotations

from typing import Any

import click

from skyshine.schemas.commands import emit_json, json_option
from skyshine.schemas.errors import CheckFailed


@click.command(epilog="Example: mat doctor --json > installation.json")
@json_option
def command(as_json: bool) -> None:
    """Show versions, packages, extras, threads and the cache of this installation.

    Ends with status 1 where a package that all commands need is missing.
    """
    from skyshine.mat.api.installation import installation

    found = installation()
    if as_json:
        emit_json(found)
    else:
        _print(found)
    if found["missing"]:
        raise CheckFailed(f"lacks {', '.join(found['missing'])}; install skyshine again with pip")


def _print(found: dict[str, Any]) -> None:
    click.echo(f"skyshine {found['skyshine']}, Python {found['python']}, {found['platform']}")
    click.echo(f"materials {found['materials']}, band model {found['band_model']}")
    click.echo(f"packages: {', '.join(f'{name} {version}' for name, version in found['packages'].items())}")
    for name, lacking in found["extras"].items():
        advice = f"lacks {', '.join(lacking)}: pip install 'skyshine[{name}]'" if lacking else "complete"
        click.echo(f"extra {name}: {advice}")
    click.echo(f"threads: {found['threads']} of {found['cores']} cores in a process")
    cache = found["cache"]
    click.echo(f"cache: {cache['folder']}, {cache['files']} files, {cache['bytes'] / 1e6:.1f} MB")
    for name, value in found["environment"].items():
        click.echo(f"{name}={value}")
