"""Partition sums (TIPS-2021) and molar masses, from HITRAN's own Python package."""

from __future__ import annotations

import contextlib
import functools
import io
from collections.abc import Callable
from types import ModuleType
from typing import cast

import numpy as np

from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.errors import InputError

REFERENCE_TEMPERATURE = 296.0  # K, of the HITRAN line strengths and widths


@functools.cache
def _hapi() -> ModuleType:
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # it greets on import
            import hapi as package
    except ImportError:
        raise InputError(
            "the package 'hitran-api' is needed for partition sums; install it with: pip install"
            " 'skyshine[spectroscopy]'"
        ) from None
    return cast(ModuleType, package)


@functools.lru_cache(maxsize=4096)
def partition_ratio(molecule: int, isotopologue: int, temperature: float) -> float:
    """Q(296 K) / Q(T) of one isotopologue, TIPS-2021 (Gamache et al. 2021, JQSRT 271, 107713)."""
    sums = _hapi().partitionSum
    return float(sums(molecule, isotopologue, REFERENCE_TEMPERATURE) / sums(molecule, isotopologue, temperature))


@functools.cache
def reference_sum(molecule: int, isotopologue: int) -> float:
    """Partition sum of one isotopologue at 296 K, TIPS-2021."""
    return float(_hapi().partitionSum(molecule, isotopologue, REFERENCE_TEMPERATURE))


@functools.cache
def molar_mass(molecule: int, isotopologue: int) -> float:
    """Molar mass in g mol^-1 (HITRAN's isotopologue table)."""
    return float(_hapi().molecularMass(molecule, isotopologue))


def per_line(function: Callable[..., float], molecule: int, isotopologue: Integers, *arguments: float) -> Floats:
    """A function of (molecule, isotopologue, ...) for each line; isotopologue (N,) -> (N,)."""
    kinds, where = np.unique(isotopologue, return_inverse=True)
    return np.array([function(molecule, int(kind), *arguments) for kind in kinds])[where]
