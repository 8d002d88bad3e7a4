"""`mat presets`: ready atmospheric states."""

from __future__ import annotations

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option
from skyshine.schemas.errors import InputError, nearest


@click.command(epilog="Example: mat presets overcast_stratus")
@click.argument("name", required=False)
@json_option
def command(name: str | None, as_json: bool) -> None:
    """List the ready states, or show the keys of the one called NAME.

    A job's state takes one with `preset: NAME`; keys written beside it replace those of the preset.
    """
    import yaml

    from skyshine.mat.job.presets import presets

    by_name = presets()
    if name is not None and name not in by_name:
        raise InputError(f"found the preset '{name}'; {nearest(name, by_name)}")
    if as_json:
        emit_json(by_name if name is None else by_name[name])
    elif name is None:
        echo_table(("preset", "what"), [(key, content["description"]) for key, content in by_name.items()])
    else:
        click.echo(yaml.safe_dump(by_name[name], sort_keys=False, allow_unicode=True, width=120), nl=False)
