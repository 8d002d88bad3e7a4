"""What an installation has: versions, packages, extras, threads, cache."""

from __future__ import annotations

import os
import platform
import re
from importlib import metadata
from typing import Any

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.threads import core_count, thread_count
from skyshine.materials.library import load_library
from skyshine.schemas.kept_arrays import kept_folder

_EXTRA = re.compile(r"extra == ['\"]([\w-]+)['\"]")
_OWN = "skyshine"
_FOR_DEVELOPERS = ("dev", "fuzz", "mutation", "test", "validation")


def installation() -> dict[str, Any]:
    """Versions of the package, its data and its dependencies, and what the extras lack.

    Returns
    -------
    dict
        ``missing`` lists packages that every command needs; ``extras`` has a list of lacking packages by extra.

    Examples
    --------
    >>> import skyshine
    >>> installation()["skyshine"] == skyshine.__version__
    True
    """
    packages: dict[str, str] = {}
    missing: list[str] = []
    extras: dict[str, list[str]] = {}
    for requirement in metadata.requires(_OWN) or []:
        extra, marker = _EXTRA.search(requirement), requirement.partition(";")[2]
        name = re.split(r"[^\w.-]", requirement, maxsplit=1)[0]
        if name == _OWN or (extra and extra[1] in _FOR_DEVELOPERS):
            continue
        version = _version(name)
        if extra:
            lacking = extras.setdefault(extra[1], [])
            # A marker for some systems alone is not evaluated: the package may rightly be absent.
            if version is None and "platform" not in marker:
                lacking.append(name)
        elif version is None:
            missing.append(name)
        else:
            packages[name] = version
    cache = kept_folder("bands")
    sizes = [file.stat().st_size for file in cache.parent.rglob("*") if file.is_file()] if cache else []
    return {
        "skyshine": metadata.version(_OWN),
        "python": platform.python_version(),
        "platform": platform.platform(terse=True),
        "materials": load_library().version,
        "band_model": AbsorptionTable.open().version,
        "packages": packages,
        "missing": missing,
        "extras": extras,
        "cores": core_count(),
        "threads": thread_count(),
        "cache": {"folder": str(cache.parent) if cache else "none", "files": len(sizes), "bytes": sum(sizes)},
        "environment": {name: value for name, value in sorted(os.environ.items()) if name.startswith("SKYSHINE_")},
    }


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None
