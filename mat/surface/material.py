"""The properties of a material that determine its heat balance."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

from skyshine.mat.surface.wet_skin import FilmSkin, MoistSkin
from skyshine.materials.records import SurfaceProperties, ThermalStack
from skyshine.schemas.errors import InputError


@dataclass(frozen=True)
class SurfaceMaterial:
    """A surface as the heat balance sees it; equal ones are solved once.

    Attributes
    ----------
    name : str
        For messages.
    thermal : ThermalStack
    surface : SurfaceProperties
    solar_absorptance, thermal_emissivity : float
        0 to 1.
    film : FilmSkin or None
        Under a film of water, where rain or dew may bring one.
    moist : MoistSkin or None
        By soil moisture, where that changes through the day; the stack has its mean.

    Raises
    ------
    InputError
        An absorptance or emissivity lies outside 0 to 1.
    """

    name: str
    thermal: ThermalStack
    surface: SurfaceProperties
    solar_absorptance: float
    thermal_emissivity: float
    film: FilmSkin | None = None
    moist: MoistSkin | None = None

    def __post_init__(self) -> None:
        for quantity in ("solar_absorptance", "thermal_emissivity"):
            value = getattr(self, quantity)
            if not 0 <= value <= 1:
                raise InputError(f"material '{self.name}': found {quantity} {value:g}; allowed: 0 to 1")

    @property
    def physics(self) -> tuple[Hashable, ...]:
        """All but the name: materials of equal physics have equal temperatures."""
        return (self.thermal, self.surface, self.solar_absorptance, self.thermal_emissivity, self.film, self.moist)
