"""Pages of the commands, from the texts of their ``--help``."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import click

from skyshine.mat import cli as mat_cli
from skyshine.tmm import cli as tmm_cli

GROUPS: dict[str, click.Group] = {"mat": mat_cli.main, "tmm": tmm_cli.main}


def page(name: str) -> str:
    """Text of the page of ``mat`` or ``tmm``: every command with its arguments, options and example."""
    group = GROUPS[name]
    lines = [f"# Commands of `{name}`", "", "Generated from the commands themselves: `--help` prints the same.", ""]
    lines += [_prose(group.help or "")]
    for words, context in commands(name):
        lines += _section(words, context)
    return "\n".join(lines) + "\n"


def commands(name: str) -> Iterator[tuple[str, click.Context]]:
    """All commands of a group, those of its groups too, by their words such as ``mat bench stability``."""
    top = click.Context(GROUPS[name], info_name=name, **GROUPS[name].context_settings)
    waiting = [(name, top)]
    while waiting:
        words, context = waiting.pop(0)
        command = context.command
        if context is not top:
            yield words, context
        if isinstance(command, click.Group):
            below = []
            for part in command.list_commands(context):
                subcommand = command.get_command(context, part)
                if subcommand is not None and not subcommand.hidden:
                    below.append((f"{words} {part}", click.Context(subcommand, info_name=part, parent=context)))
            waiting = below + waiting


def _section(words: str, context: click.Context) -> list[str]:
    command = context.command
    usage = " ".join([words, *command.collect_usage_pieces(context)])
    lines = ["", f"## `{words}`", "", "```text", usage, "```", "", _prose(command.help or "")]
    rows = [record for option in command.get_params(context) if (record := option.get_help_record(context))]
    rows = [row for row in rows if row[1] and not row[0].endswith("--help")]  # the usage shows arguments
    if rows:
        lines += ["", "| option | what |", "|---|---|"]
        lines += [f"| {_code(option)} | {_escaped(what)} |" for option, what in rows]
    examples = re.findall(r"Example: (.*?)(?=\s*Example: |\Z)", command.epilog or "", re.DOTALL)
    if examples:
        lines += ["", "```sh", *(" ".join(example.split()) for example in examples), "```"]
    return lines


def _prose(text: str) -> str:
    """Paragraphs of a help text; lines that it keeps as they are become code."""
    parts: list[str] = []
    for part in re.split(r"\n\s*\n", text.strip()):
        verbatim = part.startswith("\b")
        parts.append(f"```text\n{part.lstrip(chr(8)).strip(chr(10))}\n```" if verbatim else _escaped(part))
    return "\n\n".join(parts)


def _code(text: str) -> str:
    return "`" + text.replace("|", "\\|") + "`"


def _escaped(text: Any) -> str:
    """Words of a help text as Markdown in a line or a cell."""
    return re.sub(r"([|<*\[\]_])", r"\\\1", " ".join(str(text).split()))
