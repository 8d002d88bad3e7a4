"""`mat spectrum`: one line of sight."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click
from click.core import ParameterSource

from skyshine.mat.commands.model_options import axis_option, model_options
from skyshine.mat.commands.sight_options import job_option, state_option
from skyshine.mat.job.air import KEYS, PROFILE, PROFILE_ABOVE, WIND
from skyshine.mat.job.atmosphere import AtmosphereGrid, State
from skyshine.mat.job.surface import Weather
from skyshine.schemas.commands import Command, emit_json, json_option
from skyshine.schemas.errors import InputError
from skyshine.schemas.plain_numbers import plain_number
from skyshine.schemas.quantity import quantity

if TYPE_CHECKING:
    from skyshine.mat.api.spectrum import Spectrum
    from skyshine.mat.api.spectrum_comparison import SpectrumComparison
    from skyshine.mat.tables.dataset import Column


def air_options(function: Command) -> Command:
    """Adds an option for each key of a job's air."""
    above = {"profile": f"{PROFILE}, above a sounding {PROFILE_ABOVE}"}
    with_wind = model_options(Weather, {WIND: WIND})(function)
    return model_options(State, {key: key for key in KEYS if key != WIND}, above)(with_wind)


@click.command("spectrum")
@job_option
@state_option
@axis_option(
    AtmosphereGrid,
    "altitude_km",
    "--altitude",
    note="; by default the ground: 0, the bottom of the sounding, or the job's site",
)
@axis_option(AtmosphereGrid, "elevation_deg", "--elevation", 0.0)
@click.option(
    "--range", "range_text", default="space", show_default=True, help="Length of the line of sight, km, or 'space'."
)
@click.option("--wavenumber", help="Wavenumber range LO:HI in cm-1.")
@click.option("--wavelength", help="Wavelength range LO:HI in um.")
@click.option(
    "--resolution",
    type=float,
    help="Width of the bins in cm-1, a multiple of the table's intervals (default: one interval); with "
    "--line-by-line 0.01 or more.",
)
@air_options
@click.option(
    "--source",
    type=click.Choice(["sun", "moon", "none"]),
    default="sun",
    show_default=True,
    help="Light source: the Sun at 1 au or the full Moon; with --job those of its day.",
)
@axis_option(AtmosphereGrid, "source_elevation_deg", "--source-elevation", 45.0)
@click.option(
    "--water-continuum",
    type=click.Choice(["mt_ckd_4.3_closure", "mt_ckd_4.3", "mt_ckd_2.4", "lowtran7"]),
    help="Continuum of water vapour: mt_ckd_2.4 for comparison with codes of its time, lowtran7 in the public domain;"
    " default: the job's, or mt_ckd_4.3_closure.",
)
@click.option(
    "--compare-continua",
    is_flag=True,
    help="Print the apparent temperature of a blackbody of 300 K with each water vapour continuum over "
    "the whole range, in K; with --job and no range, over the job's only band.",
)
@click.option(
    "--compare",
    type=click.Path(),
    help="Spectrum of another program: tape7, .tp7, tape7.scn or .7sc of MODTRAN, or CSV. Both and their difference are"
    " printed or drawn, with band means and rms; the range is the file's by default.",
)
@click.option(
    "--fluxes",
    "level_fluxes",
    is_flag=True,
    help="Print fluxes on all levels of the air, W/m2, between the limits; of the whole spectrum without limits.",
)
@axis_option(AtmosphereGrid, "source_azimuth_deg", "--source-azimuth", 0.0)
@click.option(
    "--line-by-line",
    type=click.Path(),
    help="Folder of HITRAN 160-column records (01_*.par[.gz|.xz] ...), whose lines are summed instead of "
    "the band model; the package ships none. Gases without records keep the band model's interval "
    "means.",
)
@click.option(
    "--continua",
    type=click.Path(),
    help="With --line-by-line, continua of N2, O2 and CO2: a folder of MT_CKD files, or lowtran7 "
    "(packaged; the default).",
)
@click.option(
    "--out",
    type=click.Path(),
    help="File to write: FILE.h5 (format spectrum, for xarray and h5py) or FILE.csv, with units, or a picture FILE.png"
    " of transmittance and path radiance; by default the spectrum is printed.",
)
@json_option
def command(
    job: str | None,
    state: int,
    altitude: float | None,
    elevation: float,
    range_text: str,
    wavenumber: str | None,
    wavelength: str | None,
    resolution: float | None,
    source: Literal["sun", "moon", "none"],
    source_elevation: float,
    water_continuum: str | None,
    compare_continua: bool,
    compare: str | None,
    level_fluxes: bool,
    source_azimuth: float,
    line_by_line: str | None,
    continua: str | None,
    out: str | None,
    as_json: bool,
    **air: Any,
) -> None:
    """Compute transmittance and radiance along one line of sight, for each spectral interval.

    Prints CSV, or JSON with --json. Sky and direct irradiance are those at the end of the line of
    sight, at the observer where it leads into space.

    Options of the air are the keys of a job's state, with values as a job writes them. With --job the air is that of a
    state of a job, as its tables have it, and none of them is allowed.

    Example: mat spectrum --profile tropical --range 5 --wavenumber 700:1250 --json

    Example: mat spectrum --clouds '[{type: stratus}]' --elevation 30 --wavelength 8:12

    Example: mat spectrum --job demo/job.yaml --state 2 --range 5 --wavelength 8:12 --out spectrum.h5

    Example: mat spectrum --sounding tape5 --range 5 --compare tape7 --out comparison.png

    Example: mat spectrum --fluxes --profile tropical --source-elevation 60

    Example: mat spectrum --range 1 --wavenumber 2380:2400 --line-by-line hitran --resolution 0.1
    """
    from skyshine.mat.api.spectrum import spectrum

    if level_fluxes:
        _print_fluxes(click.get_current_context(), as_json)
        return
    if compare is not None and wavenumber is wavelength is None:
        from skyshine.mat.tables.other_spectra import read_other_spectrum

        covered = read_other_spectrum(compare).wavenumber
        wavenumber = f"{covered[0]:.10g}:{covered[-1]:.10g}"
    if (wavenumber is None) == (wavelength is None) and not (compare_continua and job is not None and not wavenumber):
        raise InputError("give either --wavenumber LO:HI (cm-1) or --wavelength LO:HI (um)")
    if continua is not None and line_by_line is None:
        raise InputError("found --continua without --line-by-line; give both or neither")
    if out is not None and not out.lower().endswith((".h5", ".csv", ".png")):
        raise InputError(f"found --out '{out}'; allowed: a name that ends in .h5, .csv or .png")
    arguments: dict[str, Any] = {
        "wavenumber": _limits(wavenumber),
        "wavelength": _limits(wavelength),
        "job": job,
        "state": state,
        "altitude": altitude,
        "elevation": elevation,
        "range": _range(range_text),
        "resolution": resolution,
        "source": source,
        "source_elevation": source_elevation,
        "source_azimuth": source_azimuth,
        "water_continuum": water_continuum,
        **{key: value for key, value in air.items() if value is not None},
    }
    if compare_continua:
        from skyshine.mat.commands.spectrum import print_comparison

        others = {"--line-by-line": line_by_line, "--out": out, "--compare": compare}
        for option in (name for name, value in others.items() if value is not None):
            raise InputError(f"found --compare-continua with {option}; leave one out")
        print_comparison(arguments, as_json=as_json)
        return
    if line_by_line is not None:
        arguments["line_by_line"] = line_by_line
    if continua is not None:
        arguments["continua"] = continua
    result = spectrum(**arguments)
    observer = "the ground" if altitude is None else f"{altitude:g} km"
    described = ", ".join(f"{key.replace('_', ' ')} {value}" for key, value in air.items() if value is not None)
    state_name = (described or f"profile {PROFILE}") if job is None else f"state {state} of {Path(job).name}"
    title = f"{state_name}, from {observer} at {elevation:g}°, " + (
        "to space" if math.isinf(result.range) else f"{result.range / 1e3:.4g} km"
    )
    if compare is not None:
        _give_comparison(result.compare(compare), title, out, as_json)
    elif out is not None and out.lower().endswith(".png"):
        chart = result.plot()
        chart.figure.suptitle(title, fontsize=10)
        click.echo(chart.save(out))
    elif out is not None:
        result.save(out)
        click.echo(out)
    elif as_json:
        _print_json(result, result.columns)
    else:
        from skyshine.mat.tables.spectrum_file import csv_lines

        for line in csv_lines(result.columns):
            click.echo(line)


def _give_comparison(comparison: SpectrumComparison, title: str, out: str | None, as_json: bool) -> None:
    """Print a comparison as CSV or JSON, or write it as CSV or a picture."""
    from skyshine.mat.tables.spectrum_file import csv_lines, write_spectrum_csv

    if out is None and as_json:
        content: dict[str, Any] = {name: quantity(values, unit) for name, (unit, values) in comparison.columns.items()}
        content["mean"] = {name: list(means) for name, means in comparison.means.items()}
        emit_json(content | {"rms": comparison.rms})
    elif out is None:
        for line in csv_lines(comparison.columns, comparison.summary):
            click.echo(line)
    elif out.lower().endswith(".h5"):
        raise InputError(f"found --compare with --out '{out}'; allowed: a name that ends in .csv or .png")
    else:
        if out.lower().endswith(".csv"):
            write_spectrum_csv(out, comparison.columns, comparison.summary)
        else:
            from skyshine.mat.tables.pictures import draw_comparison

            draw_comparison(comparison, title, out)
        click.echo(out)
        for name, text in comparison.summary.items():
            click.echo(f"{name}: {text}")


_OF_LINES = {  # options that describe a line of sight or what is done with its spectrum
    "altitude": "--altitude",
    "elevation": "--elevation",
    "range_text": "--range",
    "resolution": "--resolution",
    "source_azimuth": "--source-azimuth",
    "compare_continua": "--compare-continua",
    "compare": "--compare",
    "line_by_line": "--line-by-line",
    "continua": "--continua",
    "out": "--out",
}


def _print_fluxes(context: click.Context, as_json: bool) -> None:
    """Print fluxes of a band or of the whole spectrum by level, by the options that are given: CSV, or JSON."""
    from skyshine.mat.api.fluxes import fluxes
    from skyshine.mat.tables.spectrum_file import csv_lines

    given = [name for name in context.params if context.get_parameter_source(name) is ParameterSource.COMMANDLINE]
    for name in given:
        if name in _OF_LINES:
            raise InputError(f"found --fluxes with {_OF_LINES[name]}; leave one out")
    arguments: dict[str, Any] = {
        name: _limits(context.params[name]) if name in ("wavenumber", "wavelength") else context.params[name]
        for name in given
        if name not in ("level_fluxes", "as_json")
    }
    result = fluxes(**arguments)
    columns: dict[str, Column] = {"altitude": ("m", result.altitude)}
    for name, values in result.in_band.items():
        if values.size:
            columns[name] = ("W m^-2", values if values.ndim == 1 else values[:, 0])
    if as_json:
        emit_json({name: quantity(values, unit) for name, (unit, values) in columns.items()})
        return
    for line in csv_lines(columns):
        click.echo(line)


def _print_json(result: Spectrum, columns: dict[str, Column]) -> None:
    gases = {f"transmittance_{gas}" for gas in result.transmittance_by_gas}
    content: dict[str, Any] = {
        name: quantity(values, unit) for name, (unit, values) in columns.items() if name not in gases
    }
    content["transmittance_by_gas"] = {
        gas: quantity(values, "1") for gas, values in result.transmittance_by_gas.items()
    }
    content["range"] = quantity(result.range / 1e3, "km")
    content["ends_at_ground"] = result.ground
    emit_json(content)


def _limits(text: str | None) -> tuple[float, float] | None:
    """The two numbers of LO:HI; None where the option is not given."""
    if text is None:
        return None
    try:
        low, high = (plain_number(part) for part in text.split(":"))
    except ValueError:
        raise InputError(f"found '{text}'; allowed: two numbers LO:HI, such as 700:1250") from None
    if not 0 < low < high < math.inf:
        raise InputError(f"found '{text}'; allowed: 0 < LO < HI")
    return low, high


def _range(text: str) -> float:
    """Range in km, infinite for space."""
    if text == "space":
        return math.inf
    try:
        value = plain_number(text)
    except ValueError:
        raise InputError(f"--range found '{text}'; allowed: km, or 'space'") from None
    if not 0 <= value < math.inf:
        raise InputError(f"--range found '{text}'; allowed: at least 0 km, or 'space'")
    return value


def print_comparison(arguments: Mapping[str, Any], *, as_json: bool) -> None:
    """Print a line of sight with every water vapour continuum: CSV, or JSON.

    Parameters
    ----------
    arguments : mapping
        Arguments of `skyshine.mat.spectrum`; its `water_continuum` is ignored.
    """
    from skyshine.mat.api.continua import compare_continua

    effects = compare_continua(**{name: value for name, value in arguments.items() if name != "water_continuum"})
    if as_json:
        emit_json(
            {
                effect.name: {
                    "transmittance": quantity(effect.transmittance, "1"),
                    "temperature": quantity(effect.temperature, "K"),
                    "difference": quantity(effect.difference, "K"),
                }
                for effect in effects
            }
        )
        return
    click.echo("water_continuum,transmittance[1],apparent_temperature[K],difference[K]")
    for effect in effects:
        click.echo(f"{effect.name},{effect.transmittance:.4f},{effect.temperature:.3f},{effect.difference:+.3f}")
