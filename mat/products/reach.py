"""Whether a build can meet the tolerances of a job, as `mat check` says.

Nodes of temperatures are placed by the same computation as in the build where it takes seconds, or those of a sample
where materials are many. Limits of channels come from measured builds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.job.atmosphere import State
from skyshine.mat.job.fields import tolerance_parts
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.measure.scale import REFLECTANCE, Scale
from skyshine.mat.plan.cost import film
from skyshine.mat.products.channel_start import FEWEST, channel_nodes
from skyshine.mat.quantities.channels.nodes import NodeCounts
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.equivalent_temperature import SHORTEST, reference_radiance
from skyshine.mat.scene.bands import response_of
from skyshine.mat.scene.grids import path_grid
from skyshine.mat.scene.moisture import job_library
from skyshine.schemas.errors import CheckFailed, InputError

# Nodes that a material takes at most for a kelvin, and how they grow with a finer tolerance: above those of all of 35
# placings for 1 to 40 materials in six days of all seasons, 0.25 to 2 K, and of three materials at 0.05 K.
_NODES_AT_1_K, _POWER = 1.0e6, 1.5
_MATERIALS = 12  # that are placed in some seconds
# Fraction of the nodes of a material, as placed for a sample of so many: all of 40 took 0.9 to 2.8 times, once 13.
_OF_SAMPLE = 0.5
_STATES = 4  # whose nodes are placed at most
# Fractions of a radiance seen: the finest tolerance that a build has held, and the coarsest of those that none held.
_FINEST_HELD, _NEVER_HELD = 1.6e-4, 1.6e-5
# Under a low Sun, where a band has more light of it than emission: in 3.7 to 3.9 um, with twice as much, builds at 0.3
# and 0.5 K ended with 2.2 and 2.4 K in the worst read, and those at 1 and 2 K held; they held 0.2 K under a Sun above
# 10 degree, and 0.3 K in 3 to 5 um, with 1.08 times as much.
_LOW_SUN, _UNDER_LOW_SUN, _OUTWEIGHS = (0.0, 6.0), 1.0, 1.5  # degree; K; light of the Sun over emission
_FIELDS = 3  # fields of channels at least: one absorber, thermal emission, a direction of the source


def tolerance_notes(loaded: LoadedJob, materials: Sequence[str]) -> list[str]:
    """A line for each tolerance that a build will likely miss.

    Parameters
    ----------
    materials : sequence of str
        Materials to build.

    Raises
    ------
    InputError
        The build would surely end without holding a tolerance.
    """
    return [*_channel_notes(loaded), *_surface_notes(loaded, materials)]


def _channel_notes(loaded: LoadedJob) -> list[str]:
    job = loaded.trimmed
    grid = job.atmosphere_grid
    tolerance, unit = tolerance_parts(grid.tolerance)
    start = channel_nodes(path_grid(job), job.site.altitude_km, NodeCounts().scaled(FEWEST))
    required = _FIELDS * start.size
    if required > grid.most_nodes:
        raise _error(
            loaded,
            "atmosphere_grid",
            f"most_nodes: found {grid.most_nodes}; allowed: at least {required}, from which placing starts; allow more",
        )
    notes = list[str]()
    if not loaded.insists("atmosphere_grid"):
        return notes
    for number in job.needed_bands:
        response = response_of(job.bands[number - 1])
        scale = Scale.of_unit(unit, response, 1.0)
        share = tolerance / (scale.background * scale.factor)
        if unit == "K" and tolerance < _UNDER_LOW_SUN and _low_sun_weighs(job, response):
            notes.append(
                f"atmosphere_grid.tolerance: found {grid.tolerance}; band {number} has more light of a low Sun than"
                f" emission, and builds of such held {_UNDER_LOW_SUN:g} K, not 0.5 K; the build may end without"
                " holding it; raise it, or name no source_elevation_deg of 0 to 6"
            )
        if not share < _FINEST_HELD:
            continue
        finest = _rounded_up(tolerance * _FINEST_HELD / share)
        words = f"tolerance: found {grid.tolerance}, {share:.1g} of the radiance of band {number}"
        if share < _NEVER_HELD:
            raise _error(
                loaded,
                "atmosphere_grid",
                f"{words}; no build held less than {_NEVER_HELD:g}; allowed: about {finest:g} {unit} or more; raise it",
            )
        notes.append(
            f"atmosphere_grid.{words}: builds held {_FINEST_HELD:g}, and none {_NEVER_HELD:g}; the build may end"
            f" without holding it; {finest:g} {unit} is safer"
        )
    return notes


def _low_sun_weighs(job: Job, response: SpectralResponse) -> bool:
    """Whether the Sun comes low, and what a surface reflects of it far outweighs a black body at 300 K."""
    elevation = job.atmosphere_axes()["source_elevation_deg"]
    low, high = _LOW_SUN
    if "sun" not in job.sources or response.upper < SHORTEST or elevation[0] >= high or elevation[-1] <= low:
        return False
    wavenumber = np.linspace(*response.wavenumber_range, 200)
    response_at = np.interp(1e4 / wavenumber, response.wavelength, response.response)
    reflected = REFLECTANCE / np.pi * np.trapezoid(response_at * solar_irradiance(wavenumber), wavenumber)
    return bool(reflected > _OUTWEIGHS * reference_radiance(response))


def _rounded_up(value: float) -> float:
    """A number with one digit, not below the value."""
    power = 10.0 ** math.floor(math.log10(value))
    return math.ceil(value / power - 1e-9) * power


def _surface_notes(loaded: LoadedJob, materials: Sequence[str]) -> list[str]:
    grid, notes = loaded.trimmed.surface_grid, list[str]()
    if grid.tolerance is None:
        return notes
    kelvin = tolerance_parts(grid.tolerance)[0]
    if len(materials) * _NODES_AT_1_K * kelvin**-_POWER <= grid.most_nodes:
        return notes
    states = loaded.trimmed.states
    # Those of the warmest days bend most, and are looked at first.
    order = sorted(range(len(states)), key=lambda number: -_span(states[number]))[:_STATES]
    for number in order:
        if (note := _state_note(loaded, materials, number + 1)) is not None:
            return [note]
    return notes


def _span(state: State) -> float:
    """Highest less lowest temperature of the air of a day [K]."""
    weather = state.weather
    air = weather.air_temperature_c if weather.hourly is None else weather.hourly.air_temperature_c
    return float(np.ptp(np.asarray(air, np.float64)))


def _state_note(loaded: LoadedJob, materials: Sequence[str], number: int) -> str | None:
    """What there is to say of the temperatures of a state, counted from 1."""
    from skyshine.mat.products.temperature import StartAxes, state_solver, tolerance_axes

    day = loaded.on_date_of_state(number)
    job, library = day.trimmed, job_library(day.trimmed)
    grid, insist = job.surface_grid, loaded.insists("surface_grid")
    count = min(len(materials), max(1, int(_MATERIALS / film(job.states[number - 1]))))
    chosen = [materials[index] for index in np.unique(np.linspace(0, len(materials) - 1, count).round().astype(int))]
    share = 1.0 if len(chosen) == len(materials) else _OF_SAMPLE
    node_limit = int(share * grid.most_nodes * len(chosen) / len(materials))
    solver = state_solver(job, [library[name] for name in chosen], number)
    words = f"surface_grid.tolerance {grid.tolerance}: {len(materials)} materials in {grid.most_nodes:,} nodes"
    try:
        axes = tolerance_axes(job, solver, StartAxes.of(job), node_limit, insist=insist)
    except CheckFailed as error:
        if len(chosen) == len(materials) and job.materials != "used":
            raise _error(loaded, "surface_grid", str(error).removeprefix("surface_grid.")) from None
        return f"{words}: the build will likely end without holding it; raise it, or allow more with most_nodes"
    if axes.p99 <= tolerance_parts(str(grid.tolerance))[0]:
        return None
    return f"{words} are likely within {axes.p99:.1g} K (99 %), {axes.largest:.1g} K (worst); the file states its error"


def _error(loaded: LoadedJob, grid: str, message: str) -> InputError:
    return loaded.document.error((grid,), f"{grid}.{message}")
