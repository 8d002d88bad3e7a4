"""``mat query``: one interpolated value with its stated error."""

import math

import click

from skyshine.mat.commands import completions
from skyshine.schemas.commands import emit_json, json_option
from skyshine.schemas.errors import InputError
from skyshine.schemas.plain_numbers import plain_number
from skyshine.schemas.quantity import quantity


@click.command(
    epilog="Example: mat query built/s01.htt.h5 temperature material=concrete altitude=0 azimuth=180 slope=30 time=14.5"
)
@click.argument("file", type=click.Path())
@click.argument("name", metavar="QUANTITY", shell_complete=completions.quantities)
@click.argument("where", nargs=-1, metavar="AXIS=VALUE...")
@click.option("--clamp", is_flag=True, help="Clamp values outside an axis to its nearest end.")
@json_option
def command(file: str, name: str, where: tuple[str, ...], clamp: bool, as_json: bool) -> None:
    """Interpolate QUANTITY of FILE at a value for each axis, and print the error that the file states."""
    from skyshine.mat.api.query import query

    coordinates = dict(_pair(text) for text in where)
    result = query(file, name, clamp=clamp, **coordinates)
    value, units, error = float(result.value), result.units, result.error
    if as_json:
        stated = {measure: quantity(amount, _units(measure, units)) for measure, amount in error.items()}
        emit_json({"quantity": name, **quantity(value, units), "at": coordinates, "stated_error": stated})
        return
    click.echo(f"{name} = {value:.7g} {units}")
    for measure, amount in error.items():
        if measure == "points":
            click.echo(f"  measured at {amount:.0f} points between the nodes")
        elif math.isfinite(amount):  # radiances of sunlit bands have no equivalent temperature
            click.echo(
                f"  interpolation error, {measure.removesuffix('_kelvin').removesuffix('_percent')}: {amount:.3g}"
                f" {_units(measure, units)}"
            )


def _units(measure: str, units: str) -> str:
    if measure == "points":
        return "1"
    return "K" if measure.endswith("_kelvin") else "percent" if measure.endswith("_percent") else units


def _pair(text: str) -> tuple[str, float | str]:
    axis, equals, value = text.partition("=")
    if not equals or not axis:
        raise InputError(f"found '{text}'; allowed: AXIS=VALUE, such as range=5")
    if axis == "material" and not (value.isascii() and value.lstrip("-").isdigit()):
        return axis, value
    try:
        return axis, int(value) if axis == "material" else plain_number(value)
    except ValueError:
        raise InputError(f"found '{value}' for the axis '{axis}'; allowed: a number, such as {axis}=14.5") from None
