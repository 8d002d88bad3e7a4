"""``mat info``: the content of a database."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option
from skyshine.schemas.quantity import quantity

if TYPE_CHECKING:
    from skyshine.schemas.hdf5 import Group


@click.command(epilog="Example: mat info built/s01b02.atmq.h5")
@click.argument("file", type=click.Path())
@json_option
def command(file: str, as_json: bool) -> None:
    """Show the content of FILE: versions, axes, quantities, their stated errors and the cost of their build."""
    from pathlib import Path

    from skyshine.mat.tables.build_record import cost_of
    from skyshine.schemas.hdf5 import read_file

    root, attributes = read_file(file, lazy=True)
    content = _content(root, attributes) | {"cost": _cost(cost_of(Path(file)))}
    if as_json:
        emit_json(content)
    else:
        _print(file, content)


def _content(root: Group, attributes: dict[str, Any]) -> dict[str, Any]:
    axes = {
        name: {"units": axis.units, "nodes": len(axis.values), "long_name": axis.long_name}
        | ({"from": float(axis.values[0]), "to": float(axis.values[-1])} if axis.values.dtype.kind != "O" else {})
        for name, axis in root.axes.items()
    }
    variables = {
        name: {"units": v.units, "axes": list(v.dims), "shape": list(v.shape), "long_name": v.long_name}
        for name, v in root.variables.items()
    }
    return {
        "attributes": {name: str(value) for name, value in attributes.items() if name != "job"},
        "axes": axes,
        "variables": variables,
        "groups": list(root.groups),
        "accuracy": _accuracy(root),
        "job": str(attributes.get("job", "")),
    }


def _accuracy(root: Group) -> dict[str, Any]:
    group = root.groups.get("accuracy")
    if group is None:
        return {}
    result: dict[str, Any] = {"attributes": {name: str(value) for name, value in group.attributes.items()}}
    for name, variable in group.variables.items():
        labels = group.axes[variable.dims[0]].values
        result[name] = {
            "units": variable.units,
            "values": {str(k): _finite(v) for k, v in zip(labels, variable.data.tolist(), strict=True)},
        }
    return result


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
    axes = [
        (name, str(axis["nodes"]), *(f"{axis[key]:g}" if key in axis else "" for key in ("from", "to")), axis["units"])
        for name, axis in content["axes"].items()
    ]
    echo_table(("axis", "nodes", "from", "to", "units"), axes)
    quantities = [(name, v["units"], v["long_name"], " x ".join(v["axes"])) for name, v in content["variables"].items()]
    echo_table(("quantity", "units", "what", "axes"), quantities)
    if content["groups"]:
        click.echo(f"  groups: {', '.join(content['groups'])}")
    _print_accuracy(content["accuracy"])
    if content["cost"]:
        stages = ", ".join(f"{stage} {spent['value']:.3g} s" for stage, spent in content["cost"].items())
        click.echo(f"  cost, with the files of the same task: {stages}")


def _print_accuracy(accuracy: dict[str, Any]) -> None:
    measures = {name: value for name, value in accuracy.items() if name != "attributes"}
    for spectral in (False, True):
        chosen = {name: m["values"] for name, m in measures.items() if name.startswith("spectral_") is spectral}
        rows: dict[str, Any] = next(iter(chosen.values()), {})
        cells = [(row, *(_number(values[row]) for values in chosen.values())) for row in rows]
        echo_table(("stated error", *chosen), cells)
    for name, value in accuracy.get("attributes", {}).items():
        click.echo(f"  {name}: {value}")


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"
