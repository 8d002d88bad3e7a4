"""Layers of water and ice cloud.

Optical properties (``atmospheres/cloud``) of droplets are by Mie theory, with a gamma distribution of effective
variance 0.1, those of crystals of rough aggregates (`crystals`). A cloud is even between its base and its top; it is
part of the particles of a state, so that whatever air and aerosol take part in, cloud does too.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.particles import tables
from skyshine.mat.atmosphere.particles.crystals import CrystalModel
from skyshine.mat.atmosphere.particles.particles import (
    SpectralModel,
    SphereModel,
    interpolated_phase,
    interpolated_table,
)
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError, nearest

PHASES = ("water", "ice")
TYPES = ("cumulus", "altostratus", "stratus", "stratocumulus", "nimbostratus", "cirrus", "thin_cirrus")
RADII = {"water": (2.0, 30.0), "ice": (5.0, 100.0)}  # um, of the tables
# Radii of a cloud of no type: droplets over land and sea differ by a factor of 2 about 10 um (Miles et al. 2000, J.
# Atmos. Sci. 57, 295); crystals of cirrus have 20 to 40 um (Baum et al. 2011, J. Appl. Meteorol. Climatol. 50, 1037).
DEFAULT_RADII = {"water": 10.0, "ice": 30.0}
LARGEST_OPTICAL_DEPTH = 1e5
TOP_LIMIT = 20e3  # m above the ground
# Base and top fade out over this part of the thickness, at most this far, m.
_EDGE_SHARE, _EDGE = 0.05, 10.0
THINNEST = 10.0  # m
# Water freezes at once below, ice melts above these, K (homogeneous freezing: Pruppacher and Klett 1997, section 7.2).
COLDEST_WATER, WARMEST_ICE = 233.15, 273.15


@dataclass(frozen=True)
class CloudLayer:
    """An even layer of cloud.

    Attributes
    ----------
    phase : str
        One of `PHASES`.
    base, top : float
        m above the ground.
    effective_radius : float
        um: three quarters of the ratio of volume to projected area, for crystals too.
    optical_depth : float
        Vertical, at 0.55 um.
    """

    phase: str
    base: float
    top: float
    effective_radius: float
    optical_depth: float

    def __post_init__(self) -> None:
        if self.phase not in PHASES:
            raise InputError(f"no cloud of '{self.phase}'; {nearest(self.phase, PHASES)}")
        if not (self.base >= 0 and self.base + THINNEST <= self.top <= TOP_LIMIT):
            raise InputError(
                f"cloud from {self.base / 1e3:g} to {self.top / 1e3:g} km above the ground is not allowed; give a base"
                f" of at least 0 and a top at least {THINNEST / 1e3:g} km higher, at most {TOP_LIMIT / 1e3:g} km"
            )
        low, high = RADII[self.phase]
        if not low <= self.effective_radius <= high:
            raise InputError(
                f"effective radius {self.effective_radius:g} um of {self.phase} is outside {low:g} to {high:g} um"
            )
        if not 0 <= self.optical_depth <= LARGEST_OPTICAL_DEPTH:
            raise InputError(
                f"optical depth {self.optical_depth:g} of a cloud is outside 0 to {LARGEST_OPTICAL_DEPTH:g}"
            )

    @classmethod
    def of_water_path(
        cls, phase: str, base: float, top: float, effective_radius: float, water_path: float
    ) -> CloudLayer:
        """A layer by its path of liquid water or ice [kg m^-2]; `InputError` as the class."""
        thin = cls(phase, base, top, effective_radius, 0.0)
        return cls(phase, base, top, effective_radius, water_path * thin._model[1])

    @property
    def edges(self) -> tuple[float, ...]:
        """Heights above the ground at which levels must be, m."""
        inner = self.base + self._fade if self.base > 0 else self.base
        return (self.base, inner, self.top - self._fade, self.top)

    @property
    def model(self) -> SpectralModel:
        """Optical properties of the droplets or crystals."""
        return self._model[0]

    @property
    def water_path(self) -> float:
        """Liquid water or ice, kg m^-2."""
        return self.optical_depth / self._model[1]

    def extinction_550(self, height: npt.ArrayLike) -> Floats:
        """At 0.55 um at heights above the ground [m], m^-1."""
        height = np.asarray(height)
        fade = self._fade
        shape = np.clip((self.top - height) / fade, 0.0, 1.0)
        if self.base > 0:
            shape = np.minimum(shape, np.clip((height - self.base) / fade, 0.0, 1.0))
        thickness = self.top - self.base - (fade if self.base > 0 else 0.5 * fade)
        extinction: Floats = self.optical_depth / thickness * shape
        return extinction

    @property
    def _fade(self) -> float:
        return min(_EDGE, _EDGE_SHARE * (self.top - self.base))

    @property
    def _model(self) -> tuple[SpectralModel, float]:
        return _cloud_model(self.phase, self.effective_radius)


def cloud_type(name: str) -> CloudLayer:
    """A cloud of LOWTRAN7's types as a `CloudLayer`; `InputError` for an unknown name."""
    types = cloud_types()
    if name not in types:
        raise InputError(f"no cloud type '{name}'; {nearest(name, types)}")
    return types[name]


def check_phase(layer: CloudLayer, temperature: Floats) -> None:
    """Refuse droplets that would freeze and crystals that would melt.

    Parameters
    ----------
    temperature : array
        Temperature of the air in the layer, K.

    Raises
    ------
    InputError
    """
    coldest, warmest = float(np.min(temperature)), float(np.max(temperature))
    where = (
        f"cloud from {layer.base / 1e3:g} to {layer.top / 1e3:g} km above the ground, where the air has {coldest:.1f}"
        f" to {warmest:.1f} K"
    )
    if layer.phase == "water" and warmest < COLDEST_WATER:
        raise InputError(f"water {where}, is frozen below {COLDEST_WATER:g} K; make it ice, or lower it")
    if layer.phase == "ice" and coldest > WARMEST_ICE:
        raise InputError(f"ice {where}, melts above {WARMEST_ICE:g} K; make it water, or raise it")


@lru_cache(maxsize=32)
def _cloud_model(phase: str, radius: float) -> tuple[SpectralModel, float]:
    """The model, and its extinction at 0.55 um in m^2 kg^-1."""
    columns = interpolated_table(tables.cloud_table(phase), radius)
    if phase == "ice":
        return CrystalModel.of_table("ice cloud", *columns, effective_radius=radius)
    return SphereModel.of_table("water cloud", *columns, **interpolated_phase(tables.phase_table("water"), radius))


@lru_cache(maxsize=1)
def cloud_types() -> dict[str, CloudLayer]:
    """The clouds of LOWTRAN7 by name."""
    table = tables.cloud_types_table()
    return {
        str(row[0]): CloudLayer(str(row[1]), float(row[2]) * 1e3, float(row[3]) * 1e3, float(row[5]), float(row[4]))
        for row in zip(*table.values(), strict=True)
    }
