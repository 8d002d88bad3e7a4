"""Optical properties of air at the levels of a state: gases, continua, molecular scattering, particles, emission.

Cross sections are per molecule of air [m^2]; `geometry` counts paths in molecules of air per m^2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.gases.spectral_points import SpectralPoints
from skyshine.mat.atmosphere.particles.moments import MOMENTS, moment_weights
from skyshine.mat.atmosphere.state.state import AerosolComponent, AtmosphericState
from skyshine.mat.atmosphere.transfer.geometry import STANDARD_DENSITY, refractivity
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.schemas.arrays import Floats, Integers

# Gases whose two-sided king factors make up that of air (Bodhaine et al. 1999, equations 5, 6 and 23), percent by
# volume.
_KING_NITROGEN, _KING_OXYGEN, _KING_ARGON, _ARGON_PERCENT = 78.084, 20.946, 1.00, 0.934
_KING_CARBON_DIOXIDE = 1.15
# Refractivity grows by 54 % of the carbon dioxide fraction beyond 300 ppmv (Bodhaine et al. 1999, equation 19).
_REFRACTIVITY_OF_CO2 = 0.54
# Aerosol phase functions are given at wavelengths whose steps are at most this ratio, and are linear between.
_PHASE_WAVELENGTH_RATIO = 1.25
PHASE_ANGLES = np.radians(np.linspace(0.0, 180.0, 361))


_SPHERE = moment_weights(PHASE_ANGLES, 1)[0]


@dataclass(frozen=True, eq=False)
class SpectralOptics:
    """Optical properties at N levels and P spectral points; cross sections in m^2 per molecule of air.

    Attributes
    ----------
    wavenumber : (P,) array
        cm^-1, middle of each point's interval: properties that vary slowly are taken there.
    absorption : dict of (N, P) arrays
        Absorption by gas, "H2O_continuum" apart.
    rayleigh : (N, P) array
    rayleigh_anisotropy : (P,) array
        Depolarisation term gamma of the molecular phase function.
    aerosol_extinction, aerosol_scattering : (N, P) arrays
        Extinction and scattering of all particles: aerosol, cloud and rain.
    asymmetry : (N, P) array
        Asymmetry of the particles: mean cosine of their scattering angle.
    phase : (A, N, C) array
        Phase function of the particles at `PHASE_ANGLES`, levels and C wavelengths; mean over the sphere 1.
    moments : (`MOMENTS`, N, C) array
        Its Legendre moments, from the particles' own: forward peaks of droplets and drops are narrower than the steps
        of the angles.
    phase_share : (C, P) array
        Weight of each of those wavelengths at each point.
    emission : (N, P) array
        Blackbody radiance at the level's temperature, W m^-2 sr^-1 (cm^-1)^-1.
    extinction : (N, P) array
        Sum of everything.
    """

    wavenumber: Floats
    absorption: dict[str, Floats]
    rayleigh: Floats
    rayleigh_anisotropy: Floats
    aerosol_extinction: Floats
    aerosol_scattering: Floats
    asymmetry: Floats
    phase: Floats
    moments: Floats
    phase_share: Floats
    emission: Floats
    extinction: Floats

    def at(self, points: slice | Integers) -> SpectralOptics:
        """The optical properties at some of the points."""
        names = (
            "rayleigh",
            "aerosol_extinction",
            "aerosol_scattering",
            "asymmetry",
            "phase_share",
            "emission",
            "extinction",
        )
        return replace(
            self,
            wavenumber=self.wavenumber[points],
            absorption={gas: np.ascontiguousarray(values[:, points]) for gas, values in self.absorption.items()},
            rayleigh_anisotropy=self.rayleigh_anisotropy[points],
            **{name: np.ascontiguousarray(getattr(self, name)[:, points]) for name in names},
        )


def spectral_optics(
    state: AtmosphericState, points: SpectralPoints, gases: Sequence[str] | None = None
) -> SpectralOptics:
    """Optical properties of a state at spectral points.

    Parameters
    ----------
    gases : sequence of str, optional
        Those that absorb; by default every one the absorption table and the state contain.
    """
    wavenumber = points.interval_edges.mean(axis=1)[points.interval]
    absorption = gas_absorption(state, points, gases)
    co2_percent = 100.0 * state.mole_fraction["CO2"][0]
    section, anisotropy = rayleigh_scattering(wavenumber, co2_percent)
    rayleigh = np.broadcast_to(section, (state.altitude.size, wavenumber.size))
    aerosol_extinction, aerosol_scattering, asymmetry = _particles(state, wavenumber)
    phase, moments, phase_share = _mixed_phase(state, wavenumber)
    return SpectralOptics(
        wavenumber=wavenumber,
        absorption=absorption,
        rayleigh=rayleigh,
        rayleigh_anisotropy=anisotropy,
        aerosol_extinction=aerosol_extinction,
        aerosol_scattering=aerosol_scattering,
        asymmetry=asymmetry,
        phase=phase,
        moments=moments,
        phase_share=phase_share,
        emission=planck_wavenumber(wavenumber, state.temperature[:, None]),
        extinction=rayleigh + aerosol_extinction + sum(absorption.values()),
    )


def gas_absorption(
    state: AtmosphericState, points: SpectralPoints, gases: Sequence[str] | None = None
) -> dict[str, Floats]:
    """Absorption by gas, dict of (N, P) m^2 per molecule of air; arguments as `spectral_optics`."""
    sections = points.cross_sections(state.pressure, state.temperature, state.mole_fraction["H2O"], gases=gases)
    absorption = {}
    for gas, section in sections.items():
        fraction = state.mole_fraction.get(gas.removesuffix("_continuum"))
        if fraction is not None:
            absorption[gas] = section * fraction[:, None]
    return absorption


def rayleigh_scattering(wavenumber: Floats, co2_percent: float) -> tuple[Floats, Floats]:
    """Scattering by air molecules.

    Parameters
    ----------
    wavenumber : (P,) array
        cm^-1.
    co2_percent : float
        Carbon dioxide, percent by volume.

    Returns
    -------
    section : (P,) array
        m^2 per molecule.
    anisotropy : (P,) array
        gamma = depolarisation / (2 - depolarisation).

    References
    ----------
    Bodhaine et al. 1999, J. Atmos. Oceanic Technol. 16, 1854, equations 2, 5, 6, 19 and 23.
    Chandrasekhar 1950 for the phase function with gamma.
    """
    micron = 1e4 / wavenumber
    king_nitrogen = 1.034 + 3.17e-4 / micron**2
    king_oxygen = 1.096 + 1.385e-3 / micron**2 + 1.448e-4 / micron**4
    parts = np.array([_KING_NITROGEN, _KING_OXYGEN, _ARGON_PERCENT, co2_percent])
    king = parts[0] * king_nitrogen + parts[1] * king_oxygen + parts[2] * _KING_ARGON + parts[3] * _KING_CARBON_DIOXIDE
    king = king / parts.sum()
    square = (1 + refractivity(wavenumber) * (1 + _REFRACTIVITY_OF_CO2 * (co2_percent / 100 - 300e-6))) ** 2
    length = micron * 1e-6  # m
    section = 24 * np.pi**3 * (square - 1) ** 2 / (length**4 * STANDARD_DENSITY**2 * (square + 2) ** 2) * king
    # King factor (6 + 3 d) / (6 - 7 d) gives the depolarisation d.
    depolarisation = 6 * (king - 1) / (3 + 7 * king)
    return section, depolarisation / (2 - depolarisation)


def rayleigh_phase(cosine: Floats, anisotropy: npt.ArrayLike) -> Floats:
    """Molecular phase function, mean over the sphere 1.

    Parameters
    ----------
    cosine : array
        Cosine of the scattering angle.
    anisotropy : array_like
        gamma of `rayleigh_scattering`; the two broadcast against each other.

    References
    ----------
    Bodhaine et al. 1999, J. Atmos. Oceanic Technol. 16, 1854, equation 10.
    """
    anisotropy = np.asarray(anisotropy)
    phase: Floats = 0.75 / (1 + 2 * anisotropy) * ((1 + 3 * anisotropy) + (1 - anisotropy) * cosine**2)
    return phase


def _particles(state: AtmosphericState, wavenumber: Floats) -> tuple[Floats, Floats, Floats]:
    """Extinction and scattering by all particles [m^2 per molecule of air] and their mean asymmetry, (N, P) each."""
    shape = (state.altitude.size, wavenumber.size)
    extinction, scattering, forward = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    for component in state.particles:
        component_extinction, component_scattering, component_asymmetry = particle_sections(
            state, component, wavenumber
        )
        extinction += component_extinction
        scattering += component_scattering
        forward += component_scattering * component_asymmetry
    return extinction, scattering, np.where(scattering > 0, forward / np.where(scattering > 0, scattering, 1.0), 0.0)


def _mixed_phase(state: AtmosphericState, wavenumber: Floats) -> tuple[Floats, Floats, Floats]:
    """Phase function (A, N, C) of the mixture of particles at each level, its moments (`MOMENTS`, N, C), weights (C, P)
    of its wavelengths.
    """
    nodes, share = _phase_wavelengths(wavenumber)
    phase = np.zeros((PHASE_ANGLES.size, state.altitude.size, nodes.size))
    moments = np.zeros((MOMENTS, state.altitude.size, nodes.size))
    total = np.zeros((state.altitude.size, nodes.size))
    for component in state.particles:
        _, scattering, _ = particle_sections(state, component, nodes)
        phase += scattering * component.model.phase_function(np.cos(PHASE_ANGLES), nodes, state.relative_humidity)
        moments += scattering * component.model.phase_moments(nodes, state.relative_humidity)
        total += scattering
    scatters, divisor = total > 0, np.where(total > 0, total, 1.0)
    phase = normalised(np.where(scatters, phase / divisor, 1.0))
    isotropic = (np.arange(MOMENTS) == 0).astype(float)[:, None, None]
    moments = np.where(scatters, moments / divisor, isotropic)
    # Layers are linear between levels: at the edge of a cloud the level without particles must not add a phase function
    # of its own, and takes that of the nearest level with particles.
    filled = np.flatnonzero(np.all(scatters, axis=1))
    if filled.size:
        nearest = filled[np.argmin(np.abs(np.arange(total.shape[0])[:, None] - filled), axis=1)]
        phase, moments = phase[:, nearest], moments[:, nearest]
    return phase, moments, share


def particle_sections(
    state: AtmosphericState, component: AerosolComponent, wavenumber: Floats
) -> tuple[Floats, Floats, Floats]:
    """Extinction and scattering by one kind of particle [m^2 per molecule of air] and asymmetry, (N, P) each, at
    wavenumbers (P,) [cm^-1].
    """
    amount = (component.extinction_550 / state.number_density)[:, None]
    optics = component.model.optics(wavenumber, state.relative_humidity)
    return amount * optics.extinction, amount * optics.extinction * optics.single_scattering_albedo, optics.asymmetry


def normalised(phase: Floats) -> Floats:
    """Phase functions (A, ...) at `PHASE_ANGLES`, linear between the angles, scaled to a mean of 1 over the sphere.

    A mean other than 1 comes from forward peaks narrower than the step of the angles. The value at 0 therefore takes
    the correction, as long as it stays the largest; all other values are kept.
    """
    phase = np.array(phase, dtype=float)
    missing = 1 - np.tensordot(_SPHERE, phase, axes=1)
    phase[0] = np.maximum(phase[0] + missing / _SPHERE[0], np.minimum(phase[0], phase[1]))
    scaled: Floats = phase / np.tensordot(_SPHERE, phase, axes=1)
    return scaled


def _phase_wavelengths(wavenumber: Floats) -> tuple[Floats, Floats]:
    """Wavenumbers (C,) [cm^-1] of the phase functions, and their weights (C, P), linear in wavelength."""
    wavelength = 1e4 / wavenumber
    low, high = wavelength.min(), wavelength.max()
    count = 1 + int(np.ceil(np.log(high / low) / np.log(_PHASE_WAVELENGTH_RATIO) - 1e-9))
    nodes = np.geomspace(low, high, count)
    if count == 1:
        return 1e4 / nodes, np.ones((1, wavenumber.size))
    upper = np.clip(np.searchsorted(nodes, wavelength, side="right"), 1, count - 1)
    fraction = np.clip((wavelength - nodes[upper - 1]) / (nodes[upper] - nodes[upper - 1]), 0.0, 1.0)
    share = np.zeros((count, wavenumber.size))
    column = np.arange(wavenumber.size)
    share[upper - 1, column] = 1.0 - fraction
    share[upper, column] += fraction
    return 1e4 / nodes, share
