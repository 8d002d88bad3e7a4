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

    The exit status is 1 if a package that all commands need is missing.
    """
    from skyshine.mat.api.installation import installation

    report = installation()
    if as_json:
        emit_json(report)
    else:
        _print(report)
    if report["missing"]:
        raise CheckFailed(f"lacks {', '.join(report['missing'])}; install skyshine again with pip")


def _print(report: dict[str, Any]) -> None:
    click.echo(f"skyshine {report['skyshine']}, Python {report['python']}, {report['platform']}")
    click.echo(f"materials {report['materials']}, band model {report['band_model']}")
    click.echo(f"packages: {', '.join(f'{name} {version}' for name, version in report['packages'].items())}")
    for name, lacking in report["extras"].items():
        advice = f"lacks {', '.join(lacking)}: pip install 'skyshine[{name}]'" if lacking else "complete"
        click.echo(f"extra {name}: {advice}")
    click.echo(f"threads: {report['threads']} of {report['cores']} cores in a process")
    cache = report["cache"]
    click.echo(f"cache: {cache['folder']}, {cache['files']} files, {cache['bytes'] / 1e6:.1f} MB")
    for name, value in report["environment"].items():
        click.echo(f"{name}={value}")
