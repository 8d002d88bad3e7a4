"""``mat export --to lut``: look-up tables for ISOFIT."""

from __future__ import annotations

from pathlib import Path

import click

from skyshine.mat.commands.model_options import axis_option, model_options
from skyshine.mat.job.air import PROFILE
from skyshine.mat.job.atmosphere import AtmosphereGrid, State
from skyshine.schemas.commands import progress
from skyshine.schemas.errors import InputError


@click.command(epilog="Example: mat export --to lut --wavelengths 400:2500:10 --water 0.5,1.5,3 --out lut.nc")
@click.option(
    "--wavelengths",
    required=True,
    metavar="LOW:HIGH:STEP | FILE",
    help="Channels LOW:HIGH:STEP in nm, or a wavelength file of ISOFIT.",
)
@click.option(
    "--fwhm",
    type=click.FloatRange(0, min_open=True),
    help="Full width at half maximum of each channel, nm, instead of STEP.",
)
@click.option("--water", required=True, metavar="LIST", help="Water vapour above the ground (H2OSTR), g cm-2.")
@click.option(
    "--optical-depth",
    default="0.1",
    show_default=True,
    metavar="LIST",
    help="Vertical optical depth of aerosol at 0.55 um (AOT550).",
)
@click.option(
    "--ground", default="0", show_default=True, metavar="LIST", help="Altitude of the ground above sea level, km."
)
@click.option(
    "--observer-zenith",
    default="0",
    show_default=True,
    metavar="LIST",
    help="Zenith angle of the observer, degrees from nadir.",
)
@click.option(
    "--relative-azimuth",
    default="0",
    show_default=True,
    metavar="LIST",
    help="Azimuth of the Sun relative to the line of sight at the ground, degree.",
)
@click.option("--solar-zenith", type=float, default=45.0, show_default=True, help="Zenith angle of the Sun, degree.")
@axis_option(AtmosphereGrid, "altitude_km", "--altitude", 100.0)
@model_options(State, {"profile": "profile", "aerosol": "aerosol"}, {"profile": PROFILE})
@click.option("--out", required=True, type=click.Path(dir_okay=False, path_type=Path), help="netCDF file to write.")
def command(
    wavelengths: str,
    fwhm: float | None,
    water: str,
    optical_depth: str,
    ground: str,
    observer_zenith: str,
    relative_azimuth: str,
    solar_zenith: float,
    altitude: float,
    profile: str | None,
    aerosol: str | None,
    out: Path,
) -> None:
    """Write a look-up table for ISOFIT: path reflectance, transmittances, spherical albedo and thermal radiance of an
    imaging spectrometer, over a grid of water vapour, aerosol and geometry.

    LISTs are numbers with commas between them. Each point of the grid takes seconds (400 to 2500 nm: eight).
    """
    from skyshine.mat.exchange.isofit import Lut, read_channels, write_lut

    if ":" in wavelengths and not Path(wavelengths).is_file():
        middle, width = _steps(wavelengths)
    else:
        middle, width = read_channels(Path(wavelengths))
    lut = Lut(
        wavelength=middle,
        fwhm=width if fwhm is None else (fwhm,) * len(middle),
        water=_numbers("--water", water),
        optical_depth=_numbers("--optical-depth", optical_depth),
        ground=_numbers("--ground", ground),
        observer_zenith=_numbers("--observer-zenith", observer_zenith),
        relative_azimuth=_numbers("--relative-azimuth", relative_azimuth),
        solar_zenith=solar_zenith,
        altitude=altitude,
        profile=profile or PROFILE,
        aerosol=aerosol or State.model_fields["aerosol"].default,
    )
    with progress(lut.size, "look-up table") as advance:
        write_lut(lut, out, advance)
    click.echo(out)


def _numbers(option: str, text: str) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"{option}: found '{text}'; allowed: numbers with commas between them") from None


def _steps(text: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    parts = text.split(":")
    numbers = _numbers("--wavelengths", ",".join(parts))
    if len(numbers) != 3 or not 0 < numbers[0] < numbers[1] or numbers[2] <= 0:
        raise InputError(f"--wavelengths: found '{text}'; allowed: LOW:HIGH:STEP in nm, 0 < LOW < HIGH, or a file")
    low, high, step = numbers
    count = int((high - low) / step + 1e-9) + 1
    return tuple(low + k * step for k in range(count)), (step,) * count
