"""The compiled library beside this module, checked against its sources; its functions by lanes of the processor."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from skyshine.mat.kernel.sources import sources_digest
from skyshine.schemas.errors import InputError

VARIABLE = "SKYSHINE_LANES"
NAME = {"win32": "libskyshine.dll", "darwin": "libskyshine.dylib"}.get(sys.platform, "libskyshine.so")
INSTALL = "install it with `pip install .` in the checkout, or with `pip install -e .` where its sources are edited"


@cache
def library() -> ctypes.CDLL:
    """The library beside this module.

    Raises
    ------
    InputError
        There is none, the system does not load it, or it was compiled from other sources than those beside it.

    Examples
    --------
    >>> library().skyshine_lanes() in (4, 8)
    True
    """
    return _load(Path(__file__).parent)


def _load(folder: Path) -> ctypes.CDLL:
    file = folder / NAME
    if not file.is_file():
        raise InputError(f"the compiled library is missing; {INSTALL}", file=file)
    try:
        loaded = ctypes.CDLL(str(file))
    except OSError as error:
        raise InputError(f"this system does not load the library ({error}); {INSTALL}", file=file) from error
    digest = sources_digest(folder)
    loaded.skyshine_sources.restype = ctypes.c_char_p
    if digest and loaded.skyshine_sources().decode() != digest:
        raise InputError("the library was compiled from other sources; compile it with `pip install -e .`", file=file)
    return loaded


@cache
def lanes() -> int:
    """Numbers of a vector: 8 where processor and system have AVX2, else 4; SKYSHINE_LANES=4 or 8 states it.

    Raises
    ------
    InputError
        SKYSHINE_LANES is another value, or 8 on a processor without AVX2.

    Notes
    -----
    Results have the same bytes with either.
    """
    widest = int(library().skyshine_lanes())
    allowed = [str(number) for number in (4, 8) if number <= widest]
    text = os.environ.get(VARIABLE) or str(widest)
    if text not in allowed:
        raise InputError(f"{VARIABLE}={text}: allowed on this processor: {', '.join(allowed)}; unset it")
    return int(text)


def function(name: str, argtypes: Sequence[Any] | None, restype: Any) -> Callable[..., Any]:
    """A function of the library, compiled for the lanes of this processor.

    Parameters
    ----------
    name : str
        Name in the C sources' `SKYSHINE_NAME`, without `_4` and `_8`.
    argtypes, restype : ctypes types
        Types of the arguments (None where calls state them) and of the result (None for no result).

    Raises
    ------
    AttributeError
        The library has no function of that name.
    """
    called = getattr(library(), f"{name}_{lanes()}")
    called.argtypes, called.restype = argtypes, restype
    return called  # type: ignore[no-any-return]
