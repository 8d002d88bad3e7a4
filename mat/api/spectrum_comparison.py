"""A spectrum of ours beside one of another program, in common bins."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.spectra.spectrum import LineSpectrum
from skyshine.mat.tables.dataset import Column
from skyshine.mat.tables.other_spectra import OtherSpectrum
from skyshine.mat.tables.spectrum_file import RADIANCE
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

_ROUNDING = 1e-9  # fraction of a wavenumber [cm^-1], so that equal ends of two grids overlap


@dataclass(frozen=True, eq=False)
class SpectrumComparison:
    """Two spectra in bins that both cover, the coarser of the two.

    Attributes
    ----------
    file : Path
    wavenumber : (M,) array
        Middle of each bin [cm^-1].
    computed, reference : dict of str to (M,) array
        Transmittance, path_thermal and path_scattered [W m^-2 sr^-1 (cm^-1)^-1] as far as the file has them: our means
        over the bins, and those of the file.
    """

    file: Path
    wavenumber: Floats
    computed: dict[str, Floats]
    reference: dict[str, Floats]

    @property
    def difference(self) -> dict[str, Floats]:
        """Computed minus reference, (M,) each."""
        return {name: values - self.reference[name] for name, values in self.computed.items()}

    @property
    def rms(self) -> dict[str, float]:
        """Root mean square of the difference over the bins."""
        return {name: float(np.sqrt(np.mean(values**2))) for name, values in self.difference.items()}

    @property
    def means(self) -> dict[str, tuple[float, float]]:
        """Mean over the bins, computed and of the reference."""
        return {name: (float(np.mean(v)), float(np.mean(self.reference[name]))) for name, v in self.computed.items()}

    @property
    def columns(self) -> dict[str, Column]:
        """Units and values (M,): of each quantity the computed, the reference and the difference."""
        columns: dict[str, Column] = {"wavenumber": ("cm^-1", self.wavenumber)}
        for name, values in self.computed.items():
            unit = "1" if name == "transmittance" else RADIANCE
            columns |= {name: (unit, values), f"{name}_reference": (unit, self.reference[name])}
            columns[f"{name}_difference"] = (unit, self.difference[name])
        return columns

    @property
    def summary(self) -> dict[str, str]:
        """Band mean, its reference and the rms of the difference in words, by quantity."""
        return {
            name: f"mean {ours:.6g}, of {self.file.name} {theirs:.6g}; difference {ours - theirs:+.3g}, rms"
            f" {self.rms[name]:.3g}"
            for name, (ours, theirs) in self.means.items()
        }


def compared(spectrum: LineSpectrum, other: OtherSpectrum) -> SpectrumComparison:
    """A single line of sight beside the spectrum of a file.

    Raises
    ------
    InputError
        No bin that both cover.
    """
    ours, theirs = _edges(spectrum.wavenumber), _edges(other.wavenumber)
    bins = ours if np.median(np.diff(ours)) >= np.median(np.diff(theirs)) else theirs
    low, high = max(ours[0], theirs[0]) - _ROUNDING, min(ours[-1], theirs[-1]) + _ROUNDING
    bins = bins[(bins >= low) & (bins <= high)]
    if bins.size < 2:
        raise InputError(
            f"covers {other.wavenumber[0]:g} to {other.wavenumber[-1]:g} cm^-1, the computed spectrum"
            f" {ours[0]:g} to {ours[-1]:g}; allowed: spectra with a bin in common",
            file=other.file,
        )
    computed = {name: _rebinned(ours, getattr(spectrum, name), bins) for name in other.values}
    reference = {name: _rebinned(theirs, values, bins) for name, values in other.values.items()}
    return SpectrumComparison(other.file, 0.5 * (bins[1:] + bins[:-1]), computed, reference)


def _edges(middle: Floats) -> Floats:
    """Edges of bins around their middles."""
    inner = 0.5 * (middle[1:] + middle[:-1]) if middle.size > 1 else np.empty(0)
    half = np.diff(middle) / 2 if middle.size > 1 else np.array([0.5])
    return np.concatenate([[middle[0] - half[0]], inner, [middle[-1] + half[-1]]])


def _rebinned(edges: Floats, values: Floats, bins: Floats) -> Floats:
    """Means over other bins of values that are even in each bin."""
    integral = np.append(0.0, np.cumsum(values * np.diff(edges)))
    return np.asarray(np.diff(np.interp(bins, edges, integral)) / np.diff(bins))
