"""Compiled bands kept by content, so that the same band of the same state is compiled once on a machine.

Within a process the choice of points is kept too, for states of the same air: another day's ground and source change
its errors, which are measured for each state, and not the points. It is the same choice in every process, whatever that
has built before.

The key is a hash over all that a compilation depends on: state, points and response, axes, sources, tolerance, the
absorption table and the source code that compiles. What is kept is what compiling gave, to the last bit; a file that
cannot be read is as good as absent. The folder may be deleted at any time. `SKYSHINE_CACHE` names another folder, or
none at all if it is empty.
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

import numpy as np

from skyshine.mat import atmosphere, radiometry
from skyshine.mat.atmosphere.band.compile import CompiledBand, FittedBand, fit_band, over_air
from skyshine.mat.atmosphere.band.points import BandPoints

CACHE_VARIABLE = "SKYSHINE_CACHE"
FORMAT = 1  # raised when the layout of the kept files changes
_MOST_FITS = 8  # of some 10 MB each
_fits: OrderedDict[str, FittedBand] = OrderedDict()  # the latest last
_lock = threading.Lock()


class Origin(Enum):
    """Where a compiled band came from."""

    FITTED = "points chosen for this air"
    SHARED = "points of another state of this air"
    CACHE = "compiled band from the cache"


def cache_folder() -> Path | None:
    """Folder of the kept bands; None where the environment switches them off."""
    named = os.environ.get(CACHE_VARIABLE)
    if named is not None:
        return Path(named) / "bands" if named else None
    import platformdirs

    return Path(platformdirs.user_cache_dir("skyshine")) / "bands"


def cached_compile_band(table, state, band, grid, source_irradiance, usual_irradiance, *, tolerance, max_points, seed):
    """A compiled band, its points fitted to the state's air under usual sources, its errors measured in the state.

    Parameters
    ----------
    table : AbsorptionTable
        That the band's points are from.
    state, band, grid, source_irradiance, tolerance, max_points, seed
        As `compile.compile_band`.
    usual_irradiance : (P,) or (B, P) array
        Of the same sources, for all states that are to share the points.

    Returns
    -------
    compiled : CompiledBand
    origin : Origin
    """
    folder = cache_folder()
    settings = {"tolerance": float(tolerance), "max_points": int(max_points), "seed": int(seed)}
    usual = np.asarray(usual_irradiance)
    air = (table.content, over_air(state), band.weight, band.points.wavenumber, band.gases, grid, usual, settings)
    own = (state.surface_temperature, np.asarray(source_irradiance))
    path = None if folder is None else folder / f"{content_key(*air, *own)}.npz"
    compiled = None if path is None else _read(path, band)
    if compiled is not None:
        return compiled, Origin.CACHE
    key = content_key(*air)
    origin = Origin.SHARED if key in _fits else Origin.FITTED
    fit = _kept_fit(key, lambda: fit_band(over_air(state), band, grid, usual, **settings))
    compiled = fit.measured(*own)
    if path is not None:
        _write(path, compiled)
    return compiled, origin


def _kept_fit(key: str, fit: Callable[[], FittedBand]) -> FittedBand:
    """A fit of this process, or a new one."""
    found = _fits.pop(key, None) or fit()
    with _lock:
        _fits[key] = found
        while len(_fits) > _MOST_FITS:
            _fits.popitem(last=False)
    return found


def content_key(*parts) -> str:
    """SHA-256 over values of any depth, with the code and the libraries that turn them into a compiled band."""
    digest = hashlib.sha256()
    _feed(digest, (FORMAT, _code_digest(), metadata.version("numpy"), metadata.version("scipy"), *parts))
    return digest.hexdigest()


@lru_cache(maxsize=1)
def _code_digest() -> str:
    """Hash of the modules that a compilation runs: the whole trees of the atmosphere and of radiometry."""
    digest = hashlib.sha256()
    for package in (atmosphere, radiometry):
        folder = Path(package.__file__).parent
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.relative_to(folder.parent).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def _feed(digest, value) -> None:
    """Add a value to a hash: its type, its size, what it holds."""
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
    elif dataclasses.is_dataclass(value):
        digest.update(f"{type(value).__name__} ".encode())
        _feed(digest, {field.name: getattr(value, field.name) for field in dataclasses.fields(value)})
    else:
        raise TypeError(f"no content key for a {type(value).__name__}")


def _write(path: Path, compiled: CompiledBand) -> None:
    """Keep a band: a part file, renamed when it is whole. Where the folder cannot be written nothing is kept."""
    about = {
        "gases": compiled.band.gases,
        "total_points": compiled.total_points,
        "errors": compiled.errors,
        "dropped": compiled.dropped,
    }
    arrays = {
        "index": compiled.index,
        "weight": compiled.band.weight,
        "ladder": compiled.ladder,
        "about": json.dumps(about),
    }
    part = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as file:
            part = Path(file.name)
            np.savez(file, **arrays)
        os.replace(part, path)
    except OSError:
        if part is not None:
            part.unlink(missing_ok=True)


def _read(path: Path, band: BandPoints) -> CompiledBand | None:
    """A kept band, or None where there is none that is whole."""
    try:
        with np.load(path, allow_pickle=False) as kept:
            index, weight, ladder = kept["index"], kept["weight"], kept["ladder"]
            about = json.loads(str(kept["about"]))
        few = BandPoints(band.points.subset(index), weight, tuple(about["gases"]))
        return CompiledBand(few, index, about["total_points"], about["errors"], about["dropped"], ladder)
    except (OSError, EOFError, KeyError, IndexError, ValueError, TypeError, zipfile.BadZipFile):
        return None
