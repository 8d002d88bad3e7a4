"""What a build takes: processor time, hours on so many cores, disk and memory; and what would take less."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from skyshine.mat.job.fields import tolerance_parts
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.plan.cost import FINEST, FINEST_PRICED, WINDOW, Changes, estimate, film
from skyshine.mat.plan.plan import FLOAT_BYTES, Kind, Plan, grid_values, response_values, surface_values
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.bands import absorption_table, response_of

# Bytes, of seventeen builds that no test of this estimate has. Names and attributes of arrays in a file of air, of
# temperatures and of a band; what else is in the latter two besides tables; a texture.
_AIR_HEADERS, _TEMPERATURE_HEADERS, _BAND_HEADERS = 5.7e4, 5.4e4, 2.9e4
_TEMPERATURES_FILE, _BAND_FILE, _TEXTURE_FILE = 4.5e4, 1e4, 7.5e5
# Channels at 0.5 K: of a band in the window around 3.8 um alone, of another with much light of the first source, and of
# any other; for so many altitudes, of fewer less by a power. They grow as the tolerance falls. All times 0.57, which is
# what storing differences made of two of the test's jobs.
_SUNLIT_CHANNELS, _SHORT_CHANNELS, _CHANNELS, _ALTITUDES, _BY_ALTITUDE = 7.5e5, 2.8e5, 1.2e5, 12, 1.5
# A value of the tables on the axes of a job, of a response, and of temperatures at 0.5 K, whose nodes grow with the
# square as the tolerance falls: 0.6 to 3.6 by site and weather; on wet days.
_GRID_VALUE, _RESPONSE_VALUE, _TEMPERATURE_VALUE, _WET = 0.5, 0.8, 0.9, 1.75
# Bytes of a process: libraries with a sky, a band with each of its spectral points, each further table of the air until
# what is kept is thrown away, each material, and for each byte of the largest table.
_PROCESS, _BAND, _POINT, _FURTHER, _MOST_FURTHER, _MATERIAL, _OF_TABLE = 4.0e8, 9e7, 6.5e4, 1e8, 3, 8e5, 2.0
_START = 1.0  # s by the clock until the first process starts


# s of a processor of the machine on which the constants of `plan.cost` were measured (2.5 GHz server, two cores).
_REFERENCE = 2.5e-3
_TRIALS = 6  # the fastest counts: others were interrupted


@cache
def machine_slowness() -> float:
    """Processor time of a build on this machine over that on the machine of the estimates, from 15 ms of the work that
    builds do: exponentials of long arrays, calls on short ones, Python.
    """
    return min(_trial() for _ in range(_TRIALS)) / _REFERENCE


def _trial() -> float:
    long, short = -np.linspace(0.01, 5.0, 16_000).reshape(16, 1000), np.arange(44.0)
    work = np.zeros_like(long)  # written once: a first use of memory takes as long as the exponentials
    begin = time.process_time()
    for _ in range(16):
        np.cumsum(np.exp(long, out=work), axis=0, out=work)
    for number in range(600):
        (short * 1.5 + number).sum()
    return time.process_time() - begin


@dataclass(frozen=True)
class Resources:
    """What a build takes that keeps and finds nothing, estimated within a factor of 1.5.

    Attributes
    ----------
    seconds : dict of str to float
        Processor seconds on this machine, by stage.
    disk : float
        Bytes of all files.
    memory : float
        Largest bytes of a process.
    tasks : int
        Tasks that can run side by side.
    in_turn : float
        Seconds that no number of processes shortens: the longest texture, then the longest table.
    less : tuple of (str, float)
        Changes of the job that take less, each with all before it, and the processor seconds left.
    """

    seconds: dict[str, float]
    disk: float
    memory: float
    tasks: int
    in_turn: float
    less: tuple[tuple[str, float], ...]

    @property
    def total(self) -> float:
        """Processor seconds of all stages."""
        return sum(self.seconds.values())

    def elapsed(self, cores: int) -> float:
        """Seconds by the clock on so many cores that do nothing else."""
        processes = min(cores, self.tasks)
        working = self.total - self.seconds["start"]
        return _START + self.seconds["start"] + max(working / processes, self.in_turn)


def resources(loaded: LoadedJob, plan: Plan) -> Resources:
    """What the build of a plan takes."""
    slowness = machine_slowness()

    def seconds(changes: Changes) -> dict[str, float]:
        return {stage: slowness * value for stage, value in estimate(loaded, plan, changes).items()}

    as_written = seconds(Changes())
    less: list[tuple[str, float]] = []
    for text, changes in _savings(loaded):
        total = sum(seconds(changes).values())
        if total < 0.95 * (less[-1][1] if less else sum(as_written.values())):
            less.append((text, total))
    return Resources(
        as_written, _disk(loaded, plan), _memory(loaded, plan), len(plan.tasks), _in_turn(plan, as_written), tuple(less)
    )


def together(parts: Sequence[Resources]) -> Resources:
    """What the builds of several sites take."""
    stages = {stage: sum(part.seconds[stage] for part in parts) for stage in parts[0].seconds}
    stages["start"] = parts[0].seconds["start"]
    less = [
        (changes[0][0], sum(total for _, total in changes) - (len(parts) - 1) * stages["start"])
        for changes in zip(*(part.less for part in parts), strict=False)
        if len({text for text, _ in changes}) == 1
    ]
    return Resources(
        stages,
        sum(part.disk for part in parts),
        max(part.memory for part in parts),
        sum(part.tasks for part in parts),
        max(part.in_turn for part in parts),
        tuple(less),
    )


def _savings(loaded: LoadedJob) -> list[tuple[str, Changes]]:
    """Changes of the job that take less, each with those before it."""
    job = loaded.trimmed
    savings: list[tuple[str, Changes]] = []
    changes = Changes()
    if job.output.pictures:
        changes = changes.but(pictures=False)
        savings.append(("output.pictures: false", changes))
    kelvin, unit = tolerance_parts(job.accuracy.pixel)
    if tolerance_parts(job.atmosphere_grid.tolerance) == (kelvin, unit):  # not one that the job writes apart
        changes = changes.but(coarser=2.0)
        savings.append((f"accuracy: {2 * kelvin:g} {unit}", changes))
    if len(job.sources) > 1:
        changes = changes.but(sources=1)
        savings.append((f"sources: [{job.sources[0]}]", changes))
    if len(job.needed_bands) > 1:
        changes = changes.but(bands=len(job.needed_bands) // 2)
        savings.append((f"{changes.bands} of {len(job.needed_bands)} bands", changes))
    return savings


def _disk(loaded: LoadedJob, plan: Plan) -> float:
    job, total = loaded.trimmed, 0.0
    finer = [
        1.0 if grid.tolerance is None else FINEST / max(tolerance_parts(grid.tolerance)[0], FINEST_PRICED)
        for grid in (job.atmosphere_grid, job.surface_grid)
    ]
    altitudes = min(1.0, (len(job.sampled_axes()["altitude_km"]) / _ALTITUDES) ** _BY_ALTITUDE)
    response = _RESPONSE_VALUE * len(plan.materials) * response_values(job)
    for task in plan.tasks:
        if task.kind is Kind.ATMOSPHERE:
            first, other = _channel_bytes(response_of(job.bands[task.band - 1]))
            channels = (first + (len(task.files) - 1) * other) * altitudes * finer[0]
            total += len(task.files) * (_AIR_HEADERS + _GRID_VALUE * grid_values(job)) + channels
        elif task.kind is Kind.TEMPERATURE:
            wet = min(film(job.states[task.index - 1]), _WET)
            tables = _TEMPERATURE_VALUE * len(plan.materials) * surface_values(job) * finer[1] ** 2 * wet
            total += _TEMPERATURE_HEADERS + _TEMPERATURES_FILE + response + tables
        else:
            total += _BAND_HEADERS + _BAND_FILE if task.kind is Kind.BAND else _TEXTURE_FILE
    return total


def _channel_bytes(response: SpectralResponse) -> tuple[float, float]:
    """Bytes of the channels of a band under the first source, and under each other, at `FINEST`."""
    if WINDOW[0] <= response.lower and response.upper <= WINDOW[1]:
        return _SUNLIT_CHANNELS, _CHANNELS
    return (_SHORT_CHANNELS if response.lower < WINDOW[1] else _CHANNELS), _CHANNELS


def _memory(loaded: LoadedJob, plan: Plan) -> float:
    job = loaded.trimmed
    points = [
        absorption_table().count_between(*response_of(job.bands[number - 1]).wavenumber_range)
        for number in job.needed_bands
    ]
    of_air = sum(task.kind is Kind.ATMOSPHERE for task in plan.tasks)
    largest = max(task.values / len(task.files) for task in plan.tasks)
    air = _BAND + _POINT * max(points) + _FURTHER * min(of_air - 1, _MOST_FURTHER) if points else 0.0
    table = 0.0 if job.surface_grid.tolerance is not None else _OF_TABLE * FLOAT_BYTES * largest
    return _PROCESS + air + _MATERIAL * len(plan.materials) + table


def _in_turn(plan: Plan, seconds: dict[str, float]) -> float:
    counts = {kind: max(1, sum(task.kind is kind for task in plan.tasks)) for kind in Kind}
    of_air = sum(seconds[stage] for stage in ("compile", "atmosphere", "accuracy", "grid"))
    of_surfaces = seconds["temperature"] + seconds["shade"]
    textures = seconds["textures"] / counts[Kind.TEXTURE]
    return max(of_air / counts[Kind.ATMOSPHERE], textures + of_surfaces / counts[Kind.TEMPERATURE])
