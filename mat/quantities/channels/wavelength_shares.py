"""Spectral distribution of the light of each channel within the band: shares of a few wavelengths.

A channel represents an absorption, not a wavelength: light that surfaces emit or reflect in it comes from all
wavelengths whose points it replaced. Shares are fitted so that sample paths let through of each wavelength what they do
at all points of the band, starting from the wavelength of the channel's own point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.line_of_sight import lines_of_sight
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance
from skyshine.mat.quantities.channels.path_fields import REFERENCE
from skyshine.mat.radiometry.band_wavelengths import parted
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.schemas.arrays import Floats

_HOLD = 1e-3  # weight of the channel's own wavelength beside the sample paths, of which light counts as 1
_LEAST_LIGHT = 1e-30  # avoids division by 0 in the dark
_LEAST_SHARE = 1e-9  # fraction of each wavelength in each channel, so that none is without a channel
_BALANCING = 200  # times that rows and columns are scaled


@dataclass(frozen=True, eq=False)
class SamplePaths:
    """n lines of sight, and the elevation of the source at their ends: (n,) arrays, m and rad."""

    length: Floats
    altitude: Floats
    elevation: Floats
    source_elevation: Floats

    def transmittances(self, air: SpectralAir) -> tuple[Floats, Floats]:
        """Transmittances of the paths that end in the air, and from the source to their ends, (k, P) each."""
        through, from_source = [], []
        lines = lines_of_sight(air, self.length[:, None], self.altitude, self.elevation)
        for line, height in zip(lines, self.source_elevation, strict=True):
            if not line.valid[0]:
                continue
            end = min(float(line.surface_altitude[0]), air.shells.top)
            through.append(np.exp(-line.depth[0].astype(float)))
            from_source.append(direct_transmittance(air.source_paths, np.array([end]), np.array([height]))[0, 0])
        points = air.optics.wavenumber.size
        return np.array(through).reshape(-1, points), np.array(from_source).reshape(-1, points)


@dataclass(frozen=True, eq=False)
class PartedLight:
    """Light of a band's points by the wavelengths they lie at.

    Attributes
    ----------
    wavenumber : (P,) array
        cm^-1.
    thermal, source : (P,) arrays
        Spectra of a black body and of the source in the band, by the points' radiance weights; any unit.
    """

    wavenumber: Floats
    thermal: Floats
    source: Floats

    @classmethod
    def of(cls, wavenumber: Floats, radiance_weight: Floats, irradiance: Floats) -> PartedLight:
        """Shares of points with weights (P,) [cm^-1], under a source's irradiance (P,)."""
        return cls(wavenumber, radiance_weight * planck_wavenumber(wavenumber, REFERENCE), radiance_weight * irradiance)


@dataclass(frozen=True, eq=False)
class WavelengthShares:
    """Shares of wavelengths in the light of P channels.

    Attributes
    ----------
    wavelength : (B,) array
        um; `band_wavelengths.parted` between them.
    thermal, source : (P, B) arrays
        Shares of emitted light, and of the source's; each row sums to 1.
    """

    wavelength: Floats
    thermal: Floats
    source: Floats

    @classmethod
    def fitted(
        cls,
        wavelength: Floats,
        paths: SamplePaths,
        exact: tuple[SpectralAir, PartedLight],
        channels: tuple[SpectralAir, PartedLight],
    ) -> WavelengthShares:
        """Fit the shares of the few points' channels.

        Parameters
        ----------
        wavelength : (B,) array
            um.
        exact, channels : pairs of SpectralAir and PartedLight
            All points of the band, and those of the channels.
        """
        (through, beam), (through_few, lit_few) = (paths.transmittances(air) for air, _ in (exact, channels))
        at, at_few = (parted(1e4 / light.wavenumber, wavelength) for _, light in (exact, channels))
        thermal = _shares(_samples(through, exact[1].thermal) @ at, _samples(through_few, channels[1].thermal), at_few)
        thermal = _balanced(thermal, channels[1].thermal, exact[1].thermal @ at)
        source = at_few
        if exact[1].source.any():
            exact_source = _samples(through * beam, exact[1].source) @ at
            source = _shares(exact_source, _samples(through_few * lit_few, channels[1].source), at_few)
        return cls(wavelength, thermal, source)


def _samples(transmittance: Floats, light: Floats) -> Floats:
    """Light (n + 1, P) behind paths of transmittances (n, P), and behind none."""
    return np.vstack([transmittance, np.ones(light.size)]) * light


def _shares(of_wavelengths: Floats, of_channels: Floats, channel_shares: Floats) -> Floats:
    """Shares (P, B) with which the channels' light (n, P) gives that of the wavelengths (n, B).

    `channel_shares` (P, B) are the shares at the points of the channels.
    """
    size = max(float(np.sqrt(np.mean(of_channels.sum(axis=1) ** 2) * len(of_channels))), _LEAST_LIGHT)
    equations = np.vstack([of_channels / size, _HOLD * np.eye(channel_shares.shape[0])])
    columns = [
        scipy.optimize.nnls(equations, np.concatenate([target / size, _HOLD * prior]))[0]
        for target, prior in zip(of_wavelengths.T, channel_shares.T, strict=True)
    ]
    shares = np.stack(columns, axis=1)
    total = shares.sum(axis=1, keepdims=True)
    return np.where(total > 0, shares / np.where(total > 0, total, 1.0), channel_shares)


def _balanced(shares: Floats, of_channels: Floats, of_wavelengths: Floats) -> Floats:
    """Shares (P, B) nearest to some, each row of which sums to 1, that make of the channels' light without air (P,)
    that of the wavelengths (B,): a surface emits so much at each of them, and paths let a part of it through.

    Rows and columns are scaled in turn (Deming and Stephan 1940, Ann. Math. Stat. 11, 427).
    """
    rows, columns = (light / light.sum() if light.sum() > 0 else light for light in (of_channels, of_wavelengths))
    if not (rows.any() and columns.any()):
        return shares
    light = (shares + _LEAST_SHARE) * rows[:, None]
    for _ in range(_BALANCING):
        light *= _over(columns, light.sum(axis=0))
        light *= _over(rows, light.sum(axis=1))[:, None]
    balanced: Floats = np.where(rows[:, None] > 0, light / np.where(rows > 0, rows, 1.0)[:, None], shares)
    return balanced


def _over(target: Floats, light: Floats) -> Floats:
    """Factors that make of some light what is wanted; 1 where there is none."""
    return np.where(light > 0, target / np.where(light > 0, light, 1.0), 1.0)
