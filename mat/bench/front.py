"""A job's own front: error of a pixel against run time, from the coarsest tolerance to the finest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

import skyshine
from skyshine.mat.bench.equal_error import EqualError
from skyshine.mat.bench.front_sentences import KELVIN, SHARE, sentences
from skyshine.mat.bench.lowtran import find_source
from skyshine.mat.bench.model import ModelledRung, TimeModel, kelvin_of_nodes, modelled, thinner
from skyshine.mat.bench.part_errors import part_errors, parts, with_coarser_points
from skyshine.mat.bench.peers import comparisons
from skyshine.mat.bench.pixel_errors import Variant, described, errors_of_band
from skyshine.mat.bench.rungs import STAGES, Rung
from skyshine.mat.bench.settings import AS_WRITTEN, BUILT_KELVIN, CHANGED, settings_of
from skyshine.mat.bench.shared_compile import compile_bands
from skyshine.mat.builder.executors import open_executor
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.own_materials import job_materials
from skyshine.mat.plan.plan import make_plan
from skyshine.mat.plan.size import check_size
from skyshine.mat.scene.check import check_scene
from skyshine.mat.threads import VARIABLE, core_count
from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.documents import MAPPING
from skyshine.schemas.errors import CheckFailed, InputError
from skyshine.schemas.kept_arrays import CACHE_VARIABLE
from skyshine.schemas.quantity import quantity


@dataclass(frozen=True)
class Options:
    """How a front is measured.

    Attributes
    ----------
    kelvins : tuple of float
        Tolerances of the pixel, a rung each.
    scenes, seed : int
        Views of each state, band and source, and what they are drawn with.
    states : int
        Built of a job of many, at most.
    lowtran_path : str or None
    full : bool
        Whether every rung is built; otherwise the job as written, `BUILT_KELVIN` and the finest.
    """

    kelvins: tuple[float, ...]
    scenes: int
    seed: int
    states: int
    lowtran_path: str | None
    full: bool


@dataclass
class Front:
    """What was measured of a job.

    Attributes
    ----------
    loaded : LoadedJob
        Job as written, with all its states.
    options : Options
    rungs : list of Rung
        Built and measured.
    modelled : list of ModelledRung
        Settings whose errors are those of thinned tables, and whose times are modelled.
    errors : dict of str to dict
        Errors of the pixel by name of the setting, as of `pixel_errors.described`.
    parts : list of dict
        Errors with one part coarser.
    failed : dict of str to str
        Settings that cannot run, with the reason in one line.
    peers : list of EqualError
    absent : dict of str to str
        Peers that are not here, with the reason.
    """

    loaded: LoadedJob
    options: Options
    rungs: list[Rung] = field(default_factory=list)
    modelled: list[ModelledRung] = field(default_factory=list)
    errors: dict[str, dict[str, Any]] = field(default_factory=dict)
    parts: list[dict[str, Any]] = field(default_factory=list)
    failed: dict[str, str] = field(default_factory=dict)
    peers: list[EqualError] = field(default_factory=list)
    absent: dict[str, str] = field(default_factory=dict)

    @property
    def units(self) -> str:
        """Units of the error: kelvin, or where no band has thermal light, per cent of the mean radiance."""
        return KELVIN if all(errors["all"]["temperature"] for errors in self.errors.values()) else SHARE


def check(loaded: LoadedJob, options: Options) -> None:
    """Refuse a job that cannot be built, and a peer that is not where it is said to be, before anything is written.

    Raises
    ------
    InputError
    """
    find_source(options.lowtran_path)
    check_size(loaded, make_plan(loaded, job_materials(loaded.trimmed.own_materials)))
    check_scene(loaded)


def measured(loaded: LoadedJob, folder: Path, options: Options, say: Callable[[str], object] = lambda _: None) -> Front:
    """Build a job at one setting after the other; then measure all of them, each part and the peers.

    Parameters
    ----------
    loaded : LoadedJob
    folder : Path
        Folder whose subfolder ``rungs`` stores the databases; rungs of the same job that it already contains are not
        built again.
    options : Options
    say : callable
        Called with a line of text that says what is done next.
    """
    library, front = job_materials(loaded.trimmed.own_materials), Front(loaded, options)
    rungs: list[Rung] = []
    for setting in settings_of(loaded.document.data, options.kelvins):
        try:
            rungs.append(Rung.of(setting, loaded, folder / "rungs", options.states))
        except InputError as error:
            front.failed[setting.name] = _one_line(error)
    jobs = [rung.loaded.trimmed for rung in rungs]
    rungs = [rung for number, rung in enumerate(rungs) if rung.loaded.trimmed not in jobs[:number]]
    states, of_the_job = len(jobs[0].states), len(loaded.trimmed.states)
    say(f"{loaded.trimmed.name}: {len(rungs)} settings of {states} of its {of_the_job} states, into {folder}")
    real = rungs if options.full else _built(rungs)
    _compile(real, library, folder / "rungs", say)
    for number, rung in enumerate(real):
        refused = [other.setting.name for other in real[:number] if other.refusal and other.setting.kelvin is not None]
        if refused and rung.setting.kelvin is not None:  # tolerances are tried from the coarsest on
            front.failed[rung.setting.name] = f"not tried: finer than {refused[0]}, which cannot run"
        else:
            _build(rung, library, front, say)
    if front.rungs:
        _measure(front, rungs[0].loaded, [rung for rung in rungs if rung not in real], say)
    return front


def _built(rungs: list[Rung]) -> list[Rung]:
    """Of the settings, those that are built: the job as written, one that is usual, and the finest."""
    kelvins = [rung.setting.kelvin for rung in rungs if rung.setting.kelvin is not None]
    chosen = {None, BUILT_KELVIN, min(kelvins, default=None)}
    return [rung for rung in rungs if rung.setting.kelvin in chosen]


def _measure(front: Front, loaded: LoadedJob, others: list[Rung], say: Callable[[str], object]) -> None:
    """Errors of all settings and parts, times of those that are not built, and peers.

    Each band of a state is measured in a process of its own, the peers in another.
    """
    finest, first = min(front.rungs, key=kelvin_of_nodes), front.rungs[0]
    coarser = [rung for rung in others if kelvin_of_nodes(rung) >= kelvin_of_nodes(finest)]
    for rung in others:
        if rung not in coarser:
            front.failed[rung.setting.name] = f"not tried: finer than {finest.setting.name}, the finest that ran"
    variants = [Variant(rung.setting.name, rung) for rung in front.rungs] + [thinner(rung, finest) for rung in coarser]
    as_written = first.setting.name == AS_WRITTEN
    if as_written:
        variants += parts(first).values()
    say(f"measuring the pixel of {len(front.rungs)} settings, of {len(coarser)} by thinned tables, of parts; peers")
    options, job = front.options, loaded.trimmed
    numbers = list(product(range(1, len(job.states) + 1), job.needed_bands))
    of_band = partial(errors_of_band, loaded, variants, options.scenes, options.seed)
    variables = {CACHE_VARIABLE: str(first.cache), VARIABLE: "1"}
    with open_executor(None, min(len(numbers) + as_written, core_count()), first.folder, variables) as pool:
        tasks = [pool.submit(of_band, number) for number in numbers]
        peers = pool.submit(comparisons, first, options.lowtran_path) if as_written else None
        sets = [of_set for task in tasks for of_set in task.result()]
        front.peers, front.absent = peers.result() if peers else ([], {})
    if not sets:
        raise CheckFailed("the axes of the job leave no room for a view; widen its ranges, altitudes or elevations")
    model = TimeModel.of(front.rungs, sets)
    front.modelled = [modelled(rung.setting, sets, model) for rung in coarser]
    front.errors = {rung.setting.name: described(sets, rung.setting.name) for rung in [*front.rungs, *coarser]}
    if as_written:
        front.parts = part_errors(first, sets, model)


def _compile(rungs: Sequence[Rung], library: MaterialLibrary, folder: Path, say: Callable[[str], object]) -> None:
    """Resume what an earlier run has built, and compile the bands of all others."""
    try:
        for rung in rungs:
            rung.folder.mkdir(parents=True, exist_ok=True)
            rung.resume(library)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}; name another --out", file=folder) from None
    new = [rung for rung in rungs if rung.cost is None and not rung.refusal]
    if not new:
        return
    say(f"compiling the bands of {len(new)} settings")
    settings = [(rung.loaded, rung.cache) for rung in new]
    settings += [(with_coarser_points(rung.loaded), rung.cache) for rung in new if rung.setting.name == AS_WRITTEN]
    with suppress(InputError, CheckFailed):  # which the build of the setting meets again, and says
        for rung, seconds in zip(new, compile_bands(settings, folder), strict=False):
            rung.compiled = seconds


def _build(rung: Rung, library: MaterialLibrary, front: Front, say: Callable[[str], object]) -> None:
    """Build a rung, unless an earlier run has, and add it to the front or to what cannot run.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    name = rung.setting.name
    try:
        if rung.cost is None:
            say(f"{name}: building")
            rung.build(library, front.rungs[0] if front.rungs else None)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}; name another --out", file=rung.folder) from None
    except (InputError, CheckFailed) as error:
        front.failed[name] = _one_line(error)
        say(f"{name} cannot run: {_one_line(error)}")
        return
    assert rung.cost is not None
    say(f"{name}: {rung.cost.processor:.0f} s")
    front.rungs.append(rung)


def _one_line(error: InputError | CheckFailed) -> str:
    """Reason why a setting cannot run; no file contains its job, so that none can be named."""
    if isinstance(error, InputError) and error.file is not None and Path(error.file).name == MAPPING:
        return error.message
    return " ".join(str(error).split())


def describe(front: Front) -> dict[str, Any]:
    """A front as plain values: what ``mat bench JOB --json`` prints and the page shows."""
    units = front.units
    every: list[Rung | ModelledRung] = [*front.rungs, *front.modelled]
    rungs = [_described(rung, front.errors[rung.setting.name], units) for rung in every]
    on_the_front = unbeaten([(rung["time"]["value"], rung["error"]["value"]) for rung in rungs])
    for rung, on_front in zip(rungs, on_the_front, strict=True):
        rung["on_the_front"] = on_front
    rungs.sort(key=lambda rung: rung["time"]["value"])
    built = len(front.rungs[0].loaded.trimmed.states) if front.rungs else 0
    return {
        "job": front.loaded.trimmed.name,
        "version": skyshine.__version__,
        "method": _method(front),
        "states": {"built": built, "of_the_job": len(front.loaded.trimmed.states)},
        "scenes": front.options.scenes,
        "seed": front.options.seed,
        "rungs": rungs,
        "cannot_run": dict(front.failed),
        "parts": front.parts,
        "sentences": sentences(rungs, units),
        "peers": [peer.described for peer in front.peers],
        "absent": dict(front.absent),
    }


def _in_units(errors: dict[str, Any], units: str) -> dict[str, Any]:
    """Rms, 99th percentile and maximum in the units of a front; none where a band has no error in them."""
    if units == KELVIN:
        return dict(errors["temperature"] or {})
    return {name: quantity(100 * entry["value"], units) for name, entry in errors["share_of_radiance"].items()}


def _method(front: Front) -> str:
    """How the numbers of a front are to be read."""
    options, count = front.options, len(front.loaded.trimmed.states)
    built = min(options.states, count)
    text = (
        "Error: a pixel by the runtime's equations from the tables, against the whole truth: spectral integrals and"
        " temperatures solved for each face under its shadows and beside its walls, on the same"
        f" {options.scenes} random views of each state, band and source for every setting (seed {options.seed}), all"
        " bands, sources and materials together; the JSON has each set. Time: processor seconds of the whole build, by"
        f" one process a core ({core_count()} here), nothing cached, without pictures; textures are classified once"
        " and counted in each setting, and all settings choose their spectral points from one sample, which counts in"
        " each. Start and rest: processes that begin, the job that is read."
    )
    if front.modelled:
        text += (
            " Modelled settings (open marks) are not built: their error is that of the finest tables, thinned by the"
            " square root of the tolerance, with the finest spectral points; seconds of tables and temperatures go by"
            " the number of values as in the built settings, all others are their mean. --full builds every setting."
        )
    if built < count:
        text += f" {built} of the job's {count} states are built."
    if (
        front.units == KELVIN
        and front.rungs
        and any(band["temperature"] is None for band in front.errors[front.rungs[0].setting.name]["bands"])
    ):
        text += " Bands that end before 2.5 um have no error in kelvin; the JSON gives theirs in shares of radiance."
    return text


def _described(rung: Rung | ModelledRung, measured: dict[str, Any], units: str) -> dict[str, Any]:
    """A rung with its errors as plain values."""
    errors, floor = (_in_units(item, units) for item in (measured["all"], measured["all"]["exact_tables"]))
    if isinstance(rung, ModelledRung):
        seconds, wall, stages, uncertainty = rung.seconds, np.nan, rung.stages, rung.uncertainty
    else:
        assert rung.cost is not None
        seconds, wall, stages, uncertainty = rung.cost.processor, rung.cost.wall, rung.cost.stages, 0.0
    return {
        "name": rung.setting.name,
        "asked": quantity(np.nan if rung.setting.kelvin is None else rung.setting.kelvin, "K"),
        "chosen": rung.setting.name == AS_WRITTEN,
        "modelled": isinstance(rung, ModelledRung),
        "keys": {key: rung.setting.content[key] for key in CHANGED if key in rung.setting.content},
        "error": errors["p99"],
        "rms": errors["rms"],
        "maximum": errors["maximum"],
        "floor": floor["p99"],
        "by_band": [
            {
                "wavelength": band["wavelengths"][0],
                "error": values["p99"],
                "floor": _in_units(band["exact_tables"], units)["p99"],
            }
            for band in measured["bands"]
            if (values := _in_units(band, units))
        ],
        "time": quantity(seconds, "s"),
        "uncertainty": quantity(uncertainty, "s"),
        "wall_time": quantity(wall, "s"),
        "stages": {name: quantity(stages[name], "s") for name in STAGES},
        "size": quantity(rung.size, "byte"),
        "sets": measured["sets"],
    }


def unbeaten(points: Sequence[tuple[float, float]]) -> list[bool]:
    """Whether each point (seconds, error) is on the Pareto front; of equal points both are."""
    return [not any(_beats(rival, point) for rival in points) for point in points]


def _beats(rival: tuple[float, float], point: tuple[float, float]) -> bool:
    return rival[0] <= point[0] and rival[1] <= point[1] and rival != point
