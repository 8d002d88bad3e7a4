"""A job's own front: error of a pixel against run time, from the coarsest tolerance to the finest."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import skyshine
from skyshine.mat.bench.front_sentences import KELVIN, SHARE, sentences
from skyshine.mat.bench.lowtran import find_source
from skyshine.mat.bench.model import ModelledRung, TimeModel, modelled
from skyshine.mat.bench.part_errors import part_errors, with_coarser_points
from skyshine.mat.bench.peers import EqualError, comparisons
from skyshine.mat.bench.pixel_errors import Truths, compute_truths, errors_of, measure
from skyshine.mat.bench.rungs import STAGES, Rung
from skyshine.mat.bench.sample import cache_in
from skyshine.mat.bench.settings import AS_WRITTEN, BUILT_KELVIN, CHANGED, settings_of
from skyshine.mat.bench.shared_compile import compile_bands
from skyshine.mat.job.fields import tolerance_parts
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.own_materials import job_materials
from skyshine.mat.plan.plan import make_plan
from skyshine.mat.plan.size import check_size
from skyshine.mat.scene.check import check_scene
from skyshine.mat.threads import core_count
from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.documents import MAPPING
from skyshine.schemas.errors import CheckFailed, InputError
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
    """What is measured so far.

    Attributes
    ----------
    loaded : LoadedJob
        Job as written, with all its states.
    rungs : list of Rung
        Built and measured.
    modelled : list of ModelledRung
        Settings whose errors are those of thinned tables, and whose times are modelled.
    parts : list of dict
        Errors with one part coarser.
    failed : dict of str to str
        Settings that cannot run, with the reason in one line.
    absent : dict of str to str
        Peers that are not here, with the reason.
    """

    loaded: LoadedJob
    options: Options
    rungs: list[Rung] = field(default_factory=list)
    modelled: list[ModelledRung] = field(default_factory=list)
    parts: list[dict[str, Any]] = field(default_factory=list)
    failed: dict[str, str] = field(default_factory=dict)
    peers: list[EqualError] = field(default_factory=list)
    absent: dict[str, str] = field(default_factory=dict)

    @property
    def units(self) -> str:
        """Units of the error: kelvin, or where no band has thermal light, per cent of the mean radiance."""
        return KELVIN if all(rung.errors["all"]["temperature"] for rung in self.rungs) else SHARE


def check(loaded: LoadedJob, options: Options) -> None:
    """Refuse a job that cannot be built, and a peer that is not where it is said to be, before anything is written.

    Raises
    ------
    InputError
    """
    find_source(options.lowtran_path)
    check_size(loaded, make_plan(loaded, job_materials(loaded.trimmed.own_materials)))
    check_scene(loaded)


def measured(
    loaded: LoadedJob, folder: Path, options: Options, say: Callable[[str], object] = lambda _: None
) -> Iterator[Front]:
    """Build and measure a job at one setting after the other; peers last.

    Parameters
    ----------
    folder : Path
        Folder whose subfolder ``rungs`` stores the databases; rungs of the same job that it already contains are not
        built again.
    say : callable
        Called with a line of text that says what is done next.

    Yields
    ------
    Front
        The same one, after each rung and after the peers.
    """
    library, front = job_materials(loaded.trimmed.own_materials), Front(loaded, options)
    rungs: list[Rung] = []
    for setting in settings_of(loaded.document.data, options.kelvins):
        try:
            rungs.append(Rung.of(setting, loaded, folder / "rungs", options.states))
        except InputError as error:
            front.failed[setting.name] = _one_line(error)
    as_written, jobs = rungs[0].loaded, [rung.loaded.trimmed for rung in rungs]
    rungs = [rung for number, rung in enumerate(rungs) if rung.loaded.trimmed not in jobs[:number]]
    truths = Truths(as_written, jobs, library, options.scenes, options.seed, folder / "truth", say)
    states, of_the_job = len(as_written.trimmed.states), len(loaded.trimmed.states)
    say(f"{loaded.trimmed.name}: {len(rungs)} settings of {states} of its {of_the_job} states, into {folder}")
    refused: str | None = None
    real = rungs if options.full else _built(rungs)
    _compile(real, library, folder / "rungs", say)
    for number, rung in enumerate(real, 1):
        name = f"{rung.setting.name} ({number} of {len(real)})"
        if refused and rung.setting.kelvin is not None:  # tolerances are tried from the coarsest on
            front.failed[rung.setting.name] = f"not tried: finer than {refused}, which cannot run"
            continue
        try:
            _build(rung, library, front.rungs[0] if front.rungs else None, name, say)
            if not front.rungs:
                say("computing the truth of the scenes")
                compute_truths(truths, rung)
            with cache_in(front.rungs[0].cache if front.rungs else rung.cache):
                measure(rung, truths)
            front.rungs.append(rung)
        except (InputError, CheckFailed) as error:
            refused = rung.setting.name if rung.refusal and rung.setting.kelvin is not None else None
            front.failed[rung.setting.name] = _one_line(error)
            say(f"{name} cannot run: {_one_line(error)}")
        yield front
    if front.rungs:
        _model(front, truths, [rung for rung in rungs if rung not in real], say)
        yield front
    if front.rungs and front.rungs[0].setting.name == AS_WRITTEN:
        front.peers, front.absent = comparisons(front.rungs[0], library, lowtran_path=options.lowtran_path, say=say)
        yield front


def _built(rungs: list[Rung]) -> list[Rung]:
    """Of the settings, those that are built: the job as written, one that is usual, and the finest."""
    kelvins = [rung.setting.kelvin for rung in rungs if rung.setting.kelvin is not None]
    chosen = {None, BUILT_KELVIN, min(kelvins, default=None)}
    return [rung for rung in rungs if rung.setting.kelvin in chosen]


def _kelvin(rung: Rung) -> float:
    """Tolerance of the nodes of a rung's atmosphere."""
    return tolerance_parts(rung.loaded.trimmed.atmosphere_grid.tolerance)[0]


def _model(front: Front, truths: Truths, rungs: list[Rung], say: Callable[[str], object]) -> None:
    """Errors and times of settings that are not built, and of single parts."""
    model, finest = TimeModel(front.rungs), min(front.rungs, key=_kelvin)
    say(f"measuring the pixel of {len(rungs)} settings on the tables of {finest.setting.name}, thinned")
    with cache_in(front.rungs[0].cache):
        for rung in rungs:
            if _kelvin(rung) < _kelvin(finest):
                front.failed[rung.setting.name] = f"not tried: finer than {finest.setting.name}, the finest that ran"
                continue
            thinner, tables = modelled(rung.setting, _kelvin(rung), finest, _kelvin(finest), model)
            thinner.errors = errors_of(truths, tables)
            front.modelled.append(thinner)
        if front.rungs[0].setting.name == AS_WRITTEN:
            say("measuring the pixel with each part coarser")
            front.parts = part_errors(front.rungs[0], truths, model)


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


def _build(
    rung: Rung, library: MaterialLibrary, textures_of: Rung | None, name: str, say: Callable[[str], object]
) -> None:
    """Build a rung, unless an earlier run has."""
    try:
        if rung.cost is None:
            say(f"{name}: building")
            rung.build(library, textures_of)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}; name another --out", file=rung.folder) from None
    assert rung.cost is not None
    say(f"{name}: {rung.cost.processor:.0f} s; measuring the pixel")


def _one_line(error: InputError | CheckFailed) -> str:
    """Reason why a setting cannot run; no file contains its job, so that none can be named."""
    if isinstance(error, InputError) and error.file is not None and Path(error.file).name == MAPPING:
        return error.message
    return " ".join(str(error).split())


def describe(front: Front) -> dict[str, Any]:
    """A front as plain values: what ``mat bench JOB --json`` prints and the page shows."""
    units = front.units
    rungs = [_described(rung, units) for rung in front.rungs] + [_described(rung, units) for rung in front.modelled]
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
        and any(band["temperature"] is None for band in front.rungs[0].errors["bands"])
    ):
        text += " Bands that end before 2.5 um have no error in kelvin; the JSON gives theirs in shares of radiance."
    return text


def _described(rung: Rung | ModelledRung, units: str) -> dict[str, Any]:
    """A rung as plain values."""
    errors, floor = (_in_units(item, units) for item in (rung.errors["all"], rung.errors["all"]["exact_tables"]))
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
            for band in rung.errors["bands"]
            if (values := _in_units(band, units))
        ],
        "time": quantity(seconds, "s"),
        "uncertainty": quantity(uncertainty, "s"),
        "wall_time": quantity(wall, "s"),
        "stages": {name: quantity(stages[name], "s") for name in STAGES},
        "size": quantity(rung.size, "byte"),
        "sets": rung.errors["sets"],
    }


def unbeaten(points: Sequence[tuple[float, float]]) -> list[bool]:
    """Whether each point (seconds, error) is on the Pareto front; of equal points both are."""
    return [not any(_beats(rival, point) for rival in points) for point in points]


def _beats(rival: tuple[float, float], point: tuple[float, float]) -> bool:
    return rival[0] <= point[0] and rival[1] <= point[1] and rival != point
