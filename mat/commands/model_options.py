"""Options of commands made of fields of the job's models: name, limits, choices and help are those of the key."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

import click
from click.shell_completion import CompletionItem
from pydantic import BaseModel

from skyshine.schemas.commands import Command
from skyshine.schemas.documents import plain_value
from skyshine.schemas.errors import InputError

Taker = TypeVar("Taker", bound=Callable[..., Any] | click.Command)  # what takes an option

_NUMBERS: dict[str, Any] = {"number": click.FloatRange, "integer": click.IntRange}
_METAVARS = {"array": "LIST", "integer": "NUMBER", "number": "NUMBER", "string": "FILE"}


class YamlValue(click.ParamType):  # type: ignore[type-arg]  # generic only since click 8.5
    """A value as a job writes it: text, number, list or mapping.

    Attributes
    ----------
    names : tuple of str
        Names that complete the word; where there are none, files do.
    """

    name = "yaml"

    def __init__(self, names: Iterable[str]) -> None:
        self.names = tuple(names)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):
            return value
        try:
            return plain_value(value, "", 1)
        except InputError as error:
            self.fail(error.message, param, ctx)

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        if not self.names:
            return [CompletionItem(incomplete, type="file")]
        return [CompletionItem(name) for name in self.names if name.startswith(incomplete)]


def in_order(options: Sequence[Callable[[Command], Command]]) -> Callable[[Command], Command]:
    """Adds options to a command, whose help lists them in this order, as a decorator."""

    def add(command: Command) -> Command:
        for option in reversed(options):
            command = option(command)
        return command

    return add


def model_options(
    model: type[BaseModel], fields: Mapping[str, str], defaults: Mapping[str, str] | None = None
) -> Callable[[Command], Command]:
    """Adds an option for each of some fields of a model to a command, as a decorator; what is not given is None.

    Parameters
    ----------
    fields : mapping of str to str
        Field by the name of the parameter, which is that of the option with dashes.
    defaults : mapping of str to str, optional
        What the help states as default in place of the model's, by the name of the parameter.

    Examples
    --------
    >>> from skyshine.mat.job.site import Site
    >>> command = model_options(Site, {"latitude": "latitude_deg"})(click.command(lambda latitude: None))
    >>> command.params[0].opts, command.params[0].type
    (['--latitude'], <FloatRange -90<=x<=90>)
    """
    schema = model.model_json_schema()
    options = []
    for name, field in fields.items():
        content = schema["properties"][field]
        default = (defaults or {}).get(name, _default(content.get("default")))
        help_text = content.get("description", "") + (f"  [default: {default}]" if default else "")
        metavar, kind = _kind(content)
        options.append(
            click.option(
                f"--{name.replace('_', '-')}",
                name,
                type=kind,
                metavar=metavar,
                help=help_text,
            )
        )

    return in_order(options)


def axis_option(
    model: type[BaseModel], axis: str, option: str, default: float | None = None, note: str = "", what: str = ""
) -> Callable[[Taker], Taker]:
    """An option for one value on an axis of a grid: limits and help are those of the key; on an axis around the whole
    circle -360 to 360.

    Parameters
    ----------
    axis : str
        Key of the grid, which ends in its unit.
    option : str
        Name of the option, with that of its parameter after a space where they differ.
    note : str, optional
        End of the help.
    what : str, optional
        Start of the help, in place of the key's.

    Examples
    --------
    >>> from skyshine.mat.job.atmosphere import AtmosphereGrid
    >>> command = axis_option(AtmosphereGrid, "elevation_deg", "--elevation")(click.command(lambda elevation: None))
    >>> command.params[0].help, command.params[0].type
    ('Elevation of the line of sight at the observer, degree.', <FloatRange -90<=x<=90>)
    """
    content = model.model_json_schema()["properties"][axis]
    items = next(part for part in content.get("anyOf", [content]) if part.get("type") == "array")["items"]
    start = what or re.split("[;.:]", content["description"])[0]
    unit = {"km": "km", "deg": "degree"}[axis.rpartition("_")[2]]
    low, high = items["minimum"], items["maximum"]
    return click.option(
        *option.split(),
        type=click.FloatRange(-360, 360) if unit == "degree" and high - low > 359 else click.FloatRange(low, high),
        default=default,
        show_default=default is not None,
        metavar="NUMBER",
        help=f"{start}, {unit}{note}.",
    )


def _default(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value or "")


def _kind(content: Mapping[str, Any]) -> tuple[str, Any]:
    """Placeholder and type of an option for values of a JSON Schema."""
    choices = [inner for part in content.get("anyOf", [content]) for inner in part.get("oneOf", [part])]
    kinds = [part for part in choices if part.get("type") != "null"]
    (first, *others) = kinds
    if not others and first.get("type") in _NUMBERS:
        lower, upper = first.get("exclusiveMinimum"), first.get("exclusiveMaximum")
        limits = {"min": first.get("minimum", lower), "min_open": lower is not None}
        limits |= {"max": first.get("maximum", upper), "max_open": upper is not None}
        return "NUMBER", _NUMBERS[first["type"]](**limits)
    if not others and "enum" in first:
        return "NAME", click.Choice(first["enum"])
    names = [name for kind in kinds for name in (kind.get("enum") or [kind[key] for key in ("const",) if key in kind])]
    names += content.get("examples", [])
    return "|".join(dict.fromkeys(_word(kind, names) for kind in kinds)), YamlValue(names)


def _word(kind: Mapping[str, Any], names: Sequence[str]) -> str:
    """Placeholder of one of the kinds of value."""
    if "enum" in kind or "const" in kind or (kind.get("type") == "string" and names):
        return "NAME"
    return _METAVARS.get(kind.get("type", ""), "MAPPING")
