"""The end of a command that worked through several textures: what was wrong with some of them."""

from __future__ import annotations

import click

from skyshine.schemas.errors import InputError


def raise_all(problems: list[tuple[str, InputError]], textures: int) -> None:
    """Report each problem in one line on standard error and raise for all of them; does nothing where there is none.

    Raises InputError: the only problem of the only texture, else how many textures failed.

    problems : list of (str, InputError); with the names of their textures.
    textures : int; how many the command worked through.
    """
    if not problems:
        return
    if textures == 1:
        raise problems[0][1]
    for name, problem in problems:
        click.echo(f"tmm: texture '{name}': {problem}", err=True)
    raise InputError(f"{len(problems)} of {textures} textures failed, see above; the others are finished")
