"""``mat contrast``: one material against another through the day."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from skyshine.mat.commands import completions
from skyshine.mat.commands.model_options import axis_option
from skyshine.mat.commands.sight_options import sight_options
from skyshine.mat.job.surface import SurfaceGrid
from skyshine.schemas.commands import echo_table, emit_json, json_option
from skyshine.schemas.errors import InputError
from skyshine.schemas.quantity import quantity

if TYPE_CHECKING:
    from skyshine.mat.render.contrast import Contrast

SHOWN_STEPS = 12  # computed steps between the rows of the text


@click.command(epilog="Example: mat contrast demo/built asphalt_road grass_green --range 2 --out contrast.png")
@click.argument("folder", type=click.Path())
@click.argument("material", shell_complete=completions.materials)
@click.argument("background", shell_complete=completions.materials)
@sight_options("Name of one band, b01 if the job gives no name; by default all bands.")
@axis_option(SurfaceGrid, "slope_deg", "--slope", 0.0)
@axis_option(SurfaceGrid, "azimuth_deg", "--azimuth", 180.0, note=", of MATERIAL")
@click.option(
    "--shade",
    multiple=True,
    metavar="HH:MM-HH:MM",
    help="Hours of shade of MATERIAL; repeat for more intervals, also over midnight.",
)
@click.option("--out", type=click.Path(dir_okay=False), help="PNG file to draw.")
@json_option
def command(
    folder: str,
    material: str,
    background: str,
    band: str | None,
    state: int,
    source: str,
    distance: float,
    elevation: float,
    heading: float,
    altitude: float | None,
    slope: float,
    azimuth: float,
    shade: tuple[str, ...],
    out: str | None,
    as_json: bool,
) -> None:
    """Print the contrast of MATERIAL against level BACKGROUND through the day, from the databases in FOLDER, and the
    hours at which it changes its sign.

    Contrast is the difference of the apparent temperatures at the observer, of black bodies of the same radiance in
    the band.
    """
    from skyshine.mat.api.contrast import contrast as contrast_of
    from skyshine.mat.api.contrast import draw_contrast

    if out is not None and Path(out).suffix.lower() != ".png":
        raise InputError(f"found --out '{out}'; allowed: a name that ends in .png")
    results = contrast_of(
        folder,
        material,
        background,
        band=band,
        state=state,
        source=source,
        range=distance,
        elevation=elevation,
        heading=heading,
        altitude=altitude,
        slope=slope,
        azimuth=azimuth,
        shade=shade,
    )
    if out is not None:
        draw_contrast(results, material, background, Path(out))
    if as_json:
        emit_json({"material": material, "background": background, "bands": [_numbers(single) for single in results]})
        return
    for result in results:
        _print(result, material, background)
    if out is not None:
        click.echo(out)


def _numbers(result: Contrast) -> dict[str, Any]:
    return {
        "band": result.band,
        "wavelength": quantity(list(result.wavelength), "um"),
        "date": result.date,
        "sun_up": quantity(list(result.sun_up), "h"),
        "stated_error": quantity(result.stated_error, "K"),
        "time": quantity(result.hours, "h"),
        "material": quantity(result.material, "K"),
        "background": quantity(result.background, "K"),
        "contrast": quantity(result.contrast, "K"),
        "crossovers": quantity(list(result.crossovers), "h"),
    }


def _print(result: Contrast, material: str, background: str) -> None:
    from skyshine.mat.job.fields import clock_text

    rows = [
        (
            clock_text(result.hours[step]),
            f"{result.material[step]:.2f}",
            f"{result.background[step]:.2f}",
            f"{result.contrast[step]:+.2f}",
        )
        for step in range(0, result.hours.size, SHOWN_STEPS)
    ]
    low, high = result.wavelength
    click.echo(f"{low:g} to {high:g} um, {result.date}: apparent temperature of {material} against {background}")
    echo_table(("time", f"{material}, K", f"{background}, K", "contrast, K"), rows)
    steps = np.diff(np.append(result.hours, result.hours[0] + 24.0))
    usual = float(np.median(steps))
    for begin, step in zip(result.hours, steps, strict=True):
        if step > 1.5 * usual:
            gap = f"{clock_text(begin)} to {clock_text((begin + step) % 24)}"
            click.echo(
                f"without values: {gap}, which the tables do not cover (see source_elevation_deg, needs of the job)"
            )
    times = ", ".join(clock_text(round(hour * 60) / 60 % 24) for hour in result.crossovers)
    click.echo(f"crossovers: {times or 'none'}; stated error of the contrast: {result.stated_error:.2g} K in 99 %\n")
