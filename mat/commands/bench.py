"""``mat bench``: error against run time, measured."""

from __future__ import annotations

from pathlib import Path

import click

from skyshine.mat.commands.front import front
from skyshine.mat.commands.stability import stability


class _JobOrPart(click.Group):
    """A group whose first word is a command or a job: a job, or none, is given to the command `front`."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if not args or self._is_for_front(args[0], ctx):
            args = ["front", *args]
        return super().parse_args(ctx, args)

    def _is_for_front(self, word: str, ctx: click.Context) -> bool:
        if word.startswith("-"):
            return word not in ctx.help_option_names
        is_command = word in self.list_commands(ctx)
        return not is_command and (Path(word).is_file() or Path(word).suffix in (".yaml", ".yml"))


@click.group(
    "bench", cls=_JobOrPart, subcommand_metavar="[JOB | COMMAND] ...", epilog="Example: mat bench demo/job.yaml"
)
def command() -> None:
    """Measure error against run time, both in one run.

    With a JOB, or for the starter job without one, its own front: see 'mat bench front --help'.
    """


for part in (front, stability):
    command.add_command(part)
