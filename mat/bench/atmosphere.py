"""Run time of the atmospheric tables beside LOWTRAN7 called for each line of sight, and error against run time.

The full table has the default axes of a job. LOWTRAN7 computes single cells of it, drawn at random: path radiance with
sunlight, single and multiple scattering, at its own spectral step. Times are seconds of processor time, which other
work on the machine changes less than the clock; the table's wall time stands beside it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import TypeVar

import numpy as np

from skyshine.mat.atmosphere.band.compile import compile_band
from skyshine.mat.atmosphere.band.points import BandPoints, band_points
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.sky import sky_irradiance
from skyshine.mat.atmosphere.transfer.stream_count import azimuthal_count
from skyshine.mat.bench import lowtran
from skyshine.mat.job.atmosphere import AtmosphereGrid
from skyshine.mat.job.default_nodes import OBSERVER_HEIGHTS_KM
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.results import AtmosphericQuantities
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.process_memory import peak_memory

Result = TypeVar("Result")
BANDS = {"3-5 um": (3.0, 5.0), "8-12 um": (8.0, 12.0)}
QUICK_BANDS = {"10-10.5 um": (10.0, 10.5)}
PROFILE, VISIBILITY = "midlatitude_summer", 23.0  # km
POINTS = (4, 16, 64)
DIRECTIONS = (2, 4, 8, 16)
STREAMS, _MOST_NODES = (2, 4, 6, 8), 16  # nodes of a hemisphere
_CLOUD = (1e3, 1.5e3, 10.0, 5.0)  # base and top, m; effective radius, um; optical depth
_PEER_CELLS = 24
# m; with levels above, or with as many levels as it takes otherwise, its multiple scattering gives no numbers.
_PEER_TOP = 60e3
_PEER_LEVELS = lowtran.MAX_LEVELS - 1
# Cells on which the ladders of points and layers are judged.
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
    cells : int
        Of the full table.
    points, total_points : int
        Spectral points of the compiled band and of all.
    seconds : dict
        By stage, "compile" and "table": (processor, wall) seconds.
    peak_memory : int or None
        Of the process until then, bytes; None where the system does not say.
    peer_seconds : float or None
        Of LOWTRAN7 for each cell, mean.
    ladders : dict of list of AtmosphereRung
        "points", "directions", "layers", "streams".
    """

    band: str
    cells: int
    points: int
    total_points: int
    seconds: dict[str, tuple[float, float]]
    peak_memory: int | None
    peer_seconds: float | None
    ladders: dict[str, list[AtmosphereRung]]

    @property
    def cells_per_second(self) -> float:
        """Of processor time."""
        return self.cells / sum(processor for processor, _ in self.seconds.values())

    @property
    def ratio(self) -> float | None:
        """How many times as many cells as LOWTRAN7 in the same time."""
        return None if self.peer_seconds is None else self.cells_per_second * self.peer_seconds


def bench_band(
    name: str,
    limits: tuple[float, float],
    *,
    program: Path | None = None,
    quick: bool = False,
    advance: Callable[[int], object] = lambda _: None,
) -> AtmosphereBench:
    """Measure one band.

    Parameters
    ----------
    name : str
    limits : (float, float)
        um.
    program : Path, optional
        LOWTRAN7, from `lowtran.build`.
    quick : bool
        A table of the few cells of the ladders in place of the full one.
    advance : callable, optional
        Called after each of the six stages.
    """
    grid = _SMALL if quick else default_grid()
    state = AtmosphericState.from_profile(PROFILE, aerosol=Aerosol("rural", visibility_km=VISIBILITY))
    response = SpectralResponse.rectangular(*limits)
    seconds: dict[str, tuple[float, float]] = {}
    with _Stopwatch(seconds, "compile"):
        everything = band_points(AbsorptionTable.open().points(*response.wavenumber_range), response)
        sun = solar_irradiance(everything.wavenumber, everything.width)
        compiled = compile_band(state, everything, grid, sun)
    with _Stopwatch(seconds, "table"):
        BandAtmosphere.of(state, compiled.band).table(grid, sun[compiled.index])
    peak = peak_memory()
    advance(1)
    peer = None if program is None else peer_seconds(program, state, grid, limits)
    advance(1)
    rungs = {"points": points_ladder(state, everything, grid, sun)}
    advance(1)
    rungs["directions"] = directions_ladder(state, compiled.band)
    advance(1)
    rungs["layers"] = layers_ladder(state, compiled.band, sun[compiled.index])
    advance(1)
    rungs["streams"] = streams_ladder(compiled.band, sun[compiled.index])
    advance(1)
    cells = int(np.prod(grid.shape))
    return AtmosphereBench(name, cells, compiled.index.size, compiled.total_points, seconds, peak, peer, rungs)


def default_grid() -> PathGrid:
    """The axes that a job has by default."""
    axes = AtmosphereGrid()
    return PathGrid(
        np.array(axes.range_km),
        np.array(OBSERVER_HEIGHTS_KM),
        np.array(axes.elevation_deg),
        np.array(axes.source_elevation_deg),
        np.array(axes.source_azimuth_deg),
    )


def peer_seconds(program: Path, state: AtmosphericState, grid: PathGrid, limits: tuple[float, float]) -> float:
    """Mean processor seconds of LOWTRAN7 for a cell of a grid, at cells above the ground drawn at random."""
    generator = np.random.default_rng(0)
    low, high = (5.0 * round(1e4 / edge / 5.0) for edge in reversed(limits))
    highest = int(np.searchsorted(state.altitude, _PEER_TOP, side="right")) - 1
    levels = np.unique(np.linspace(0, highest, _PEER_LEVELS).astype(int))
    air = thinned(replace(state, aerosols=()), levels)
    up = grid.elevation_deg[(grid.elevation_deg > 0) & (grid.elevation_deg < 90)]
    sights = [
        lowtran.Sight(
            1e3 * generator.choice(grid.altitude_km[grid.altitude_km < 20]),
            generator.choice(up),
            1e3 * generator.choice(grid.range_km[(grid.range_km >= 1) & (grid.range_km <= 40)]),
            sun=(
                generator.choice(grid.source_elevation_deg[grid.source_elevation_deg > 0]),
                generator.choice(grid.source_azimuth_deg),
            ),
        )
        for _ in range(_PEER_CELLS)
    ]
    haze = lowtran.Haze(aerosol=1, visibility=VISIBILITY)
    return float(lowtran.run(program, air, sights, low, high, haze=haze).seconds.mean())


def points_ladder(state: AtmosphericState, everything: BandPoints, grid: PathGrid, sun: Floats) -> list[AtmosphereRung]:
    """Compiled bands of a few points to many, against all points."""
    exact = BandAtmosphere.of(state, everything).table(_SMALL, sun)
    rungs = []
    for count in POINTS:
        few = compile_band(state, everything, grid, sun, tolerance=1e-6, max_points=count)
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


def thinned(state: AtmosphericState, levels: Integers) -> AtmosphericState:
    """A state at some of its levels, by their indices."""
    return replace(
        state,
        altitude=state.altitude[levels],
        pressure=state.pressure[levels],
        temperature=state.temperature[levels],
        mole_fraction={gas: values[levels] for gas, values in state.mole_fraction.items()},
        aerosols=tuple(replace(part, extinction_550=part.extinction_550[levels]) for part in state.aerosols),
    )


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


class _Stopwatch:
    """Writes (processor, wall) seconds of a `with` block into a dict."""

    def __init__(self, seconds: dict[str, tuple[float, float]], name: str) -> None:
        self.seconds, self.name = seconds, name

    def __enter__(self) -> None:
        self.start = time.process_time(), time.perf_counter()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.seconds[self.name] = time.process_time() - self.start[0], time.perf_counter() - self.start[1]
