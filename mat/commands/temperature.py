"""`mat temperature`: one surface through the day, with every flux."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from skyshine.mat.commands import completions
from skyshine.mat.commands.model_options import axis_option, model_options
from skyshine.mat.commands.sight_options import job_option, state_option
from skyshine.mat.job.model import Job
from skyshine.mat.job.own_materials import OwnMaterial
from skyshine.mat.job.site import Site
from skyshine.mat.job.surface import SurfaceGrid, Weather
from skyshine.mat.job.surroundings import StateSurroundings, Wall
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.schemas.commands import emit_json, json_option
from skyshine.schemas.errors import InputError
from skyshine.schemas.quantity import quantity

if TYPE_CHECKING:
    from skyshine.mat.surface.column import ColumnResult


@click.command("temperature")
@click.option(
    "--material",
    shell_complete=completions.materials_or_files,
    required=True,
    metavar="NAME|FILE",
    help="Material of the library, or a file of the layout of ht/.",
)
@axis_option(SurfaceGrid, "slope_deg", "--slope", 0.0)
@axis_option(SurfaceGrid, "azimuth_deg", "--azimuth", 180.0)
@job_option
@state_option
@axis_option(SurfaceGrid, "altitude_km", "--altitude", note="; by default the site's; 0 for --forcing without pressure")
@click.option("--forcing", type=click.Path(), metavar="CSV", help="CSV of measured radiation and weather.")
@model_options(Site, {"latitude": "latitude_deg", "longitude": "longitude_deg"})
@model_options(Weather, {"ground_albedo": "ground_albedo"})
@click.option(
    "--depth",
    type=click.FloatRange(0),
    metavar="M",
    help="Depth below the skin at which the temperature is printed too.",
)
@click.option(
    "--shade",
    multiple=True,
    metavar="HH:MM-HH:MM",
    help="Hours without direct light; repeat for more intervals. An interval whose start is later than "
    "its end crosses midnight.",
)
@model_options(StateSurroundings, {"sky_view": "sky_view"})
@click.option("--facing", type=float, metavar="K", help="Temperature of the wall that hides the rest of the sky.")
@model_options(Wall, {"facing_emissivity": "emissivity"})
@model_options(OwnMaterial, {"absorptance": "absorptance", "emissivity": "emissivity"})
@model_options(Job, {"leaf_area_index": "leaf_area_index"})
@json_option
def command(material: str, job: str | None, forcing: str | None, as_json: bool, **options: Any) -> None:
    """Compute temperature and every flux of one surface through the day.

    Absorbed fluxes count inwards, all others outwards; absorbed = emitted + convection + evaporation + conduction +
    melt. The CSV has the columns time (ISO 8601), air_temperature, relative_humidity, wind_speed in SI and percent, and
    sw_down, or direct_normal and diffuse; air_temperature[C] names another unit; by choice lw_down or cloud_fraction,
    pressure, and wind_height and air_height [m] where wind and air were not measured at 10 and 2 m. Notes list the
    defaults used for missing columns. A weather file of a job may have the same columns. A back by hour is in UTC under
    a CSV, and so are the hours of --shade; with --job they are local clock hours. --latitude and --longitude place the
    Sun where --forcing needs it: for a slope, shade, a wall, or direct and diffuse light. --ground-albedo goes with
    --forcing. --absorptance and --emissivity replace those of the library; a material FILE requires them.

    With --job the surface is between the ground and the walls that the state names. Shade ends the direct light and
    what comes from around the Sun. Where --sky-view is below 1, the rest of the sky that is open there is a wall of the
    temperature --facing, by default that of the air; it reflects no sunlight.

    Example: mat temperature --material concrete --slope 30 --azimuth 180 --job job.yaml
    """
    from skyshine.mat.api.temperature import temperature

    if (job is None) == (forcing is None):
        raise InputError("found both or neither of --job and --forcing; allowed: one of them")
    given = {name: value for name, value in options.items() if value is not None}
    result = temperature(material, job=job, forcing=forcing, **given)
    _emit_json(result) if as_json else _print(result)


def _emit_json(result: ColumnResult) -> None:
    output: dict[str, Any] = {
        "time": {"units": result.time_units, "values": list(result.time)},
        "temperature": quantity(result.temperature, "K"),
    }
    if result.depth_temperature is not None:
        output["temperature_at_depth"] = quantity(result.depth_temperature, "K")
    for name in ("leaf_temperature", "soil_temperature"):
        if (values := getattr(result, name)) is not None:
            output[name] = quantity(values, "K")
    if result.film is not None:
        output["film"] = quantity(result.film, "kg m^-2")
    output |= {name: quantity(values, "W m^-2") for name, values in result.fluxes.items()}
    output |= {
        "notes": list(result.notes),
        "residual": quantity(result.residual, "W m^-2"),
        "energy_closure": quantity(result.energy_closure, "W m^-2"),
        "bound_excess": quantity(result.bound_excess, "K"),
        "method": result.method,
        "iterations": result.iterations,
    }
    emit_json(output)


def _print(result: ColumnResult) -> None:
    temperatures = {"temperature": result.temperature}
    if result.depth_temperature is not None:
        temperatures["at_depth   "] = result.depth_temperature
    if result.leaf_temperature is not None and result.soil_temperature is not None:
        temperatures |= {"leaves     ": result.leaf_temperature, "soil       ": result.soil_temperature}
    for note in result.notes:
        click.echo(f"note: {note}", err=True)
    click.echo(f"time [{result.time_units}], temperature [C], fluxes [W/m2]")
    click.echo("  ".join(["time".ljust(20), *temperatures, *result.fluxes]))
    step = max(1, len(result.time) // 48)
    for i in range(0, len(result.time), step):
        time = result.time[i] if isinstance(result.time[i], str) else f"{result.time[i]:05.2f}"
        cells = [f"{values[i]:{len(name)}.2f}" for name, values in result.fluxes.items()]
        celsius = [f"{values[i] - ZERO_CELSIUS:11.3f}" for values in temperatures.values()]
        click.echo("  ".join([str(time).ljust(20), *celsius, *cells]))
    click.echo(
        f"method {result.method}, {result.iterations} iterations; residual {result.residual:.1e} W/m2, energy closure "
        f"{result.energy_closure:+.1e} W/m2, bound excess {result.bound_excess:.1e} K"
    )
