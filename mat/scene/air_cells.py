"""States of a job that share the points of their bands: those whose weather is in one cell of temperature and humidity.

The points are chosen for airs of the cell itself, those of its four corners. They do not depend on which
states the job has there. A member of a series whose weather differs, or of one of several sites, always has those of
its cell, so that its file is the same in a year, a month or a part of a job. A state that is written by itself has them
where another air of the job is in its cell, otherwise points of its own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from skyshine.mat.atmosphere.band.compile import SimilarAirs, over_air
from skyshine.mat.atmosphere.state.ground_air import GroundAir
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.job.atmosphere import State
from skyshine.mat.job.model import Job
from skyshine.mat.job.site import Site
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.atmosphere import aerosol_season, air_key, atmospheric_state, without_air_time
from skyshine.mat.scene.ground import over_ground
from skyshine.mat.scene.weather import daily_means
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.materials.library import MaterialLibrary

# Edges of the cells: day's mean temperature [K], and relative humidity. Across 20 K points for three airs err about as
# much as those of each day's own; where it is warmer, vapour doubles in 10 K.
TEMPERATURES = (200.0, 220.0, 240.0, 260.0, 280.0, 300.0, 310.0, 320.0)
HUMIDITIES = (0.01, 0.2, 0.5, 1.0)
# Airs for which points are chosen: places in the cell from its lower to its upper edge of temperature, of humidity.
_PLACES = ((0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0))
# The same for the airs in which they are tested: the error at most days of a year lies below the largest there.
_TESTED = ((0.5, 0.5), (0.25, 0.75), (0.75, 0.25))
_BLEND_STEPS = 2  # the weights of a blended profile are rounded to halves


@dataclass(frozen=True)
class AirCell:
    """A cell of weather and all else of which the air of a state follows.

    Attributes
    ----------
    temperature, humidity : tuple of float
        Edges, K and 1.
    others : tuple
        What states of one cell have in common beside.
    """

    temperature: tuple[float, float]
    humidity: tuple[float, float]
    others: tuple[Any, ...]

    @property
    def stated(self) -> dict[str, list[float]]:
        """What a file depends on, of the cell."""
        return {"air_temperature_k": list(self.temperature), "relative_humidity": list(self.humidity)}


def air_cell(site: Site, state: State) -> AirCell | None:
    """The cell of a state; None where its air does not follow its weather, or no cell contains that."""
    if state.air != "weather" or state.has_water_amount:
        return None
    kelvin, vapour, _ = daily_means(state.weather)
    temperature = _between(TEMPERATURES, kelvin)
    humidity = _between(HUMIDITIES, vapour / float(saturation_pressure(kelvin)))
    if temperature is None or humidity is None:
        return None
    hourly = state.weather.hourly
    middle = _middle(state)
    text, wind, _ = air_key(middle)
    altitude_km = site.altitude_km if hourly is None or hourly.altitude_km is None else hourly.altitude_km
    return AirCell(temperature, humidity, (text, wind, state.ground_material, altitude_km))


def shared_cell(job: Job, state: State) -> AirCell | None:
    """The cell of a state of a job, if the state is one of many or the job has another air in it."""
    cell = air_cell(job.site, state)
    if cell is None or state.is_one_of_many:
        return cell
    key = air_key(state)
    others = (neighbour for neighbour in job.states if air_cell(job.site, neighbour) == cell)
    return cell if any(air_key(neighbour) != key for neighbour in others) else None


def shared_cells(job: Job) -> list[AirCell | None]:
    """`shared_cell` of each state of a job."""
    cells = [air_cell(job.site, state) for state in job.states]
    airs: dict[AirCell | None, set[tuple[Any, ...]]] = {}
    for cell, state in zip(cells, job.states, strict=True):
        airs.setdefault(cell, set()).add(air_key(state))
    return [
        cell if state.is_one_of_many or len(airs[cell]) > 1 else None
        for cell, state in zip(cells, job.states, strict=True)
    ]


def airs_of_cell(
    site: Site, state: State, cell: AirCell, response: SpectralResponse, library: MaterialLibrary
) -> SimilarAirs:
    """The airs of a cell for which the points of a band are chosen, and in which these are tested, over the ground of a
    state of the cell.
    """
    middle, altitude = _middle(state), 1e3 * cell.others[-1]

    def air(along: float, moist: float) -> AtmosphericState:
        kelvin = _at(cell.temperature, along)
        vapour = _at(cell.humidity, moist) * float(saturation_pressure(kelvin))
        ground_air = GroundAir(altitude, kelvin, kelvin, vapour, vapour)
        return over_air(over_ground(atmospheric_state(site, middle, ground_air), middle, response, library))

    corners, inside = (tuple(air(*place) for place in places) for places in (_PLACES, _TESTED))
    return SimilarAirs(corners, inside)


def _middle(state: State) -> State:
    """The state with the day's mean air, and its profile and season as all states of its cell have them."""
    weights = _rounded(state.profile_weights)
    return without_air_time(state).model_copy(update={"profile": weights, "season": aerosol_season(state)})


def _rounded(weights: dict[str, float]) -> dict[str, float]:
    """Weights of profiles in halves that sum to 1, those with the largest remainders rounded up."""
    scaled = {name: _BLEND_STEPS * weight for name, weight in sorted(weights.items())}
    steps = {name: math.floor(value + 1e-9) for name, value in scaled.items()}
    missing = _BLEND_STEPS - sum(steps.values())
    for name in sorted(scaled, key=lambda name: steps[name] - scaled[name])[:missing]:
        steps[name] += 1
    return {name: count / _BLEND_STEPS for name, count in steps.items() if count}


def _between(edges: Sequence[float], value: float) -> tuple[float, float] | None:
    """The neighbouring edges between which a value lies, the upper one included."""
    return next(((low, high) for low, high in pairwise(edges) if low < value <= high), None)


def _at(edges: tuple[float, float], share: float) -> float:
    return edges[0] + share * (edges[1] - edges[0])
