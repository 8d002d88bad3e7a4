"""Random extreme lines of sight and skies, through air from completely dry to fog of 100 m visibility."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.particles.aerosol_column import BOUNDARY_MODELS, STRATOSPHERES, Aerosol
from skyshine.mat.atmosphere.particles.aerosol_layer import HIGHEST, SCALE_HEIGHTS, AerosolLayer
from skyshine.mat.atmosphere.particles.aerosol_layer import THINNEST as THINNEST_LAYER
from skyshine.mat.atmosphere.particles.angstrom import EXPONENTS
from skyshine.mat.atmosphere.particles.cloud import (
    LARGEST_OPTICAL_DEPTH,
    PHASES,
    RADII,
    THINNEST,
    TOP_LIMIT,
    CloudLayer,
)
from skyshine.mat.atmosphere.particles.particles import HenyeyGreensteinModel
from skyshine.mat.atmosphere.particles.rain import RATES, RainLayer
from skyshine.mat.atmosphere.sources.ephemeris import SOURCES, position
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.spectra.fluxes import broadband_fluxes
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.profiles import PROFILES, Profile, load_profile
from skyshine.mat.atmosphere.state.sounding import read_sounding
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.formulas import BETA_CAP_KM, BETA_FACTOR
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.radiometry.blackbody import SpectralResponse, planck_wavenumber
from skyshine.mat.radiometry.constants import STEFAN_BOLTZMANN
from skyshine.mat.scene.bands import absorption_table
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

_ROUNDING = 5e-5  # relative: attenuation along lines of sight is kept and summed in single precision
_SCALE_HEIGHT = 287.05 / 9.80665 * 1e-3  # km/K: gas constant of dry air over gravity (US Standard Atmosphere 1976)
_POINTS = 6  # lines of sight of an atmosphere
_SPECTRAL_POINTS = 3  # points of a band, at most: light scattered often takes most of a case, and is solved for each
_SOLAR = 1367.0  # W m^-2, no less than the total solar irradiance of any spectrum in use
_FARTHEST_DAYS = 73_000  # from 2000, 200 years either way


def atmosphere_case(generator: np.random.Generator) -> dict[str, tuple[float, float]]:
    """Random extreme lines of sight through a state from completely dry to fog."""
    table = absorption_table()
    state = random_state(generator)
    start, end = table.coverage[generator.integers(len(table.coverage))]
    low = float(np.exp(generator.uniform(np.log(start), np.log(end * 0.99))))
    response = SpectralResponse.rectangular(1e4 / min(low * 1.005 + 5.0, end), 1e4 / low)
    band = some_points(points_of_band(table, response), generator, _SPECTRAL_POINTS)
    air = BandAtmosphere.of(state, band)
    sun = solar_irradiance(band.wavenumber) if generator.random() < 0.7 else np.zeros(band.weight.size)
    ground = state.surface_altitude * 1e-3
    lines = LinesOfSight(
        _extreme(generator, np.exp(generator.uniform(np.log(1e-6), np.log(1e5), _POINTS)), (0.0, 1e5)),
        _extreme(generator, ground + np.exp(generator.uniform(np.log(1e-3), np.log(1e5), _POINTS)), (ground, 1e5)),
        _extreme(generator, generator.uniform(-90, 90, _POINTS), (-90.0, 0.0, 90.0)),
        _extreme(generator, generator.uniform(-90, 90, _POINTS), (-90.0, 0.0, 90.0)),
        _extreme(generator, generator.uniform(0, 180, _POINTS), (0.0, 180.0)),
    )
    q = air.at_points(lines, sun)
    values = np.concatenate([q.beta_star, q.path_radiance_ratio, q.ambient, q.direct, q.transmittance])
    hottest = max(float(state.temperature.max()), float(state.surface_temperature))
    # A path may pass the brightest part of the band alone: the bound takes the whole band as bright as that part.
    black, light = (
        float(np.max(spectrum * band.radiance_weight / band.weight) * band.weight.sum())
        for spectrum in (planck_wavenumber(band.wavenumber, hottest), sun / np.pi)
    )
    from_beta = np.where(
        q.valid & (lines.range > 0), np.exp(-BETA_FACTOR * lines.range / q.beta_star) - q.transmittance, 0.0
    )
    result = {
        "not finite": (float(np.count_nonzero(~np.isfinite(values))), 0.0),
        "below 0": (max(0.0, -float(values.min())), 0.0),
        "transmittance above 1": (float(q.transmittance.max()) - 1, 1e-12),
        "beta* above its cap, km": (max(0.0, float(q.beta_star.max()) - BETA_CAP_KM), 0.0),
        "transmittance of beta*": (float(np.abs(from_beta).max()), 1e-6),
        "direct light above the brightest in space, relative": (_above(float(q.direct.max()), light), _ROUNDING),
    }
    if not light:  # with emission alone no path is brighter than a black body of the highest temperature
        brightest = float(q.path_radiance_ratio.max())
        result["path above a black body, relative"] = (_above(brightest, black), _ROUNDING)
    return result


def _above(value: float, limit: float) -> float:
    """What a value exceeds a limit by, relative to it where it is not 0."""
    return max(0.0, value / limit - 1 if limit else value)


def some_points(band: BandPoints, generator: np.random.Generator, most: int) -> BandPoints:
    """A band of so many of the points of another, drawn at random: what bounds all bounds any of them."""
    if band.weight.size <= most:
        return band
    index = np.sort(generator.choice(band.weight.size, most, replace=False))
    return replace(band, points=band.points.subset(index), weight=band.weight[index])


def sky_case(generator: np.random.Generator) -> dict[str, tuple[float, float]]:
    """Sun and Moon anywhere at any time within two centuries, and what of sunlight and of the sky's own heat reaches
    the ground.
    """
    latitude = float(generator.choice([-90.0, 90.0, generator.uniform(-90, 90)]))
    moments = np.datetime64("2000-01-01") + (generator.uniform(-_FARTHEST_DAYS, _FARTHEST_DAYS, 3) * 86_400).astype(
        "timedelta64[s]"
    )
    site = latitude, float(generator.uniform(-180, 180)), float(generator.choice([0.0, -430.0, 8848.0]))
    sun, moon = (position(source, moments, *site) for source in SOURCES)
    positions = np.concatenate([np.concatenate(list(vars(source).values())) for source in (sun, moon)])
    state = random_state(generator)
    low, high = state.altitude[[0, -1]]
    heights = np.unique([low, generator.uniform(low, high)])
    elevation = _extreme(generator, sun.elevation, (-90.0, 0.0, 90.0))
    fluxes = broadband_fluxes(
        state, heights, np.unique(elevation), float(generator.choice([0.0, 0.2, 1.0])), sun_distance=0.98
    )
    values = np.concatenate([part.ravel() for part in (fluxes.longwave_down, fluxes.direct_normal, fluxes.diffuse)])
    black = STEFAN_BOLTZMANN * max(float(state.temperature.max()), float(state.surface_temperature)) ** 4
    limit = _SOLAR / 0.98**2
    return {
        "not finite": (float(np.count_nonzero(~np.isfinite(np.concatenate([positions, values])))), 0.0),
        "elevation beyond the zenith, degree": (max(float(np.abs(s.elevation).max()) for s in (sun, moon)) - 90, 0.0),
        "irradiance below 0": (max(0.0, -float(values.min())), 0.0),
        "direct light over that in space": (float(fluxes.direct_normal.max()) / limit, 1.0),
        "diffuse light over that in space": (float(fluxes.diffuse.max()) / limit, 1.0),
        "longwave over a black body": (float(fluxes.longwave_down.max()) / black, 1.0),
    }


def random_state(generator: np.random.Generator) -> AtmosphericState:
    """A valid state: one with clouds that must freeze or melt is refused and drawn again."""
    while True:
        try:
            return _any_state(generator)
        except InputError:
            continue


def _any_state(generator: np.random.Generator) -> AtmosphericState:
    aerosol = str(generator.choice([*BOUNDARY_MODELS, "none"]))
    profile = str(generator.choice(list(PROFILES)))
    sounding = generator.random() < 0.3
    visibility, depth = _random_amount(generator, aerosol)
    return AtmosphericState.from_profile(
        _random_sounding(generator, profile) if sounding else profile,
        surface_altitude=float(generator.choice([-500.0, 0.0, generator.uniform(0, 5900)])),
        gas_amounts=GasAmounts(
            ppm={"CO2": float(generator.choice([0.0, 420.0, 5000.0]))},
            scale={
                "H2O": float(generator.choice([0.0, 1.0, 10.0])),
                "O3": float(generator.choice([0.0, 1.0, 100.0])),
            },
        ),
        aerosol=Aerosol(
            aerosol,
            visibility_km=visibility,
            optical_depth=depth,
            angstrom_exponent=float(generator.uniform(*EXPONENTS)) if generator.random() < 0.2 else None,
            optics=_random_table(generator) if aerosol != "none" and generator.random() < 0.2 else None,
            wind_speed=float(generator.choice([0.0, 4.0, 60.0])),
            air_mass=int(generator.integers(1, 11)),
            stratosphere=str(generator.choice(list(STRATOSPHERES))),
        ),
        aerosol_layers=[_random_layer(generator) for _ in range(generator.choice([0, 0, 1, 2]))],
        clouds=[_random_cloud(generator) for _ in range(generator.choice([0, 0, 1, 3]))],
        rain=RainLayer(float(np.exp(generator.uniform(*np.log(RATES)))), generator.uniform(20.0, 15e3))
        if generator.random() < 0.3
        else None,
        surface_temperature=float(generator.uniform(180, 350)),
        surface_albedo=float(generator.choice([0.0, 0.1, 1.0])),
    )


def _random_amount(generator: np.random.Generator, aerosol: str) -> tuple[float | None, float | None]:
    """Visibility [km] or optical depth of an aerosol."""
    if aerosol == "none":
        return None, None
    if generator.random() < 0.5:
        return float(np.exp(generator.uniform(np.log(0.1), np.log(300.0)))), None
    return None, float(generator.choice([0.0, 0.1, generator.uniform(0, 3), 100.0]))


def _random_table(generator: np.random.Generator) -> HenyeyGreensteinModel:
    """Optical properties of a user's aerosol, of any spectrum."""
    wavelength = np.append(np.append(0.25, np.sort(generator.uniform(0.3, 30.0, 6))), 40.0)
    extinction = np.exp(generator.uniform(-2.0, 2.0, wavelength.size))
    absorbed = generator.choice([0.0, 0.1, 1.0], wavelength.size)
    asymmetry = generator.uniform(0.0, 0.99, wavelength.size)
    return HenyeyGreensteinModel.of_table("table", wavelength, extinction, absorbed * extinction, asymmetry)[0]


def _random_layer(generator: np.random.Generator) -> AerosolLayer:
    """A layer of a user's aerosol of any depth, anywhere."""
    model, depth = _random_table(generator), float(generator.choice([0.0, 0.3, 100.0]))
    if generator.random() < 0.5:
        bottom = float(generator.choice([0.0, generator.uniform(0.0, HIGHEST - THINNEST_LAYER)]))
        top = float(generator.choice([bottom + THINNEST_LAYER, HIGHEST]))
        return AerosolLayer.even(model, bottom, top, depth)
    return AerosolLayer.exponential(model, float(np.exp(generator.uniform(*np.log(SCALE_HEIGHTS)))), depth)


def _random_cloud(generator: np.random.Generator) -> CloudLayer:
    """A cloud of any allowed depth and thickness, at any height."""
    phase = str(generator.choice(PHASES))
    thickness = float(np.exp(generator.uniform(np.log(THINNEST), np.log(TOP_LIMIT / 2))))
    base = float(generator.choice([0.0, generator.uniform(0.0, TOP_LIMIT - thickness)]))
    depth = float(
        generator.choice(
            [0.0, np.exp(generator.uniform(np.log(1e-4), np.log(LARGEST_OPTICAL_DEPTH))), LARGEST_OPTICAL_DEPTH]
        )
    )
    return CloudLayer(phase, base, base + thickness, float(generator.uniform(*RADII[phase])), depth)


def _random_sounding(generator: np.random.Generator, name: str) -> Profile:
    """A sounding with inversions, layers without water between wet ones, few levels."""
    levels = np.sort(generator.uniform(0.0, 30.0, int(generator.integers(3, 40))))
    levels = np.unique(np.round(levels, 3))
    temperature = np.clip(
        288.0 - 6.5 * np.minimum(levels, 11.0) + generator.normal(0.0, 12.0, levels.size), 190.0, 320.0
    )
    humidity = np.where(generator.random(levels.size) < 0.2, 0.0, generator.uniform(0.0, 100.0, levels.size))
    scale = _SCALE_HEIGHT * (temperature[1:] + temperature[:-1]) / 2  # scale height of the air between two levels, km
    pressure = 1013.0 * np.exp(-levels[0] / 7.5 - np.cumsum(np.append(0.0, np.diff(levels) / scale)))
    rows = (f"{z},{p:.6f},{t:.2f},{u:.2f}" for z, p, t, u in zip(levels, pressure, temperature, humidity, strict=True))
    text = "\n".join(["altitude[km],pressure[hPa],temperature[K],relative_humidity[%]", *rows]) + "\n"
    return read_sounding(text, Path("drawn.csv"), load_profile(name))


def _extreme(generator: np.random.Generator, values: Floats, ends: tuple[float, ...]) -> Floats:
    """The values, some of them replaced by the ends of the allowed range."""
    return np.where(generator.random(values.size) < 0.3, generator.choice(ends, values.size), values)
