"""Error against run time of the direct computation of atmospheric quantities: spectral points, directions of the sky,
layers and streams.

Times are seconds of processor time, which other work on the machine changes less than the clock. `mat bench JOB` has
the time of whole files, beside LOWTRAN7.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np
from ladders import GRID, VISIBILITY

from skyshine.mat.atmosphere.band.compile import compile_band
from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.sky import sky_irradiance
from skyshine.mat.atmosphere.transfer.stream_count import azimuthal_count
from skyshine.mat.bench.peer_light import thinned
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.results import AtmosphericQuantities
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.schemas.arrays import Floats

Result = TypeVar("Result")
BANDS = {"3-5 um": (3.0, 5.0), "8-12 um": (8.0, 12.0)}
QUICK_BANDS = {"10-10.5 um": (10.0, 10.5)}
PROFILE = "midlatitude_summer"
POINTS = (4, 16, 64)
DIRECTIONS = (2, 4, 8, 16)
STREAMS, _MOST_NODES = (2, 4, 6, 8), 16  # nodes of a hemisphere
_CLOUD = (1e3, 1.5e3, 10.0, 5.0)  # base and top, m; effective radius, um; optical depth
# Lines and sources on which the ladders of points, layers and streams are judged.
_SMALL = PathGrid(
    range_km=np.array([0.3, 2.0, 9.0, 60.0]),
    altitude_km=np.array([0.1, 2.7, 11.0]),
    elevation_deg=np.array([-37.0, -4.0, 1.5, 24.0]),
    source_elevation_deg=np.array([8.0, 50.0]),
    source_azimuth_deg=np.array([15.0, 100.0]),
)
_QUANTITIES = ("transmittance", "path_radiance_ratio", "ambient", "direct")
# Errors count relative to the quantity, or to this share of its largest value where it is below.
_FLOOR = 0.1


@dataclass(frozen=True)
class AtmosphereRung:
    """One setting of a ladder: processor seconds, and the rms error of each quantity (relative)."""

    name: str
    seconds: float
    errors: dict[str, float]


@dataclass(frozen=True)
class AtmosphereBench:
    """Measurements of one band.

    Attributes
    ----------
    band : str
    points, total_points : int
        Spectral points of the compiled band and of all.
    ladders : dict of list of AtmosphereRung
        "points", "directions", "layers", "streams".
    """

    band: str
    points: int
    total_points: int
    ladders: dict[str, list[AtmosphereRung]]


def bench_band(
    name: str, limits: tuple[float, float], *, advance: Callable[[int], object] = lambda _: None
) -> AtmosphereBench:
    """Measure one band.

    Parameters
    ----------
    name : str
    limits : (float, float)
        um.
    advance : callable, optional
        Called after each of the four ladders.
    """
    state = AtmosphericState.from_profile(PROFILE, aerosol=Aerosol("rural", visibility_km=VISIBILITY))
    response = SpectralResponse.rectangular(*limits)
    everything = points_of_band(AbsorptionTable.open(), response)
    sun = solar_irradiance(everything.wavenumber, everything.width)
    compiled = compile_band(state, everything, GRID, sun)
    few = sun[compiled.index]
    measured: dict[str, Callable[[], list[AtmosphereRung]]] = {
        "points": partial(points_ladder, state, everything, sun),
        "directions": partial(directions_ladder, state, compiled.band),
        "layers": partial(layers_ladder, state, compiled.band, few),
        "streams": partial(streams_ladder, compiled.band, few),
    }
    ladders = {}
    for ladder, rungs in measured.items():
        ladders[ladder] = rungs()
        advance(1)
    return AtmosphereBench(name, compiled.index.size, compiled.total_points, ladders)


def points_ladder(state: AtmosphericState, everything: BandPoints, sun: Floats) -> list[AtmosphereRung]:
    """Compiled bands of a few points to many, against all points."""
    exact = BandAtmosphere.of(state, everything).table(_SMALL, sun)
    rungs = []
    for count in POINTS:
        few = compile_band(state, everything, GRID, sun, tolerance=1e-6, max_points=count)
        table, seconds = _timed(partial(_small_table, state, few.band, sun[few.index]))
        rungs.append(AtmosphereRung(f"{few.index.size} points", seconds, _errors(table, exact)))
    return rungs


def _small_table(state: AtmosphericState, band: BandPoints, sun: Floats) -> AtmosphericQuantities:
    """The quantities on the cells of the ladders."""
    return BandAtmosphere.of(state, band).table(_SMALL, sun)


def directions_ladder(state: AtmosphericState, band: BandPoints) -> list[AtmosphereRung]:
    """Thermal sky irradiance by zenith angles of its quadrature, against 24."""
    air = BandAtmosphere.of(state, band).air
    air.prepare()
    place = np.array([0.0, 2e3]), np.zeros(0)
    exact = sky_irradiance(air, *place, zeniths=24).thermal @ band.radiance_weight
    rungs = []
    for count in DIRECTIONS:
        sky, seconds = _timed(partial(sky_irradiance, air, *place, zeniths=count))
        error = float(np.sqrt(np.mean((sky.thermal @ band.radiance_weight / exact - 1) ** 2)))
        rungs.append(AtmosphereRung(str(count), seconds, {"thermal": error}))
    return rungs


def streams_ladder(band: BandPoints, sun: Floats) -> list[AtmosphereRung]:
    """Discrete ordinates of few nodes to many, under water cloud, against more of them; a hemisphere has n nodes."""
    cloud = CloudLayer("water", *_CLOUD)
    state = AtmosphericState.from_profile(PROFILE, aerosol=Aerosol("rural", visibility_km=VISIBILITY), clouds=[cloud])

    def table(nodes: int) -> AtmosphericQuantities:
        own = BandAtmosphere.of(state, band)
        azimuthal = azimuthal_count(nodes)
        return replace(own, air=replace(own.air, nodes=nodes, azimuthal=azimuthal)).table(_SMALL, sun)

    exact = table(_MOST_NODES)
    rungs = []
    for nodes in STREAMS:
        quantities, seconds = _timed(partial(table, nodes))
        errors = _errors(quantities, exact)
        errors = {name: errors[name] for name in ("path_radiance_ratio", "ambient")}
        rungs.append(AtmosphereRung(f"{2 * nodes} streams", seconds, errors))
    return rungs


def layers_ladder(state: AtmosphericState, band: BandPoints, sun: Floats) -> list[AtmosphereRung]:
    """Every fourth level of the state to all of them, against all of them cut in two."""
    exact = BandAtmosphere.of(halved(state), band).table(_SMALL, sun)
    rungs = []
    for step in (4, 2, 1):
        levels = np.unique(np.append(np.arange(0, state.altitude.size, step), state.altitude.size - 1))
        air = thinned(state, levels)
        table, seconds = _timed(partial(_small_table, air, band, sun))
        rungs.append(AtmosphereRung(f"{levels.size} levels", seconds, _errors(table, exact)))
    return rungs


def halved(state: AtmosphericState) -> AtmosphericState:
    """A state with one more level in the middle of each layer: pressure exponential, all else linear in altitude."""
    altitude = np.sort(np.append(state.altitude, 0.5 * (state.altitude[1:] + state.altitude[:-1])))

    def at(values: Floats) -> Floats:
        return np.interp(altitude, state.altitude, values)

    return replace(
        state,
        altitude=altitude,
        pressure=np.exp(at(np.log(state.pressure))),
        temperature=at(state.temperature),
        mole_fraction={gas: at(values) for gas, values in state.mole_fraction.items()},
        aerosols=tuple(replace(part, extinction_550=at(part.extinction_550)) for part in state.aerosols),
    )


def plot(benches: Sequence[AtmosphereBench], path: Path) -> None:
    """Draw error against time of each ladder, a row a band, both axes logarithmic."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    ladders = list(benches[0].ladders)
    figure = Figure(figsize=(5 * len(ladders), 4.2 * len(benches)), layout="constrained")
    FigureCanvasAgg(figure)
    for row, bench in zip(figure.subplots(len(benches), len(ladders), squeeze=False), benches, strict=True):
        for axes, name in zip(row, ladders, strict=True):
            rungs = bench.ladders[name]
            for quantity in rungs[0].errors:
                axes.loglog(
                    [rung.seconds for rung in rungs], [rung.errors[quantity] for rung in rungs], "o-", label=quantity
                )
            for rung in rungs:
                axes.annotate(
                    rung.name,
                    (rung.seconds, max(rung.errors.values())),
                    textcoords="offset points",
                    xytext=(4, 4),
                    fontsize=8,
                )
            axes.set(title=f"{bench.band}: {name}", xlabel="processor time [s]", ylabel="rms relative error")
            axes.grid(alpha=0.3, which="both")
            axes.legend(fontsize=8)
    figure.savefig(path, dpi=110, metadata={"Software": None})


def _errors(table: AtmosphericQuantities, exact: AtmosphericQuantities) -> dict[str, float]:
    """Rms relative error of each quantity on the cells above the ground."""
    errors = {}
    for name in _QUANTITIES:
        ours, theirs = (getattr(one, name)[exact.valid] for one in (table, exact))
        size = np.maximum(theirs, _FLOOR * theirs.max())
        errors[name] = float(np.sqrt(np.mean(((ours - theirs) / size) ** 2)))
    return errors


def _timed(action: Callable[[], Result]) -> tuple[Result, float]:
    """Result and processor seconds of an action."""
    start = time.process_time()
    result = action()
    return result, time.process_time() - start
