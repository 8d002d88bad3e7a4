"""``mat info``: databases as text or as pictures, and the ready states of the air."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from skyshine.mat.commands import completions
from skyshine.schemas.commands import echo_table, emit_json, json_option
from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.quantity import quantity

ALL_PRESETS = "all"  # what --preset without a name means
GRID = "grid"  # group of the tables on five axes

if TYPE_CHECKING:
    from skyshine.schemas.hdf5 import Group


@click.command(epilog="Example: mat info built/s01b02.atmq.h5 --out atmosphere.png")
@click.argument("files", nargs=-1, type=click.Path())
@click.option("--out", type=click.Path(), help="Draw FILE into this PNG file, several FILES into this folder.")
@click.option(
    "--preset",
    shell_complete=completions.presets,
    is_flag=False,
    flag_value=ALL_PRESETS,
    metavar="[NAME]",
    help="Show the keys of a ready state of the air (`preset: NAME` in a job), or without NAME list all of them.",
)
@json_option
def command(files: tuple[str, ...], out: str | None, preset: str | None, as_json: bool) -> None:
    """Show the content of FILES: versions, axes, quantities, their stated errors and the cost of their build.

    With --out, draw them: temperatures, atmospheric quantities, band properties.
    """
    if preset is not None:
        _show_presets(preset, as_json)
        return
    if not files:
        raise InputError("no file is named; allowed: databases, or --preset")
    if out is not None:
        _draw(files, out)
        return
    contents = {file: _content(file) for file in files}
    if as_json:
        emit_json(contents[files[0]] if len(files) == 1 else {"files": contents})
        return
    for file, content in contents.items():
        _print(file, content)


def _show_presets(name: str, as_json: bool) -> None:
    import yaml

    from skyshine.mat.job.presets import presets

    by_name = presets()
    if name == ALL_PRESETS:
        if as_json:
            emit_json(by_name)
        else:
            echo_table(("preset", "what"), [(key, content["description"]) for key, content in by_name.items()])
        return
    if name not in by_name:
        raise InputError(f"found the preset '{name}'; {nearest(name, by_name)}")
    if as_json:
        emit_json(by_name[name])
    else:
        click.echo(yaml.safe_dump(by_name[name], sort_keys=False, allow_unicode=True, width=120), nl=False)


def _draw(files: tuple[str, ...], out: str) -> None:
    """Draw one file as a PNG, several into a folder."""
    from pathlib import Path

    from skyshine.mat.tables.pictures import draw

    target = Path(out)
    if len(files) == 1 and target.suffix.lower() != ".png":
        raise InputError(f"found --out '{out}'; allowed: a name that ends in .png")
    for file in files:
        if file.endswith(".tmm.h5"):
            raise InputError("contains a texture; draw it with 'tmm preview'", file=file)
    try:
        if len(files) == 1:
            click.echo(draw(files[0], target))
            return
        target.mkdir(parents=True, exist_ok=True)
        for file in files:
            click.echo(draw(file, target / (Path(file).name.removesuffix(".h5") + ".png")))
    except OSError as error:
        raise InputError(
            f"cannot be written: {error.strerror or error}; name another place with --out", file=target
        ) from None


def _content(file: str) -> dict[str, Any]:
    """Content of a file, that of its tables on five axes apart."""
    from pathlib import Path

    from skyshine.mat.tables.build_record import cost_of
    from skyshine.schemas.hdf5 import read_file

    root, attributes = read_file(file, lazy=True)
    grid = {name: _described(group) for name, group in root.groups.items() if name == GRID}
    return {
        "attributes": {name: _shown(value) for name, value in attributes.items() if name != "job"},
        **_described(root),
        "groups": list(root.groups),
        **grid,
        "job": str(attributes.get("job", "")),
        "cost": _cost(cost_of(Path(file))),
    }


def _described(group: Group) -> dict[str, Any]:
    """Axes and arrays of a group, and what it states of its errors."""
    axes = {
        name: {"units": axis.units, "nodes": len(axis.values), "long_name": axis.long_name}
        | ({"from": float(axis.values[0]), "to": float(axis.values[-1])} if axis.values.dtype.kind != "O" else {})
        for name, axis in group.axes.items()
    }
    variables = {
        name: {"units": v.units, "axes": list(v.dims), "shape": list(v.shape), "long_name": v.long_name}
        for name, v in group.variables.items()
    }
    return {"axes": axes, "variables": variables, "accuracy": _accuracy(group)}


def _accuracy(root: Group) -> dict[str, Any]:
    group = root.groups.get("accuracy")
    if group is None:
        return {}
    result: dict[str, Any] = {"attributes": {name: _shown(value) for name, value in group.attributes.items()}}
    for name, variable in group.variables.items():
        labels = [[str(label) for label in group.axes[dim].values] for dim in variable.dims]
        result[name] = {"units": variable.units, "values": _labelled(labels, variable.data.tolist())}
    return result


def _labelled(labels: list[list[str]], values: Any) -> Any:
    """Values of an array by the names of its axes, outer ones first."""
    if not labels:
        return _finite(values)
    return {name: _labelled(labels[1:], value) for name, value in zip(labels[0], values, strict=True)}


def _cost(entry: dict[str, Any] | None) -> dict[str, Any]:
    """Seconds by stage of the task that wrote a file; the task may have written other files too."""
    stages = {} if entry is None else entry["stages"]
    return {str(stage): quantity(spent, "s") for stage, spent in stages.items() if isinstance(spent, int | float)}


def _finite(value: object) -> object:
    import math

    return value if not isinstance(value, float) or math.isfinite(value) else None


def _print(file: str, content: dict[str, Any]) -> None:
    click.echo(file)
    for name, value in content["attributes"].items():
        click.echo(f"  {name}: {value}")
    _print_described(content)
    if content["groups"]:
        click.echo(f"  groups: {', '.join(content['groups'])}")
    if GRID in content:
        click.echo(f"  {GRID}: tables on five axes, evaluated from the arrays above")
        _print_described(content[GRID])
    if content["cost"]:
        stages = ", ".join(f"{stage} {spent['value']:.3g} s" for stage, spent in content["cost"].items())
        click.echo(f"  cost, with the files of the same task: {stages}")


def _print_described(group: dict[str, Any]) -> None:
    axes = [
        (name, str(axis["nodes"]), *(f"{axis[key]:g}" if key in axis else "" for key in ("from", "to")), axis["units"])
        for name, axis in group["axes"].items()
    ]
    echo_table(("axis", "nodes", "from", "to", "units"), axes)
    quantities = [(name, v["units"], v["long_name"], " x ".join(v["axes"])) for name, v in group["variables"].items()]
    echo_table(("quantity", "units", "what", "axes"), quantities)
    _print_accuracy(group["accuracy"])


def _print_accuracy(accuracy: dict[str, Any]) -> None:
    """A table for the measures of each set of names, such as quantities, or their parts."""
    tables: dict[tuple[str, ...], dict[str, dict[str, float | None]]] = {}
    for name, measured in accuracy.items():
        if name != "attributes":
            rows = _rows(measured["values"])
            tables.setdefault(tuple(rows), {})[name] = rows
    for names, columns in tables.items():
        measured = [name for name in names if any(rows[name] for rows in columns.values())]  # parts may have no points
        cells = [(name, *(_number(rows[name]) for rows in columns.values())) for name in measured or names]
        echo_table(("stated error", *columns), cells)
    for name, value in accuracy.get("attributes", {}).items():
        click.echo(f"  {name}: {value}")


def _rows(values: dict[str, Any]) -> dict[str, float | None]:
    """Values by one name; those of parts by that of the whole and theirs."""
    rows: dict[str, float | None] = {}
    for name, value in values.items():
        parts = value if isinstance(value, dict) else {"": value}
        rows |= {f"{name} {part}".strip(): number for part, number in parts.items()}
    return rows


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"


def _shown(value: Any) -> str:
    """A value of an attribute as text, a number with six digits."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)
