"""Aerosol types of OPAC: mixtures of components whose sizes and refractive indices are published, as spheres.

References
----------
Hess et al. 1998, Bull. Am. Meteorol. Soc. 79, 831 (Tables 1c and 4).
"""

from __future__ import annotations

from functools import cache

import numpy as np

from skyshine.mat.atmosphere.particles import tables
from skyshine.mat.atmosphere.particles.aerosol import AerosolModel, interpolate_humidity, log_humidity_weights
from skyshine.schemas.arrays import Floats

# Particles of each component in a cm^3 of the air at the ground.
TYPES: dict[str, dict[str, float]] = {
    "opac_continental_clean": {"waso": 2600.0, "inso": 0.15},
    "opac_continental_average": {"waso": 7000.0, "inso": 0.4, "soot": 8300.0},
    "opac_continental_polluted": {"waso": 15700.0, "inso": 0.6, "soot": 34300.0},
    "opac_urban": {"waso": 28000.0, "inso": 1.5, "soot": 130000.0},
    "opac_desert": {"waso": 2000.0, "minm": 269.5, "miam": 30.5, "micm": 0.142},
    "opac_maritime_clean": {"waso": 1500.0, "ssam": 20.0, "sscm": 3.2e-3},
    "opac_maritime_polluted": {"waso": 3800.0, "ssam": 20.0, "sscm": 3.2e-3, "soot": 5180.0},
    "opac_maritime_tropical": {"waso": 590.0, "ssam": 10.0, "sscm": 1.3e-3},
    "opac_arctic": {"waso": 1300.0, "inso": 0.01, "ssam": 1.9, "soot": 5300.0},
    "opac_antarctic": {"suso": 42.9, "ssam": 0.047, "mitr": 0.0053},
}
_PER_KM = 1e-3  # 1 um^2 cm^-3 in km^-1
_LEAST_ABSORPTION = 1e-12  # smallest absorption of the extinction: its logarithm is interpolated


def opac_model(name: str) -> AerosolModel:
    """One of `TYPES`, from 0.25 to 40 um and at humidities of 0 to 99 %."""
    return _with_amount(name)[0]


def opac_extinction(name: str, relative_humidity: float) -> float:
    """Extinction at 0.55 um at the ground, km^-1, of the published amounts at a humidity [percent]."""
    model, at_550 = _with_amount(name)
    weights = log_humidity_weights(model.humidity, np.clip([relative_humidity], 0.0, model.humidity[-1]))
    return float(interpolate_humidity(weights, at_550[:, None])[0, 0])


@cache
def _with_amount(name: str) -> tuple[AerosolModel, Floats]:
    """The model, and its extinction at 0.55 um at its humidities (H,), km^-1."""
    parts = [(number, tables.scattering_table(f"opac_{part}")) for part, number in TYPES[name].items()]
    humid = max((table for _, table in parts), key=lambda table: table.node.size)
    extinction, absorption = np.zeros((2, humid.node.size, humid.wavelength.size))
    phase, moments = np.zeros((humid.angle.size, *extinction.shape)), np.zeros((len(humid.moments), *extinction.shape))
    for number, table in parts:
        extinction = extinction + number * table.extinction
        absorption = absorption + number * table.absorption
        scattering = number * (table.extinction - table.absorption)
        phase += scattering * table.phase
        moments += scattering * table.moments
    scattering = extinction - absorption
    at_550 = extinction[:, np.searchsorted(humid.wavelength, 0.55)]
    model = AerosolModel(
        name=name,
        humidity=humid.node,
        wavelength=humid.wavelength,
        extinction=extinction / at_550[:, None],
        absorption=np.maximum(absorption, _LEAST_ABSORPTION * extinction) / at_550[:, None],
        asymmetry=moments[1] / scattering,
        phase_angle=humid.angle,
        phase_wavelength=humid.wavelength,
        phase=phase / scattering,
        moments=moments / scattering,
    )
    return model, _PER_KM * at_550
