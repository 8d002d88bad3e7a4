"""`mat spectrum`: one line of sight."""

from __future__ import annotations

import math

import click

from skyshine.schemas.commands import emit_json, json_option
from skyshine.schemas.errors import InputError
from skyshine.schemas.quantity import quantity

RADIANCE = "W m^-2 sr^-1 (cm^-1)^-1"
IRRADIANCE = "W m^-2 (cm^-1)^-1"
# Of the two fogs of LOWTRAN7 the dense one, which lies over the sea and the coast.
FOG = "fog_advection"
RAIN_TOP = 3e3  # m above the ground
MEAN_MOON_DISTANCE = 384_400e3  # m (Allen's Astrophysical Quantities, 4th edition, 2000)
# A full Moon outside the Earth's shadow: the phase angle of the reflectance model's own limit, in degree.
FULL_MOON_PHASE = 4.0


@click.command("spectrum")
@click.option(
    "--atmosphere", default="midlatitude_summer", show_default=True, help="Standard profile, or a sounding FILE.csv."
)
@click.option(
    "--above", default="us_standard", show_default=True, help="Standard profile that continues a sounding to space."
)
@click.option("--co2", "co2_ppm", type=float, help="Carbon dioxide, ppm; by default the profile's own 330.")
@click.option(
    "--altitude",
    type=float,
    help="Observer above sea level, km; by default the ground: 0, or where the sounding begins.",
)
@click.option(
    "--elevation", type=float, default=0.0, show_default=True, help="Line of sight above the horizontal, degree."
)
@click.option("--range", "range_text", default="space", show_default=True, help="km, or 'space'.")
@click.option("--wavenumber", help="LO:HI in cm-1.")
@click.option("--wavelength", help="LO:HI in um.")
@click.option(
    "--resolution", type=float, help="Bins in cm-1, a multiple of the table's intervals (its own by default)."
)
@click.option(
    "--aerosol",
    default="rural",
    show_default=True,
    help=(
        "Near the ground: rural, urban, maritime, navy_maritime, tropospheric, desert, fog, fog_advection,"
        " fog_radiation, or none."
    ),
)
@click.option("--visibility", type=float, help="km; by default that which belongs to the aerosol (rural: 23).")
@click.option(
    "--wind", type=float, default=10.0, show_default=True, help="m/s at 10 m: of the desert and navy_maritime aerosols."
)
@click.option(
    "--stratosphere",
    default="background",
    show_default=True,
    help="background, or after volcanoes moderate_aged, moderate_fresh, high_aged, high_fresh, extreme_fresh.",
)
@click.option("--cloud", "clouds", multiple=True, help="A type such as stratus, cumulus, cirrus; several may be given.")
@click.option("--rain", type=float, help="mm/h, from the ground to 3 km.")
@click.option(
    "--source",
    type=click.Choice(["sun", "moon", "none"]),
    default="sun",
    show_default=True,
    help="Sun at 1 au, full Moon.",
)
@click.option("--source-elevation", type=float, default=45.0, show_default=True, help="Geometric, degree.")
@click.option(
    "--water-continuum",
    type=click.Choice(["mt_ckd_4.3", "mt_ckd_2.4", "lowtran7"]),
    help="Of water vapour: mt_ckd_2.4 for comparison with codes of its time, lowtran7 in the public domain; default:"
    " that of the packaged band model.",
)
@click.option("--source-azimuth", type=float, default=0.0, show_default=True, help="From the line of sight, degree.")
@click.option(
    "--plot",
    "picture",
    type=click.Path(),
    help="PNG to draw transmittance and path radiance into, in place of printing.",
)
@json_option
def command(
    atmosphere,
    above,
    co2_ppm,
    altitude,
    elevation,
    range_text,
    wavenumber,
    wavelength,
    resolution,
    aerosol,
    visibility,
    wind,
    stratosphere,
    clouds,
    rain,
    source,
    source_elevation,
    water_continuum,
    source_azimuth,
    picture,
    as_json,
):
    """Transmittance and radiance along one line of sight, for each spectral interval.

    Prints CSV, or JSON with --json, or draws with --plot. Sky and direct irradiance are those at the end of the line of
    sight, at the observer where it leads into space.

    Example: mat spectrum --atmosphere tropical --range 5 --wavenumber 700:1250 --json
    """
    import numpy as np

    from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
    from skyshine.mat.atmosphere.particles.cloud import cloud_type
    from skyshine.mat.atmosphere.particles.rain import RainLayer
    from skyshine.mat.atmosphere.spectra.spectrum import line_spectrum
    from skyshine.mat.atmosphere.state.state import AtmosphericState

    profile, ground = _profile(atmosphere, above)
    altitude = ground / 1e3 if altitude is None else altitude
    _finite(
        altitude=altitude,
        wind=wind,
        elevation=elevation,
        source_elevation=source_elevation,
        source_azimuth=source_azimuth,
    )
    low, high = _limits(wavenumber, wavelength)
    distance = _range(range_text)
    state = AtmosphericState.from_profile(
        profile,
        surface_altitude=ground,
        co2_ppm=co2_ppm,
        aerosol=FOG if aerosol == "fog" else aerosol,
        visibility_km=visibility,
        wind_speed=wind,
        stratosphere=stratosphere,
        clouds=[cloud_type(name) for name in clouds],
        rain=None if rain is None else RainLayer(rain, RAIN_TOP),
    )
    points = AbsorptionTable.open(water_continuum=water_continuum).points(low, high)
    result = line_spectrum(
        state,
        points,
        _irradiance(source, points),
        altitude=altitude * 1e3,
        elevation=np.radians(elevation),
        distance=distance,
        source_elevation=np.radians(source_elevation),
        source_azimuth=np.radians(source_azimuth),
        resolution=resolution,
    )
    if picture is not None:
        from skyshine.mat.tables.pictures import draw_spectrum

        if not picture.lower().endswith(".png"):
            raise InputError(f"found --plot '{picture}'; allowed: a name that ends in .png")
        title = f"{atmosphere}, {aerosol} aerosol, from {altitude:g} km at {elevation:g}°, {result.range / 1e3:.4g} km"
        click.echo(draw_spectrum(result, title, picture))
        return
    columns = {
        "wavenumber": ("cm^-1", result.wavenumber),
        "transmittance": ("1", result.transmittance),
        **{f"transmittance_{gas}": ("1", values) for gas, values in result.transmittance_by_gas.items()},
        "transmittance_rayleigh": ("1", result.transmittance_rayleigh),
        "transmittance_aerosol": ("1", result.transmittance_aerosol),
        "path_thermal": (RADIANCE, result.path_thermal),
        "path_scattered": (RADIANCE, result.path_scattered),
        "sky_irradiance": (IRRADIANCE, result.sky_irradiance),
        "direct_irradiance": (IRRADIANCE, result.direct_irradiance),
    }
    if as_json:
        _print_json(result, columns)
    else:
        click.echo(",".join(f"{name}[{unit}]" for name, (unit, _) in columns.items()))
        for row in zip(*(values for _, values in columns.values()), strict=True):
            click.echo(",".join(f"{value:.8g}" for value in row))


def _print_json(result, columns):
    gases = {f"transmittance_{gas}" for gas in result.transmittance_by_gas}
    shown = {name: quantity(values, unit) for name, (unit, values) in columns.items() if name not in gases}
    shown["transmittance_by_gas"] = {gas: quantity(values, "1") for gas, values in result.transmittance_by_gas.items()}
    shown["range"] = quantity(result.range / 1e3, "km")
    shown["ends_at_ground"] = result.ground
    emit_json(shown)


def _irradiance(source, points):
    """Of the source outside the atmosphere, mean over each point's interval, W m^-2 (cm^-1)^-1."""
    import numpy as np

    from skyshine.mat.atmosphere.sources.lunar import lunar_irradiance
    from skyshine.mat.atmosphere.sources.solar import solar_irradiance

    low, high = points.interval_edges[points.interval].T
    if source == "sun":
        return solar_irradiance((low + high) / 2, high - low)
    if source == "moon":
        return lunar_irradiance((low + high) / 2, FULL_MOON_PHASE, MEAN_MOON_DISTANCE, 1.0, width=high - low).total
    return np.zeros(points.wavenumber.size)


def _profile(name, above):
    """A standard profile by its name, or the sounding in a file; and the altitude of its ground, m."""
    from skyshine.mat.atmosphere.state.profiles import load_profile
    from skyshine.mat.atmosphere.state.sounding import read_sounding
    from skyshine.schemas.csv_table import read_text

    if name.endswith(".csv"):
        sounding = read_sounding(read_text(name), name, load_profile(above))
        return sounding, float(sounding.altitude[1])  # the first level of the file
    return load_profile(name), 0.0


def _finite(**values):
    for name, value in values.items():
        if not math.isfinite(value):
            raise InputError(f"--{name.replace('_', '-')} {value} is not a number; give a finite one")


def _limits(wavenumber, wavelength):
    """Lowest and highest wavenumber, cm^-1."""
    if (wavenumber is None) == (wavelength is None):
        raise InputError("give either --wavenumber LO:HI (cm-1) or --wavelength LO:HI (um)")
    text = wavelength if wavenumber is None else wavenumber
    try:
        low, high = (float(part) for part in text.split(":"))
    except ValueError:
        raise InputError(f"found '{text}'; allowed: two numbers LO:HI, such as 700:1250") from None
    if not 0 < low < high < math.inf:
        raise InputError(f"found '{text}'; allowed: 0 < LO < HI")
    return (low, high) if wavelength is None else (1e4 / high, 1e4 / low)


def _range(text):
    """Range in m, infinite for space."""
    if text == "space":
        return math.inf
    try:
        value = float(text)
    except ValueError:
        raise InputError(f"--range found '{text}'; allowed: km, or 'space'") from None
    if not 0 <= value < math.inf:
        raise InputError(f"--range found '{text}'; allowed: at least 0 km, or 'space'")
    return value * 1e3
