"""Cache of compiled bands by content: the same band of the same state is compiled once on a machine.

Within a process the choice of points is cached too, for states of the same air: the ground and the source of another
day change the errors, which are measured for each state, but not the points. The choice does not depend on what a
process has built before.

The key is a hash over everything that a compilation depends on: state, points and response, axes, sources, tolerance,
the absorption table and the source code that compiles. A cached band equals a compiled one to the last bit; a file that
cannot be read is ignored. The folder may be deleted at any time. Set `SKYSHINE_CACHE` to move it; leave it empty to
disable caching.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import tempfile
import threading
import zipfile
from collections import OrderedDict
from collections.abc import Callable
from enum import Enum
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from typing import Protocol

import numpy as np

from skyshine.mat import atmosphere, radiometry
from skyshine.mat.atmosphere.band.compile import CompiledBand, FittedBand, fit_band, over_air
from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.path_axes import PathAxes
from skyshine.schemas.arrays import Floats

CACHE_VARIABLE = "SKYSHINE_CACHE"
FORMAT = 1  # raised when the layout of the cached files changes
_MAX_FITS = 8  # of some 10 MB each
_fits: OrderedDict[str, FittedBand] = OrderedDict()  # the latest last
_lock = threading.Lock()


class Digest(Protocol):
    """A hash to which bytes are added."""

    def update(self, data: bytes, /) -> None: ...


class Origin(Enum):
    """Where a compiled band came from."""

    FITTED = "points chosen for this air"
    SHARED = "points of another state of this air"
    CACHE = "compiled band from the cache"


def cache_folder() -> Path | None:
    """Folder of the cached bands; None if the environment disables caching."""
    named = os.environ.get(CACHE_VARIABLE)
    if named is not None:
        return Path(named) / "bands" if named else None
    import platformdirs

    return Path(platformdirs.user_cache_dir("skyshine")) / "bands"


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
) -> tuple[CompiledBand, Origin]:
    """A compiled band, its points fitted to the state's air under usual sources, its errors measured in the state.

    Parameters
    ----------
    table : AbsorptionTable
        The table of the band's points.
    state, band, grid, source_irradiance, tolerance, max_points, seed
        As `compile.compile_band`.
    usual_irradiance : (P,) or (B, P) array
        Typical irradiance of the same sources, equal for all states that are to share the points.

    Returns
    -------
    compiled : CompiledBand
    origin : Origin
    """
    folder = cache_folder()
    tolerance, max_points, seed = float(tolerance), int(max_points), int(seed)
    settings = {"tolerance": tolerance, "max_points": max_points, "seed": seed}
    usual, irradiance = np.asarray(usual_irradiance), np.asarray(source_irradiance)
    air = (table.content, over_air(state), band.weight, band.points.wavenumber, band.gases, grid, usual, settings)
    path = None if folder is None else folder / f"{content_key(*air, state.surface_temperature, irradiance)}.npz"
    compiled = None if path is None else _read(path, band)
    if compiled is not None:
        return compiled, Origin.CACHE
    key = content_key(*air)
    origin = Origin.SHARED if key in _fits else Origin.FITTED
    fit = _cached_fit(
        key,
        lambda: fit_band(over_air(state), band, grid, usual, tolerance=tolerance, max_points=max_points, seed=seed),
    )
    compiled = fit.measured(state.surface_temperature, irradiance)
    if path is not None:
        _write(path, compiled)
    return compiled, origin


def _cached_fit(key: str, fit: Callable[[], FittedBand]) -> FittedBand:
    """A fit of this process, or a new one."""
    fitted = _fits.pop(key, None) or fit()
    with _lock:
        _fits[key] = fitted
        while len(_fits) > _MAX_FITS:
            _fits.popitem(last=False)
    return fitted


def content_key(*parts: object) -> str:
    """SHA-256 over nested values, and over the code and the libraries that compile a band from them."""
    digest = hashlib.sha256()
    _feed(digest, (FORMAT, _code_digest(), metadata.version("numpy"), metadata.version("scipy"), *parts))
    return digest.hexdigest()


@lru_cache(maxsize=1)
def _code_digest() -> str:
    """Hash of the modules that a compilation runs: the whole trees of the atmosphere and of radiometry."""
    digest = hashlib.sha256()
    for package in (atmosphere, radiometry):
        folder = Path(str(package.__file__)).parent
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.relative_to(folder.parent).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def _feed(digest: Digest, value: object) -> None:
    """Add the type, the size and the content of a value to a hash."""
    if isinstance(value, np.ndarray | np.generic):
        array = np.ascontiguousarray(value)
        digest.update(f"array {array.dtype.str} {array.shape} ".encode() + array.tobytes())
    elif value is None or isinstance(value, bool | int | float | str):
        digest.update(f"{type(value).__name__} {value!r} ".encode())
    elif isinstance(value, dict):
        digest.update(f"dict {len(value)} ".encode())
        for key in sorted(value):
            _feed(digest, key)
            _feed(digest, value[key])
    elif isinstance(value, list | tuple):
        digest.update(f"sequence {len(value)} ".encode())
        for item in value:
            _feed(digest, item)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        digest.update(f"{type(value).__name__} ".encode())
        _feed(digest, {field.name: getattr(value, field.name) for field in dataclasses.fields(value)})
    else:
        raise TypeError(f"no content key for a {type(value).__name__}")


def _write(path: Path, compiled: CompiledBand) -> None:
    """Cache a band: write a part file and rename it when complete. A folder that cannot be written is ignored."""
    about = {
        "gases": compiled.band.gases,
        "total_points": compiled.total_points,
        "errors": compiled.errors,
        "dropped": compiled.dropped,
    }
    part = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as file:
            part = Path(file.name)
            np.savez(
                file,
                index=compiled.index,
                weight=compiled.band.weight,
                ladder=compiled.ladder,
                about=np.array(json.dumps(about)),
            )
        os.replace(part, path)
    except OSError:
        if part is not None:
            part.unlink(missing_ok=True)


def _read(path: Path, band: BandPoints) -> CompiledBand | None:
    """A cached band, or None if there is no complete one."""
    try:
        with np.load(path, allow_pickle=False) as arrays:
            index, weight, ladder = arrays["index"], arrays["weight"], arrays["ladder"]
            about = json.loads(str(arrays["about"]))
        few = BandPoints(band.points.subset(index), weight, tuple(about["gases"]))
        return CompiledBand(few, index, about["total_points"], about["errors"], about["dropped"], ladder)
    except (OSError, EOFError, KeyError, IndexError, ValueError, TypeError, zipfile.BadZipFile):
        return None
