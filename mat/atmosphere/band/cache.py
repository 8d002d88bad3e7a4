"""Cache of compiled bands by content: the same band of the same state is compiled once on a machine.

Within a process fits are cached too, for states of the same air: the ground and the source of another day change the
errors, which are measured for each state, but not the points. States of similar air share points that are chosen for
all of them, and the errors of these in airs between, where they meet the tolerance. What a state gets does not depend
on what a process has built before, nor on what is cached.

The key is a hash over all that a compilation depends on: state, points and response, axes, sources, tolerance, the
absorption table and the source code that compiles. What is kept is what compiling gave, to the last bit. A file is
believed as `schemas.kept_arrays` says, and if its content fits the band; any other counts as absent and is replaced.
The folder may be deleted at any time.
"""

from __future__ import annotations

import hashlib
import json
import math
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields
from enum import Enum
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any, TypedDict

import numpy as np
import numpy.typing as npt

from skyshine.mat import atmosphere, radiometry
from skyshine.mat.atmosphere.band.compile import (
    AirTest,
    ChosenPoints,
    CompiledBand,
    FittedBand,
    SampledBand,
    SharedPoints,
    SimilarAirs,
    choose_points,
    fit_band,
    over_air,
    with_errors_of_own_air,
)
from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.band.targets import KINDS
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.path_axes import ALL_PATHS, PathAxes, PathScope
from skyshine.mat.kernel.library import library
from skyshine.schemas.arrays import Floats
from skyshine.schemas.digest import digest_of
from skyshine.schemas.kept_arrays import keep_arrays, kept_arrays, kept_folder

FOLDER = "bands"  # folder of the kept files
FORMAT = 4  # raised when the layout of the kept files changes
HEAD = b"skyshine compiled band 4\n"  # then the digest in hexadecimal digits, and the arrays as numpy keeps several
STATISTICS = ("max", "p95", "rms")
_TEST = "test"  # begins the names of the arrays of a test
# Tolerances that shared points may err where the largest number of points, not the tolerance, ended their choice: those
# fitted to the air of the state alone then miss the tolerance by as much.
_LIMITED = 1.5
_MAX_FITS = 8  # largest number of fits of some 10 MB each
_fits: OrderedDict[str, FittedBand] = OrderedDict()  # the latest last
_choices: dict[str, SharedPoints] = {}  # choices of some 300 kB each
_samples: dict[str, tuple[SampledBand, float]] | None = None  # results of `shared_samples`
_lock = threading.Lock()


class _Settings(TypedDict):
    tolerance: float
    max_points: int
    seed: int
    scope: PathScope


class Origin(Enum):
    """Where a compiled band came from."""

    FITTED = "points chosen for this air"
    SHARED = "points of another state of this air"
    SIMILAR = "points chosen for similar airs"
    SHARED_SIMILAR = "points chosen before for similar airs"
    CACHE = "compiled band from the cache"


def cached_compile_band(
    table: AbsorptionTable,
    state: AtmosphericState,
    band: BandPoints,
    grid: PathAxes,
    source_irradiance: Floats,
    usual_irradiance: Floats,
    *,
    tolerance: float,
    max_points: int,
    seed: int,
    scope: PathScope = ALL_PATHS,
    similar: SimilarAirs | None = None,
) -> tuple[CompiledBand, Origin]:
    """A compiled band, its points chosen under usual sources, its errors measured in the state or in airs like it.

    The points are those chosen for similar airs, if there are any and each quantity meets the tolerance (rms) in airs
    between them, and transmittance in the state's own, or 1.5 times it where `max_points` ended the choice; else points
    fitted to the state's air.

    Parameters
    ----------
    table : AbsorptionTable
        The table of the band's points.
    state, band, grid, source_irradiance, tolerance, max_points, seed, scope
        As `compile.compile_band`.
    usual_irradiance : (P,) or (B, P) array
        Typical irradiance of the same sources, equal for all states that are to share the points.
    similar : SimilarAirs, optional
        Airs for which points are chosen that the state may share.

    Returns
    -------
    compiled : CompiledBand
    origin : Origin
    """
    folder = kept_folder(FOLDER)
    tolerance, max_points, seed = float(tolerance), int(max_points), int(seed)
    settings = _Settings(tolerance=tolerance, max_points=max_points, seed=seed, scope=scope)
    usual, irradiance = np.asarray(usual_irradiance), np.asarray(source_irradiance)
    common = _common(table, band, grid, usual, settings)
    key = content_key(*common, over_air(state), similar, state.surface_temperature, irradiance)
    path = None if folder is None else folder / f"{key}.npz"
    compiled = None if path is None else _read(path, key, band)
    if compiled is not None:
        return compiled, Origin.CACHE

    if similar is not None:
        shared, cached = _cached_choice(table, similar, band, grid, usual, settings)
        limited = shared.chosen.is_limited(tolerance) or shared.chosen.index.size >= max_points
        allowed = tolerance * (_LIMITED if limited else 1.0)
        if shared.worst <= allowed:
            compiled = shared.measured(irradiance)
            compiled = with_errors_of_own_air(compiled, state, band, grid, seed, scope)
            origin = Origin.SHARED_SIMILAR if cached else Origin.SIMILAR
            if compiled.errors["transmittance"]["rms"] > allowed:
                compiled = None
    if compiled is None:
        fit, cached = _cached_fit(
            content_key(*common, over_air(state)), lambda: _fitted(table, over_air(state), band, grid, usual, settings)
        )
        compiled = fit.measured(state.surface_temperature, irradiance)
        origin = Origin.SHARED if cached else Origin.FITTED
    if path is not None:
        _write(path, key, compiled)
    return compiled, origin


@contextmanager
def shared_samples() -> Iterator[dict[str, tuple[SampledBand, float]]]:
    """Context in which bands that differ in the tolerance of their points alone are sampled once; some 100 MB a band.

    Yields
    ------
    dict
        Samples by content, with the processor seconds that each took.
    """
    global _samples
    _samples = {}
    try:
        yield _samples
    finally:
        _samples = None


def _fitted(
    table: AbsorptionTable,
    air: AtmosphericState,
    band: BandPoints,
    grid: PathAxes,
    usual: Floats,
    settings: _Settings,
) -> FittedBand:
    """Points for an air, by a sample of its own or by that of `shared_samples`."""
    if _samples is None:
        return fit_band(air, band, grid, usual, **settings)
    key = content_key(*_common(table, band, grid, usual, settings)[:-1], settings["seed"], settings["scope"], air)
    if key not in _samples:
        begin = time.process_time()
        sampled = SampledBand.of(air, band, grid, usual, settings["seed"], settings["scope"])
        _samples[key] = sampled, time.process_time() - begin
    return _samples[key][0].fitted(settings["tolerance"], settings["max_points"])


def points_for_airs(
    table: AbsorptionTable,
    similar: SimilarAirs,
    band: BandPoints,
    grid: PathAxes,
    usual_irradiance: Floats,
    *,
    tolerance: float,
    max_points: int,
    seed: int,
    scope: PathScope = ALL_PATHS,
) -> ChosenPoints:
    """The points that are chosen for similar airs; parameters as `cached_compile_band`."""
    settings = _Settings(tolerance=float(tolerance), max_points=int(max_points), seed=int(seed), scope=scope)
    return _cached_choice(table, similar, band, grid, np.asarray(usual_irradiance), settings)[0].chosen


def _common(
    table: AbsorptionTable, band: BandPoints, grid: PathAxes, usual: Floats, settings: _Settings
) -> tuple[Any, ...]:
    """What the points of a band depend on beside the air."""
    return table.content, band.weight, band.points.wavenumber, band.gases, grid, usual, settings


def _cached_choice(
    table: AbsorptionTable,
    similar: SimilarAirs,
    band: BandPoints,
    grid: PathAxes,
    usual: Floats,
    settings: _Settings,
) -> tuple[SharedPoints, bool]:
    """A choice for similar airs of this process, of the folder, or a new one; whether it was known."""
    key = content_key(*_common(table, band, grid, usual, settings), similar)
    if key in _choices:
        return _choices[key], True
    folder = kept_folder(FOLDER)
    path = None if folder is None else folder / f"{key}.npz"
    shared = None if path is None else _read_shared(path, key, band)
    known = shared is not None
    if shared is None:
        shared = choose_points(similar.corners, similar.inside, band, grid, usual, **settings)
        if path is not None:
            _write(path, key, shared.chosen.with_errors({}, {}), _tests_kept(shared))
    _choices[key] = shared
    return shared, known


def _tests_kept(shared: SharedPoints) -> dict[str, npt.NDArray[Any]]:
    """The tests of shared points as arrays by name."""
    return {"usual_brightness": shared.usual_brightness} | {
        f"{_TEST}.{number}.{part.name}.{kind}": values
        for number, test in enumerate(shared.tests)
        for part in fields(AirTest)
        for kind, values in getattr(test, part.name).items()
    }


def _read_shared(path: Path, key: str, band: BandPoints) -> SharedPoints | None:
    """Kept points of similar airs with their tests, or None where there are none that can be believed."""
    stored, arrays = _read(path, key, band), kept_arrays(path, HEAD, key)
    if stored is None or arrays is None:
        return None
    parts: dict[int, dict[str, dict[str, npt.NDArray[Any]]]] = {}
    for name, values in arrays.items():
        if name.startswith(f"{_TEST}."):
            _, number, part, kind = name.split(".")
            parts.setdefault(int(number), {field.name: {} for field in fields(AirTest)})[part][kind] = values
    chosen = ChosenPoints(stored.band, stored.index, stored.total_points, stored.ladder)
    tests = tuple(AirTest(**parts[number]) for number in sorted(parts))
    return SharedPoints(chosen, tests, arrays["usual_brightness"]) if tests else None


def _cached_fit(key: str, fit: Callable[[], FittedBand]) -> tuple[FittedBand, bool]:
    """A fit of this process, or a new one; whether it was known."""
    cached = _fits.pop(key, None)
    fitted = cached or fit()
    with _lock:
        _fits[key] = fitted
        while len(_fits) > _MAX_FITS:
            _fits.popitem(last=False)
    return fitted, cached is not None


def content_key(*parts: Any) -> str:
    """SHA-256 over values of any depth, with the code, C too, and the libraries that turn them into a compiled band."""
    code = code_digest(atmosphere, radiometry), library().skyshine_sources().decode()
    return digest_of(FORMAT, *code, *map(metadata.version, ("numpy", "scipy")), *parts)


@lru_cache
def code_digest(*packages: ModuleType) -> str:
    """Hash of the modules of packages: a compilation runs those of the atmosphere and of radiometry."""
    digest = hashlib.sha256()
    for package in packages:
        folder = Path(str(package.__file__)).parent
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.relative_to(folder.parent).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def _write(
    path: Path, key: str, compiled: CompiledBand, more: Mapping[str, npt.NDArray[Any]] = MappingProxyType({})
) -> None:
    """Keep a band, with more arrays."""
    about = {
        "gases": compiled.band.gases,
        "total_points": compiled.total_points,
        "errors": compiled.errors,
        "absolute": compiled.absolute,
    }
    arrays = {
        "index": compiled.index,
        "weight": compiled.band.weight,
        "ladder": compiled.ladder,
        "about": np.array(json.dumps(about)),
    }
    keep_arrays(path, HEAD, key, arrays | dict(more))


def _read(path: Path, key: str, band: BandPoints) -> CompiledBand | None:
    """A kept band, or None where there is none that can be believed."""
    arrays = kept_arrays(path, HEAD, key)
    if arrays is None:
        return None
    try:
        index, weight, ladder = arrays["index"], arrays["weight"], arrays["ladder"]
        about = json.loads(str(arrays["about"]))
        if not _fits_band(index, weight, ladder, about, band):
            return None
        reduced = BandPoints(band.points.subset(index), weight, tuple(about["gases"]))
        return CompiledBand(reduced, index, about["total_points"], about["errors"], ladder, about["absolute"])
    except Exception:  # whatever a damaged file leads to, the band is compiled again
        return None


def _fits_band(
    index: npt.NDArray[Any],
    weight: npt.NDArray[Any],
    ladder: npt.NDArray[Any],
    about: dict[str, Any],
    band: BandPoints,
) -> bool:
    """Whether a kept choice of points is one of this band: some of its points with its whole weight, and of its gases
    those that were not omitted.
    """
    size = band.weight.size
    kinds = index.dtype.kind == "i" and weight.dtype == np.float64 and ladder.dtype == np.float64
    if not kinds or not index.shape == weight.shape == (index.size,) or ladder.ndim != 1 or not index.size:
        return False
    numbers = [error[name] for error in about["errors"].values() for name in STATISTICS]
    numbers += [
        error[name]
        for sources in about["absolute"].values()
        for regions in sources
        for error in regions.values()
        for name in (*STATISTICS, "p99")
    ]
    return bool(
        np.all((index >= 0) & (index < size))
        and np.unique(index).size == index.size
        and np.all(np.isfinite(weight) & (weight > 0))
        and math.isclose(weight.sum(), band.weight.sum(), rel_tol=1e-9)
        and np.all(np.isfinite(ladder) & (ladder >= 0))
        and about["total_points"] == size
        and set(about["absolute"]) == set(about["errors"]) <= set(KINDS)
        and all(isinstance(number, float) and 0 <= number < math.inf for number in numbers)
        and tuple(about["gases"]) == band.gases
    )
