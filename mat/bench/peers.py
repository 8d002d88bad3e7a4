"""Peers of a job: they compute no pixel, so each part is compared by seconds at an error that both reach."""

from __future__ import annotations

import importlib.util
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.band.selection import select_points
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.layer_columns import vertical_column
from skyshine.mat.atmosphere.transfer.line_of_sight import lines_of_sight
from skyshine.mat.atmosphere.transfer.ordinate_light import level_light
from skyshine.mat.bench import lowtran
from skyshine.mat.bench.marching import march
from skyshine.mat.bench.rungs import Rung
from skyshine.mat.job.model import Job
from skyshine.mat.quantities.formulas import mean_transmittance
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import all_points, response_of
from skyshine.mat.scene.grids import path_grid
from skyshine.mat.scene.surface import scene_inputs, surface_materials
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.solver import solve_columns
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.errors import InputError
from skyshine.schemas.quantity import quantity

_PEER_CELLS = 24  # random cells of the grid for each peer
# m; with levels above, or with as many levels as it takes otherwise, its multiple scattering gives no numbers.
_PEER_TOP = 60e3
_PEER_LEVELS = lowtran.MAX_LEVELS - 1
VISIBILITY = 23.0  # km, of rural haze
# The paths on which bands are compiled: those of a usual job.
GRID = PathGrid(
    range_km=np.array([0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100.0]),
    altitude_km=np.array([0.0, 0.5, 1, 2, 4, 8, 12]),
    elevation_deg=np.array([-90.0, -60, -30, -15, -5, 0, 5, 15, 30, 60, 90]),
    source_elevation_deg=np.array([5.0, 30, 60, 90]),
    source_azimuth_deg=np.array([0.0, 90, 180]),
)
# Spectral points of ours that are tried, out of so many candidates.
_POINTS, _CANDIDATES = (1, 2, 4, 8, 16), 400
# Settings of the heat balance: steps a day of ours; steps, days, cells a layer and theta of marching schemes, and of
# the finest, by which both are judged.
_STEPS = (24, 48, 96, 144)
_MARCHES = ((24, 5, 5, 1.0), (96, 5, 10, 0.5), (288, 8, 20, 0.5))
_FINEST = (576, 10, 30, 0.5)
_SLOPES, _AZIMUTHS = (0.0, 45.0, 90.0), (0.0, 90.0, 180.0, 270.0)  # degree
_READS = 20_000
# Settings of scattering: points of a band, of which the most transparent fourth part is compared; the Sun's elevation,
# degree.
_SCATTERING_POINTS, _SUN_DEG, _MANY_STREAMS = 32, 60.0, 24


@dataclass(frozen=True)
class Measured:
    """Processor seconds and error of a setting."""

    name: str
    seconds: float
    error: float


def matched(ours: Sequence[Measured], theirs: Sequence[Measured]) -> tuple[float, Measured, Measured]:
    """The least error that some setting of both reaches, and the quickest setting of each that does.

    Examples
    --------
    >>> error, own, peer = matched([Measured("a", 1.0, 0.3), Measured("b", 2.0, 0.1)], [Measured("c", 9.0, 0.2)])
    >>> error, own.name, peer.name
    (0.2, 'b', 'c')
    """
    error = max(min(setting.error for setting in method) for method in (ours, theirs))
    quickest = [
        min((setting for setting in method if setting.error <= error), key=lambda setting: setting.seconds)
        for method in (ours, theirs)
    ]
    return error, quickest[0], quickest[1]


@dataclass(frozen=True)
class EqualError:
    """Seconds of a unit of work at an error that both reach.

    Attributes
    ----------
    error : float
        In `units`.
    ours, theirs : float
        Processor seconds of a unit of work.
    note : str
        Settings that reach the error, and by what they are judged.
    """

    work: str
    peer: str
    error: float
    units: str
    ours: float
    theirs: float
    note: str

    @classmethod
    def of(
        cls, work: str, peer: str, units: str, ours: Sequence[Measured], theirs: Sequence[Measured], judged: str
    ) -> EqualError:
        """The comparison of settings, and by what they are judged."""
        error, setting, peer_setting = matched(ours, theirs)
        note = f"{setting.name} beside {peer_setting.name}; {judged}"
        return cls(work, peer, error, units, setting.seconds, peer_setting.seconds, note)

    @property
    def described(self) -> dict[str, Any]:
        """As plain values."""
        return {
            "work": self.work,
            "peer": self.peer,
            "error": quantity(self.error, self.units),
            "time_of_this_job": quantity(self.ours, "s"),
            "time": quantity(self.theirs, "s"),
            "note": self.note,
        }


def spectra(
    program: Path, job: Job, state: AtmosphericState, sights: Sequence[lowtran.Sight], response: SpectralResponse
) -> EqualError:
    """In-band transmittance of lines of sight by LOWTRAN7 and by few of our points, judged by all of them.

    Parameters
    ----------
    program : Path
        LOWTRAN7, from `lowtran.built_program`.
    state : AtmosphericState
        Air without particles, on levels that LOWTRAN7 takes.
    """
    low, high = (5.0 * round(1e4 / edge / 5.0) for edge in (response.upper, response.lower))
    sights = [replace(sight, sun=None) for sight in sights]
    peer = lowtran.run(program, state, sights, low, high)
    by_wavelength = peer.wavenumber**-2.0
    of_peer = peer.transmittance @ by_wavelength / by_wavelength.sum()
    everything = all_points(response, job.water_continuum)
    geometry = [np.array([getattr(sight, name) for sight in sights]) for name in ("distance", "altitude", "elevation")]

    def depths(index: Any) -> tuple[Floats, float]:
        """Optical depths (M, k) at some points, and the processor seconds of a line."""
        points = everything.points.subset(index)
        air = SpectralAir.of(state, points, everything.gases, everything.weight[index])
        begin = time.process_time()
        paths = lines_of_sight(air, geometry[0][:, None], geometry[1], np.radians(geometry[2]))
        depth = np.array([path.depth[0] for path in paths], float)
        return depth, (time.process_time() - begin) / len(sights)

    depth, _ = depths(np.arange(everything.weight.size))
    exact = np.exp(mean_transmittance(depth, everything.weight, everything.weight.sum())[0])
    order = np.argsort(depth.mean(axis=0))
    candidates = order[np.unique(np.linspace(0, order.size - 1, _CANDIDATES).astype(int))]
    fit, test = slice(0, None, 2), slice(1, None, 2)
    ours = []
    for count in _POINTS:
        chosen, weight, _ = select_points(
            np.exp(-depth[fit][:, candidates]).T, exact[fit], tolerance=0.0, max_points=count, total_weight=1.0
        )
        reduced_depth, seconds = depths(candidates[chosen])
        error = np.exp(-reduced_depth[test]) @ weight - exact[test]
        ours.append(Measured(f"{count} points", seconds, float(np.sqrt(np.mean(error**2)))))
    theirs = [
        Measured("steps of 5 cm^-1", float(peer.seconds.mean()), float(np.sqrt(np.mean((of_peer - exact)[test] ** 2))))
    ]
    work = f"transmittance of a line of sight, {response.lower:g}-{response.upper:g} um, gases alone"
    judged = f"root mean square against all {everything.weight.size} points"
    return EqualError.of(work, "LOWTRAN7", "1", ours, theirs, judged)


def scattering(job: Job, state: AtmosphericState, response: SpectralResponse) -> EqualError:
    """Diffuse light of the Sun at points of a band by our discrete ordinates and by PythonicDISORT, in the layers of a
    state, judged by PythonicDISORT with many streams.
    """
    from PythonicDISORT import pydisort

    everything = all_points(response, job.water_continuum)
    index = np.linspace(0, everything.weight.size - 1, _SCATTERING_POINTS).astype(int)
    air = SpectralAir.of(state, everything.points.subset(index), everything.gases, everything.weight[index])
    optics, sine = air.optics, np.sin(np.radians(_SUN_DEG))
    albedo = np.broadcast_to(state.albedo_at(optics.wavenumber), index.shape)
    depth = vertical_column(air.shells, optics.extinction)
    particles = vertical_column(air.shells, optics.aerosol_scattering)
    scattered = particles + vertical_column(air.shells, optics.rayleigh)
    transparent = np.argsort(depth.sum(axis=0))[: _SCATTERING_POINTS // 4]

    def of_peer(streams: int) -> tuple[Floats, float]:
        """Flux up at the top and down at the ground (2, p) of the most transparent points; seconds of a point."""
        flux, begin = [], time.process_time()
        for point in transparent:
            moments = optics.moments[: streams + 1] @ optics.phase_share[:, point]  # (L, N)
            share = (particles / scattered)[:, point]
            mixed = share * 0.5 * (moments[:, 1:] + moments[:, :-1])
            mixed[0] += 1 - share
            mixed[2] += 0.1 * (1 - share)  # second moment of molecules
            down = slice(None, None, -1)
            ends = np.cumsum(depth[down, point])
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # albedos near 1
                _, up, falling, *_ = pydisort(
                    ends,
                    np.minimum((scattered / depth)[down, point], 1 - 1e-9),
                    streams,
                    mixed.T[down],
                    float(sine),
                    1.0,
                    0.0,
                    NLeg=streams,
                    only_flux=True,
                    f_arr=np.clip(mixed[streams, down], 0.0, None),
                    BDRF_Fourier_modes=[float(albedo[point])],
                )
            flux.append((float(up(0.0)), float(np.sum(falling(ends[-1])))))
        return np.array(flux).T, (time.process_time() - begin) / transparent.size

    def of_ours(nodes: int) -> tuple[Floats, float]:
        begin, scaled = time.process_time(), replace(air, nodes=nodes)
        rising, falling = level_light(
            state,
            air.shells,
            optics,
            scaled.delta_fraction,
            scaled.scaled_source_paths,
            np.array([sine]),
            albedo,
            nodes,
        )
        seconds = (time.process_time() - begin) / _SCATTERING_POINTS
        beam = sine * np.exp(-vertical_column(air.shells, scaled.scaled_extinction).sum(axis=0) / sine)
        return np.stack([rising[-1, 0], falling[0, 0] + beam])[:, transparent], seconds

    reference, _ = of_peer(_MANY_STREAMS)

    def measured(name: str, flux: Floats, seconds: float) -> Measured:
        return Measured(name, seconds, float(np.sqrt(np.mean((flux - reference) ** 2)) / sine))

    ours = [measured(f"{2 * nodes} streams", *of_ours(nodes)) for nodes in (2, 3, 4, 6)]
    theirs = [measured(f"{streams} streams", *of_peer(streams)) for streams in (4, 6, 8, 12)]
    work = f"diffuse light of a point, {response.lower:g}-{response.upper:g} um"
    judged = f"flux at top and ground over that of the Sun, against its {_MANY_STREAMS} streams"
    return EqualError.of(work, "PythonicDISORT", "1", ours, theirs, judged)


def surfaces(job: Job, library: MaterialLibrary, names: Sequence[str]) -> EqualError | None:
    """Temperatures of one material on planes of all slopes by our solver and by marching schemes, judged by the finest
    of these; None where no material has layers alone.
    """
    inputs = scene_inputs(job, 1)
    stacks = surface_materials([library[name] for name in names], job.operated, inputs[1].wetting)
    material = next((stack for stack in stacks if stack.canopy is None and stack.thermal.layers), None)
    if material is None:
        return None
    slope, azimuth = (part.ravel() for part in np.meshgrid(_SLOPES, _AZIMUTHS))
    altitude = np.array([1e3 * job.surface_altitudes_km[0]])

    @cache
    def forcing(steps: int) -> Forcing:
        return Scene(*inputs, altitude, slope, azimuth).forcing(steps)

    def by_solver(steps: int) -> Floats:
        temperature = np.empty(forcing(steps).shape)
        for columns, solution in solve_columns(material, forcing, steps=steps, fine_steps=None):
            temperature[columns] = solution.temperature
        return temperature

    def by_marching(steps: int, days: int, cells: int, theta: float) -> Floats:
        return march(material, forcing(steps), steps, days, cells, theta)

    reference = by_marching(*_FINEST)

    def measured(name: str, solve: Callable[[], Floats]) -> Measured:
        solve()  # computes the forcing
        begin = time.process_time()
        temperature = solve()
        seconds = (time.process_time() - begin) / slope.size
        steps = np.gcd(temperature.shape[1], reference.shape[1])
        error = temperature[:, :: temperature.shape[1] // steps] - reference[:, :: reference.shape[1] // steps]
        return Measured(name, seconds, float(np.sqrt(np.mean(error**2))))

    ours = [measured(f"{steps} steps", partial(by_solver, steps)) for steps in _STEPS]
    theirs = [
        measured(f"{setting[0]} steps and {setting[1]} days", partial(by_marching, *setting)) for setting in _MARCHES
    ]
    judged = f"root mean square against {_FINEST[0]} steps, {_FINEST[2]} cells a layer"
    return EqualError.of(f"a day of a face of {material.name}", "marching in time", "K", ours, theirs, judged)


def reading(table: TemperatureTable) -> list[EqualError]:
    """Interpolated temperatures at random coordinates by our reader, by scipy and by xarray, where it is installed."""
    from scipy.interpolate import RegularGridInterpolator

    variable, generator = table.root.variables["temperature"], np.random.default_rng(0)
    nodes = {name: np.asarray(table.root.axes[name].values, float) for name in variable.dims}
    values = np.asarray(variable.data, float)
    for name, period in (("azimuth", 360.0), ("time", 24.0)):  # around to the first node again
        dimension = variable.dims.index(name)
        if nodes[name].size > 1:
            values = np.concatenate([values, np.take(values, [0], axis=dimension)], axis=dimension)
            nodes[name] = np.append(nodes[name], nodes[name][0] + period)
    where = {name: generator.uniform(axis[0], axis[-1], _READS) for name, axis in nodes.items()}
    codes, nodes["material"] = nodes["material"].astype(int), np.arange(nodes["material"].size, dtype=float)
    where["material"] = generator.integers(codes.size, size=_READS).astype(float)
    coordinates = where | {"material": codes[where["material"].astype(int)]}
    clamped = table.clamped()
    axis_names = [name for name in variable.dims if nodes[name].size > 1]
    squeezed = values.reshape([nodes[name].size for name in axis_names])
    by_scipy = RegularGridInterpolator([nodes[name] for name in axis_names], squeezed)
    reads: dict[str, Callable[[], Any]] = {
        "ours": lambda: clamped.value("temperature", **coordinates),
        "scipy": lambda: by_scipy(np.stack([where[name] for name in axis_names], axis=-1)),
    }
    try:
        import xarray
    except ImportError:
        pass
    else:
        array = xarray.DataArray(squeezed, {name: nodes[name] for name in axis_names}, axis_names)
        reads["xarray"] = lambda: array.interp({name: ("read", where[name]) for name in axis_names}).values
    results, seconds = {}, {}
    for name, read in reads.items():
        read()
        begin = time.process_time()
        results[name] = np.asarray(read(), float)
        seconds[name] = (time.process_time() - begin) / _READS
    return [
        EqualError(
            "a read of a temperature",
            name,
            float(np.abs(result - results["ours"]).max()),
            "K",
            seconds["ours"],
            seconds[name],
            f"linear between the same nodes; largest difference of {_READS:,} reads in one call",
        )
        for name, result in results.items()
        if name != "ours"
    ]


def comparisons(
    rung: Rung, library: MaterialLibrary, *, lowtran_path: str | None, say: Callable[[str], object]
) -> tuple[list[EqualError], dict[str, str]]:
    """All comparisons that can be made here, and why the other peers are absent.

    Parameters
    ----------
    rung : Rung
        The job as it is written, built.
    lowtran_path : str, optional
        Path as in `lowtran.find_source`.
    say : callable
        Called with a line of text that says what is measured.

    Raises
    ------
    InputError
        `lowtran_path` leads to no source.
    """
    say("measuring peers")
    job, measured, absent = rung.loaded.trimmed, list[EqualError](), dict[str, str]()
    response = response_of(job.bands[job.needed_bands[0] - 1])
    air = replace(atmospheric_state(job.site, job.states[0]), aerosols=())
    program, reason = lowtran.built_program(lowtran_path)
    if program is None:
        absent["LOWTRAN7"] = reason
    else:
        highest = int(np.searchsorted(air.altitude, _PEER_TOP, side="right")) - 1
        levels = np.unique(np.linspace(0, highest, _PEER_LEVELS).astype(int))
        try:
            measured.append(spectra(program, job, thinned(air, levels), _sights(path_grid(job)), response))
        except InputError as error:
            absent["LOWTRAN7"] = str(error)
    if importlib.util.find_spec("PythonicDISORT") is None:
        absent["PythonicDISORT"] = "it is not installed"
    else:
        measured.append(scattering(job, atmospheric_state(job.site, job.states[0]), response))
    surface = rung.tables(1, job.needed_bands[0], job.sources[0]).surface
    if (day := surfaces(job, library, tuple(surface.materials))) is not None:
        measured.append(day)
    return [*measured, *reading(surface)], absent


def _sights(grid: PathGrid) -> list[lowtran.Sight]:
    """Lines of sight at random nodes of a job's axes, above the ground."""
    generator, grid = np.random.default_rng(0), _for_peer(grid)
    up = grid.elevation_deg[(grid.elevation_deg > 0) & (grid.elevation_deg < 90)]
    low, far = grid.altitude_km[grid.altitude_km < 20], grid.range_km[(grid.range_km >= 1) & (grid.range_km <= 40)]
    geometry = [generator.choice(nodes, _PEER_CELLS) for nodes in (1e3 * low, up, 1e3 * far)]
    return [
        lowtran.Sight(float(height), float(angle), float(away)) for height, angle, away in zip(*geometry, strict=True)
    ]


def _for_peer(grid: PathGrid) -> PathGrid:
    """The axes of which the peer's lines of sight are drawn: those of the job, or usual ones where the job names none
    that it computes.
    """
    up = (grid.elevation_deg > 0) & (grid.elevation_deg < 90)
    far = (grid.range_km >= 1) & (grid.range_km <= 40)
    covered = up.any() and far.any() and (grid.altitude_km < 20).any() and (grid.source_elevation_deg > 0).any()
    return grid if covered else GRID


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
