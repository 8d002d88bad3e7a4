"""What a case of the corpus of bad and unusual files is, and the arrays and axes of the good files."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import h5py

REFUSE, EQUAL, EITHER, UNJUDGED = VERDICTS = "refuse", "equal", "either", "unjudged"
AXES = {
    "surface": ("material", "altitude", "azimuth", "slope", "time"),
    "band": ("material", "temperature"),
    "atmosphere": ("share", "height_root", "direction", "source_elevation", "scattering_angle"),
}
PROPERTIES = ("reflectance", "specular_fraction", "shininess", "normalisation")
ARRAYS = {
    "surface": ("temperature",),
    "band": ("blackbody_radiance", *PROPERTIES),
    "atmosphere": ("thermal_ratio", "scattered_ratio", "thermal_reference"),
}
MAIN = {"surface": "temperature", "band": "blackbody_radiance", "atmosphere": "thermal_ratio"}
INNER = {"surface": "time", "band": "temperature", "atmosphere": "height_root"}  # an axis of three nodes or more
HUGE = 1 << 60
# Faults in parts of a texture that no pixel asks for.
NOT_OF_PIXELS = {
    "texture-without-materials-name",
    "texture-without-levels-0-confidence",
    "texture-nan-confidence",
    "texture-names-fewer-than-codes",
}


@dataclass(frozen=True)
class Case:
    """One file of the corpus.

    Attributes
    ----------
    name : str
    kind : str
        Of the good file: surface, band, atmosphere or texture.
    verdict : str
        One of `VERDICTS`.
    mutate : callable
        Changes a copy of the good file.
    """

    name: str
    kind: str
    verdict: str
    mutate: Callable[[Path], object]

    def is_met_by(self, found: str, whole: bool = True) -> bool:
        """Whether a loader did what it must, by what `runtime_loaders.judge` says; `whole` if it reads all of the
        file.
        """
        met = {REFUSE: ("refused",), EQUAL: ("equal",), EITHER: ("refused", "equal")}
        verdict = self.verdict if whole or self.name not in NOT_OF_PIXELS else EITHER
        return verdict == UNJUDGED or found in met[verdict]

    def write(self, good: dict[str, Path], folder: Path) -> Path:
        """Write the file; good files are given by kind."""
        path = folder / f"{self.name}{''.join(good[self.kind].suffixes)}"
        shutil.copyfile(good[self.kind], path)
        self.mutate(path)
        return path


def edited(kind: str, name: str, verdict: str, edit: Callable[[h5py.File], object]) -> Case:
    """A case by a change of the opened file."""

    def mutate(path: Path) -> None:
        with h5py.File(path, "r+") as file:
            edit(file)

    return on_path(kind, name, verdict, mutate)


def on_path(kind: str, name: str, verdict: str, mutate: Callable[[Path], object]) -> Case:
    """A case by a change of the bytes of the file."""
    return Case(f"{kind}-{name}", kind, verdict, mutate)
