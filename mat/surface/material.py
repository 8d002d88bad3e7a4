"""The properties of a material that determine its heat balance."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.surface.wet_skin import FilmSkin, MoistSkin
from skyshine.materials.records import SurfaceProperties, ThermalStack
from skyshine.schemas.errors import InputError


@dataclass(frozen=True)
class SurfaceMaterial:
    """A surface as the heat balance sees it; equal ones are solved once.

    Attributes
    ----------
    name : str
        Name, for messages.
    solar_absorptance, thermal_emissivity : float
        0 to 1.
    film : FilmSkin or None
        Skin under a film of water, where rain or dew may form one.
    moist : MoistSkin or None
        Skin by soil moisture, where that changes through the day; the stack has its mean.
    canopy : Canopy or None
        Canopy of leaves with soil visible through its gaps; absorptance and emissivity are those of both together.
        None: one skin.

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
    canopy: Canopy | None = None

    def __post_init__(self) -> None:
        for quantity in ("solar_absorptance", "thermal_emissivity"):
            value = getattr(self, quantity)
            if not 0 <= value <= 1:
                raise InputError(f"material '{self.name}': found {quantity} {value:g}; allowed: 0 to 1")

    def with_optics(
        self, solar_absorptance: float | None = None, thermal_emissivity: float | None = None
    ) -> SurfaceMaterial:
        """The material with the values that are given; of an open canopy, leaves and soil alike."""
        canopy = self.canopy
        if canopy is not None:
            leaves, soil = (
                part.with_optics(solar_absorptance, thermal_emissivity) for part in (canopy.leaves, canopy.soil)
            )
            canopy = replace(canopy, leaves=leaves, soil=soil)
        return replace(
            self,
            solar_absorptance=self.solar_absorptance if solar_absorptance is None else solar_absorptance,
            thermal_emissivity=self.thermal_emissivity if thermal_emissivity is None else thermal_emissivity,
            canopy=canopy,
        )


@dataclass(frozen=True)
class Canopy:
    """Leaves and the soil beneath them, each as if alone.

    Attributes
    ----------
    leaf_area : float
        Leaf area index times clumping, above 0 [m^2 m^-2].
    leaves, soil : SurfaceMaterial
        The first layer of the leaves' stack is the space between them and the soil, whose stack takes the place of all
        below.

    Raises
    ------
    InputError
        There is no leaf area, or leaves or soil are snow, let sunlight in, or are open canopies themselves.
    """

    leaf_area: float
    leaves: SurfaceMaterial
    soil: SurfaceMaterial

    def __post_init__(self) -> None:
        if not 0 < self.leaf_area < np.inf:
            raise InputError(f"found a leaf area of {self.leaf_area:g}; allowed: above 0, in m2 of leaf a m2 of ground")
        for part in (self.leaves, self.soil):
            if part.surface.snow or part.thermal.light or part.canopy is not None:
                raise InputError(
                    f"found '{part.name}' in a canopy; allowed: leaves and soil that do not melt, let no sunlight in"
                    " and have no gaps themselves; choose another soil"
                )
