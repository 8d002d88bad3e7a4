"""Error against run time of gas absorption: line by line, the band model from all points to a few, LOWTRAN7.

The atmosphere has no particles; its profile and the lines of sight were not used to choose spectral points. Errors are
those of transmittance against line by line, or against all points where there are no line lists. A gas that the line
lists do not contain is removed from the atmosphere for all methods. Times are medians of repeats in seconds of
processor time, which hardly depends on the load of the machine; give the process one thread.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import ladders
import numpy as np

from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.gases.spectral_points import SpectralPoints
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.geometry import Shells, trace
from skyshine.mat.atmosphere.transfer.optics import rayleigh_scattering, spectral_optics
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.thermal_light import ThermalLight
from skyshine.mat.atmosphere.transfer.thermal_source import ThermalSource
from skyshine.mat.bench import lowtran
from skyshine.mat.radiometry.blackbody import SpectralResponse, planck_wavenumber
from skyshine.mat.spectroscopy.training import HELD_OUT_PROFILE
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.errors import InputError

if TYPE_CHECKING:
    from skyshine.mat.spectroscopy.continua import ContinuumModel
    from skyshine.mat.spectroscopy.gases import LineLibrary

Result = TypeVar("Result")
BANDS = {"3-5 um": (3.0, 5.0), "8-12 um": (8.0, 12.0)}
QUICK_BANDS = {"4.7-5 um": (4.7, 5.0), "10.5-12 um": (10.5, 12.0)}
WIDTHS = (10.0, 20.0, 40.0)  # cm^-1
COUNTS = (8, 16, 32, 48, 64, 128)
# Altitudes [m] at which the atmosphere is given, to everyone: as many as LOWTRAN7 takes, dense where water vapour is.
_LEVELS = 1e3 * np.array([*np.arange(0, 4, 0.5), *range(4, 13), 14, 16, 18, 20, 23, 26, 31, 36, 41, 50, 60, 80, 100])
SIGHTS = {
    "vertical": (
        lowtran.Sight(0.0, 90.0, np.inf),
        lowtran.Sight(1200.0, -90.0, 1100.0),
        lowtran.Sight(9000.0, -90.0, 8900.0),
    ),
    "slant": (
        lowtran.Sight(0.0, 17.0, np.inf),
        lowtran.Sight(400.0, -9.0, 2300.0),
        lowtran.Sight(2600.0, -14.0, 10200.0),
        lowtran.Sight(6500.0, -31.0, 12200.0),
        lowtran.Sight(200.0, 6.0, 24000.0),
    ),
    "horizontal": (
        lowtran.Sight(50.0, 0.0, 350.0),
        lowtran.Sight(50.0, 0.0, 3100.0),
        lowtran.Sight(900.0, 0.0, 9000.0),
        lowtran.Sight(4300.0, 0.0, 22000.0),
    ),
}
_REPEATS, _LEAST_SECONDS = 7, 0.3  # lower limits of each measurement
REFERENCE_NAME, PEER_NAME = "line by line", "LOWTRAN7"


@dataclass(frozen=True, eq=False)
class Means:
    """Spectral means of M lines of sight.

    Attributes
    ----------
    group : (I,) int array
        The wide interval of each interval of the table; -1 for those that have no value.
    transmittance, radiance : (M, G) arrays
        Of each wide interval; radiance in W m^-2 sr^-1 (cm^-1)^-1. Empty (M, 0) for compiled bands.
    in_band, in_band_radiance : (M,) arrays
        Radiance in W m^-2 sr^-1.
    points : int
        Wavenumbers at which a line of sight is computed.
    prepare, line : float
        Processor seconds for the state, once, and for each line of sight.
    """

    group: Integers
    transmittance: Floats
    radiance: Floats
    in_band: Floats
    in_band_radiance: Floats
    points: int
    prepare: float
    line: float


class AbsorptionScene:
    """The atmosphere, the lines of sight and the intervals of one band."""

    def __init__(self, band: tuple[float, float], gases: Sequence[str]) -> None:
        self.response = SpectralResponse.rectangular(*band)
        self.state = _bench_state(gases)
        self.table = AbsorptionTable.open()
        self.points = self.table.points(1e4 / band[1], 1e4 / band[0])
        self.band = band_points(self.points, self.response)
        edges = self.points.interval_edges
        self.low, self.high = float(edges[0, 0]), float(edges[-1, 1])
        # Of each interval in the band: um, and cm^-1 for radiance.
        count = len(edges)
        self.weight = np.bincount(self.band.points.interval, self.band.weight, count)
        self.radiance_weight = np.bincount(self.band.points.interval, self.band.radiance_weight, count)
        self.sights = [sight for sights in SIGHTS.values() for sight in sights]
        self.kind = np.array([kind for kind, sights in SIGHTS.items() for _ in sights])
        self.middle = edges.mean(axis=1)

    @property
    def blackbody(self) -> float:
        """Band radiance of a black body at the temperature of the lowest air, W m^-2 sr^-1."""
        return float(self.radiance_weight @ planck_wavenumber(self.middle, self.state.temperature[0]))

    def rays(self) -> tuple[Shells, list[Segments]]:
        """The traced lines of sight: layers, and the segments of each."""
        shells = Shells.of(self.state.altitude, self.state.number_density, 0.5 * (self.low + self.high))
        altitude, elevation, distance = (
            np.array([getattr(sight, name) for sight in self.sights]) for name in ("altitude", "elevation", "distance")
        )
        reach = np.minimum(distance, np.finfo(float).max)[:, None]
        rays = trace(shells, altitude, np.radians(elevation), reach)
        return shells, [Segments.of(rays, row).within(length) for row, length in enumerate(distance)]

    def in_band(self, transmittance: Floats, radiance: Floats) -> tuple[Floats, Floats]:
        """In-band means of interval means (M, I)."""
        return transmittance @ self.weight / self.weight.sum(), radiance @ self.radiance_weight


def _bench_state(gases: Sequence[str]) -> AtmosphericState:
    """The profile at the levels that LOWTRAN7 takes too, with some of its gases and without particles."""
    full = AtmosphericState.from_profile(HELD_OUT_PROFILE, aerosol=Aerosol("none"))
    level = np.unique([int(np.argmin(np.abs(full.altitude - altitude))) for altitude in _LEVELS])
    fractions = {gas: values[level] for gas, values in full.mole_fraction.items() if gas in gases}
    return replace(
        full,
        altitude=full.altitude[level],
        pressure=full.pressure[level],
        temperature=full.temperature[level],
        mole_fraction=fractions,
    )


def line_quantities(
    segments: Sequence[Segments], extinction: Floats, emission: Floats, levels: Floats
) -> tuple[Floats, Floats]:
    """Transmittance and thermal path radiance of each line of sight, (M, P) arrays.

    Parameters
    ----------
    segments : list of Segments
    extinction, emission : (N, P) arrays
        m^2 per molecule of air; W m^-2 sr^-1 (cm^-1)^-1.
    levels : (N,) array
        m.
    """
    through, radiance = [], []
    light = ThermalLight(ThermalSource(levels, emission, None), float)
    for part in segments:
        depths = Depths(part.column(extinction))
        through.append(np.exp(-depths.cumulative[-1]))
        radiance.append(light.of_segments(part, depths).sum(axis=0))
    return np.array(through), np.array(radiance)


def _median(action: Callable[[], Result]) -> tuple[Result, float]:
    """Result and median processor seconds of an action."""
    seconds: list[float] = []
    while len(seconds) < _REPEATS or sum(seconds) < _LEAST_SECONDS:
        start = time.process_time()
        result = action()
        seconds.append(time.process_time() - start)
    return result, float(np.median(seconds))


def line_by_line(
    scene: AbsorptionScene,
    library: LineLibrary,
    continua: ContinuumModel,
    gases: Sequence[str],
    advance: Callable[[int], object] | None = None,
) -> Means:
    """The reference; `advance` is called after each interval."""
    from line_by_line_levels import absorption_at_levels

    from skyshine.mat.spectroscopy.linebyline import interval_grid

    shells, segments = scene.rays()
    count, intervals = len(segments), len(scene.middle)
    transmittance, radiance = np.zeros((count, intervals)), np.zeros((count, intervals))
    prepare = line = 0.0
    wavenumbers = 0
    absorption_at_levels(
        library, continua, scene.state, gases, *scene.points.interval_edges[0]
    )  # compiles, reads lines
    for number, (low, high) in enumerate(scene.points.interval_edges):
        wavenumber = interval_grid(low, high)
        start = time.process_time()
        rayleigh, _ = rayleigh_scattering(wavenumber, 100 * scene.state.mole_fraction["CO2"][0])
        extinction = absorption_at_levels(library, continua, scene.state, gases, low, high) + rayleigh
        middle = time.process_time()
        emission = planck_wavenumber(0.5 * (low + high), scene.state.temperature)[:, None] * np.ones(wavenumber.size)
        values = line_quantities(segments, extinction, emission, shells.altitude)
        transmittance[:, number], radiance[:, number] = (value.mean(axis=1) for value in values)
        prepare += middle - start
        line += time.process_time() - middle
        wavenumbers += wavenumber.size
        if advance:
            advance(1)
    in_band, in_band_radiance = scene.in_band(transmittance, radiance)
    return Means(
        np.arange(intervals), transmittance, radiance, in_band, in_band_radiance, wavenumbers, prepare, line / count
    )


def with_points(
    scene: AbsorptionScene,
    index: Integers | None = None,
    weight: Floats | None = None,
    group: Integers | None = None,
) -> Means:
    """The band model at all points, or at some of them with other weights in wider intervals."""
    points = scene.points if index is None or weight is None else scene.points.subset(index, weight)
    group = np.arange(len(scene.middle)) if group is None else group
    values, prepare, line = _computed(scene, points)
    place = group[points.interval]
    share = points.weight / np.bincount(place, points.weight)[place]
    transmittance, radiance = (
        np.array([np.bincount(place, share * row, group[-1] + 1) for row in value]) for value in values
    )
    in_band, in_band_radiance = scene.in_band(transmittance[:, group], radiance[:, group])
    return Means(group, transmittance, radiance, in_band, in_band_radiance, points.wavenumber.size, prepare, line)


def with_compiled(scene: AbsorptionScene, count: int) -> Means:
    """The band compiled to a number of points."""
    band = ladders.compiled(scene.state, scene.points, scene.response, count).band
    (transmittance, radiance), prepare, line = _computed(scene, band.points)
    no_interval = np.zeros((len(transmittance), 0))
    in_band, in_band_radiance = transmittance @ band.weight / band.weight.sum(), radiance @ band.radiance_weight
    group = np.full(len(scene.middle), -1)
    return Means(group, no_interval, no_interval, in_band, in_band_radiance, band.weight.size, prepare, line)


def _compiled_ladder(scene: AbsorptionScene) -> list[Means]:
    """Compiled bands of more and more points, until the compiler takes no more."""
    ladder: list[Means] = []
    for count in COUNTS:
        means = with_compiled(scene, count)
        if ladder and means.points <= ladder[-1].points:
            break
        ladder.append(means)
    return ladder


def _computed(scene: AbsorptionScene, points: SpectralPoints) -> tuple[tuple[Floats, Floats], float, float]:
    """Transmittance and radiance (M, P), and processor seconds of the state and of each line of sight."""
    optics, prepare = _median(lambda: spectral_optics(scene.state, points))

    def lines() -> tuple[Floats, Floats]:
        shells, segments = scene.rays()
        return line_quantities(segments, optics.extinction, optics.emission, shells.altitude)

    values, seconds = _median(lines)
    return values, prepare, seconds / len(scene.sights)


def with_lowtran(scene: AbsorptionScene, program: Path) -> Means:
    """The peer, in wide intervals of its own resolution; it computes every 5 cm^-1."""
    spectra = lowtran.run(program, scene.state, scene.sights, scene.low, scene.high, repeats=4 * _REPEATS)
    transmittance, radiance = (
        0.5 * (value[:, 1:] + value[:, :-1]) for value in (spectra.transmittance, spectra.path_thermal)
    )
    if transmittance.shape[1] != len(scene.middle):
        raise InputError("the absorption table has intervals of another width than LOWTRAN7; leave it out")
    in_band, in_band_radiance = scene.in_band(transmittance, radiance)
    group = np.floor((scene.middle - scene.low) / lowtran.RESOLUTION).astype(int)
    wide, wide_radiance = (_grouped(value, group) for value in (transmittance, radiance))
    line = float(np.median(spectra.seconds[1:]))
    return Means(group, wide, wide_radiance, in_band, in_band_radiance, spectra.wavenumber.size, 0.0, line)


def _grouped(values: Floats, group: Integers) -> Floats:
    """Means (M, G) of interval means (M, I)."""
    count = np.bincount(group)
    return np.array([np.bincount(group, row) / count for row in values])


Errors = dict[str, dict[str, float | None]]  # by kind of path and measure


def errors(scene: AbsorptionScene, means: Means, reference: Means) -> Errors:
    """Errors of transmittance and thermal path radiance against the reference, by kind of path and of all.

    Returns
    -------
    dict
        "all", "vertical", ...: {"in_band_rms", "in_band_max", "interval_rms", "interval_max" (None for compiled bands),
        "radiance_rms" (fraction of the black body of the lowest air)}.
    """
    in_band = means.in_band - reference.in_band
    radiance = (means.in_band_radiance - reference.in_band_radiance) / scene.blackbody
    interval = None
    if means.transmittance.size:
        interval = means.transmittance - _grouped(reference.transmittance, means.group)
    result: Errors = {}
    for kind in ("all", *SIGHTS):
        of_kind = np.ones(scene.kind.size, bool) if kind == "all" else scene.kind == kind
        result[kind] = {
            "in_band_rms": _rms(in_band[of_kind]),
            "in_band_max": _largest(in_band[of_kind]),
            "interval_rms": None if interval is None else _rms(interval[of_kind]),
            "interval_max": None if interval is None else _largest(interval[of_kind]),
            "radiance_rms": _rms(radiance[of_kind]),
        }
    return result


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _largest(values: Floats) -> float:
    return float(np.max(np.abs(values)))


@dataclass(frozen=True, eq=False)
class AbsorptionRung:
    """One way of computing a band, with its errors by kind of path (`errors`)."""

    name: str
    width: float | None
    means: Means
    errors: Errors


@dataclass(frozen=True, eq=False)
class AbsorptionBench:
    """The rungs of one band, from exact to fast; `reference` names the first."""

    band: str
    reference: str
    gases: list[str]
    left_out: list[str]
    rungs: list[AbsorptionRung]


def bench_band(
    band: str,
    limits: tuple[float, float],
    *,
    library: LineLibrary | None = None,
    continua: ContinuumModel | None = None,
    program: Path | None = None,
    advance: Callable[[int], object] | None = None,
) -> AbsorptionBench:
    """Measure one band.

    Parameters
    ----------
    band : str
        Its name.
    limits : (float, float)
        um.
    library, continua : LineLibrary, ContinuumModel, optional
        Both or neither; without them all points are the reference.
    program : Path, optional
        LOWTRAN7, from `lowtran.build`.
    advance : callable, optional
        Called after each interval of line by line.
    """
    table = AbsorptionTable.open()
    gases: Sequence[str] = table.gases
    left_out: list[str] = []
    if library is not None and continua is not None:
        from line_by_line_levels import judged_gases

        gases, left_out = judged_gases(library, table, 1e4 / limits[1], 1e4 / limits[0])
    scene = AbsorptionScene(limits, gases)
    width = float(np.max(np.diff(scene.points.interval_edges, axis=1)))
    computed: list[tuple[str, float | None, Means]] = []
    if library is not None and continua is not None:
        computed.append((REFERENCE_NAME, width, line_by_line(scene, library, continua, gases, advance)))
    computed.append((f"all points, {width:g} cm-1", width, with_points(scene)))
    for wide in WIDTHS:
        chosen = ladders.merged_intervals(scene.points, wide, ladders.with_continuum(gases))
        computed.append((f"{wide:g} cm-1", wide, with_points(scene, *chosen)))
    for means in _compiled_ladder(scene):
        computed.append((f"compiled, {means.points} points", None, means))
    if program is not None:
        computed.append((PEER_NAME, lowtran.RESOLUTION, with_lowtran(scene, program)))
    reference = computed[0][2]
    rungs = [AbsorptionRung(name, width, means, errors(scene, means, reference)) for name, width, means in computed]
    return AbsorptionBench(band, computed[0][0], list(gases), left_out, rungs)


def plot(benches: Sequence[AbsorptionBench], path: Path) -> None:
    """Draw error against time per line of sight, a panel a band, both axes logarithmic."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6 * len(benches), 5), layout="constrained")
    FigureCanvasAgg(figure)
    for axes, bench in zip(figure.subplots(1, len(benches), squeeze=False)[0], benches, strict=True):
        for family, marker in (("compiled", "o-"), ("cm-1", "s-"), (PEER_NAME, "X")):
            rungs = [rung for rung in bench.rungs[1:] if family in rung.name]
            if rungs:
                x = [1e3 * rung.means.line for rung in rungs]
                y = [rung.errors["all"]["in_band_rms"] for rung in rungs]
                label = {"cm-1": "intervals", "compiled": "compiled band"}.get(family, family)
                axes.loglog(x, y, marker, label=label)
                for rung, a, b in zip(rungs, x, y, strict=True):
                    text = f"{rung.means.points}" if family == "compiled" else rung.name.replace("all points, ", "")
                    axes.annotate(text, (a, b), textcoords="offset points", xytext=(4, 4), fontsize=8)
        if bench.rungs[0].name == REFERENCE_NAME:
            seconds = 1e3 * (
                bench.rungs[0].means.line + bench.rungs[0].means.prepare / len(bench.rungs[0].means.in_band)
            )
            axes.axvline(seconds, color="grey", linestyle=":", label="line by line (error 0)")
        axes.set(
            title=bench.band,
            xlabel="processor time per line of sight [ms]",
            ylabel="rms error of in-band transmittance",
        )
        axes.grid(alpha=0.3, which="both")
        axes.legend(fontsize=8)
    figure.savefig(path, dpi=110, metadata={"Software": None})
