"""Words that a shell completes: materials, bands of a folder of databases, packaged jobs, quantities of a database."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import click
from click.shell_completion import CompletionItem

from skyshine.schemas.errors import InputError

Completer = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


def completer(names_of: Callable[[click.Context], Iterable[str]], *, files: bool = False) -> Completer:
    """A function for `shell_complete`: names that begin as the word does, then files where the word may be one."""

    def complete(context: click.Context, _parameter: click.Parameter, incomplete: str) -> list[CompletionItem]:
        try:
            names = [CompletionItem(name) for name in names_of(context) if name.startswith(incomplete)]
        except (InputError, OSError):  # a shell shows no errors: there is nothing to complete
            names = []
        return names + ([CompletionItem(incomplete, type="file")] if files else [])

    return complete


def _materials(_context: click.Context) -> tuple[str, ...]:
    from skyshine.materials.library import load_library

    return load_library().names


def _bands(context: click.Context) -> list[str]:
    folder = context.params.get("folder") or next(iter(context.args), ".")  # arguments before an option without value
    return sorted(file.name.removesuffix(".band.h5") for file in Path(folder).glob("*.band.h5"))


def _quantities(context: click.Context) -> list[str]:
    from skyshine.mat.tables.loader import open_table

    return open_table(context.params["file"]).quantities


def _examples(_context: click.Context) -> list[str]:
    from skyshine.mat.api.examples import example_names

    return example_names()


def _presets(_context: click.Context) -> Iterable[str]:
    from skyshine.mat.job.presets import presets

    return presets()


materials = completer(_materials)
materials_or_files = completer(_materials, files=True)
bands = completer(_bands)
quantities = completer(_quantities)
examples = completer(_examples)
presets = completer(_presets)
