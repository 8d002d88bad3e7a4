"""The data of a material, as frozen records in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Layer:
    """A homogeneous conducting layer.

    Attributes
    ----------
    thickness : float
        [m]
    conductivity : float
        [W m^-1 K^-1]
    density : float
        [kg m^-3]
    heat_capacity : float
        [J kg^-1 K^-1]
    """

    thickness: float
    conductivity: float
    density: float
    heat_capacity: float


@dataclass(frozen=True)
class Back:
    """What the stack rests on.

    Attributes
    ----------
    kind : str
        "adiabatic" (no flux), "fixed" (a temperature), "convective" (a coefficient to an air temperature), "open" (a
        coefficient to the outdoor air of the hour), "cavity" (a coefficient to enclosed air that floats) or "heated" (a
        heat flux from inside).
    temperature : float, tuple of 24 floats or None
        [K], of the day or at local clock hours 0 to 23, linear between them; None is the day's mean air temperature
        temperature. Only fixed and convective.
    coefficient : float or None
        [W m^-2 K^-1]; convective, open and cavity.
    heat_flux : float, tuple of 24 floats or None
        Into the stack from behind, or into the cavity [W m^-2], by hour as the temperature; heated, and cavity by
        choice.
    exchange : float or None
        Heat exchange of the enclosed air with the outdoor air, by ventilation and through the other surfaces, per area
        of this surface [W m^-2 K^-1]; cavity only.
    capacity : float or None
        Heat capacity of the enclosed air and its contents [J m^-2 K^-1]; cavity only.
    """

    kind: str
    temperature: float | tuple[float, ...] | None = None
    coefficient: float | None = None
    heat_flux: float | tuple[float, ...] | None = None
    exchange: float | None = None
    capacity: float | None = None


@dataclass(frozen=True)
class PenetratingLight:
    """Sunlight that is absorbed within the layers, less with depth by one exponential law.

    Attributes
    ----------
    share : float
        Share of all absorbed sunlight.
    extinction : float
        [1/m]
    """

    share: float
    extinction: float


@dataclass(frozen=True)
class ThermalStack:
    """A surface skin over two conducting layers and a back boundary.

    Attributes
    ----------
    skin : Layer
        Stores heat at the surface temperature; its own conduction is neglected.
    layers : tuple of Layer
        Layers from the skin inwards: two of the library, one more or two under snow.
    back : Back
    light : tuple of PenetratingLight
        Sunlight that the layers let in; the rest is absorbed at the surface.
    """

    skin: Layer
    layers: tuple[Layer, ...]
    back: Back
    light: tuple[PenetratingLight, ...] = ()


@dataclass(frozen=True)
class SurfaceProperties:
    """How a surface exchanges heat and water with the air.

    Attributes
    ----------
    roughness_length : float
        Roughness length for momentum [m].
    wetness : float
        Fraction of the surface that evaporates, 0 to 1.
    surface_resistance : float
        Resistance to evaporation in series with the aerodynamic one [s m^-1]; 0 for free water. For a canopy the
        minimum, in full light and humid air of 25 C.
    canopy : bool
        Vegetation whose leaves exchange with the air within the canopy.
    snow : bool
        Temperature cannot exceed the melting point.
    exposure : str
        How wind reaches it: "field" (endless ground or canopy), "plate" (an object on open ground), "roof" or "wall"
        (of a building).
    delivered : float
        Share of the sunlight on it that leaves as electric power at 25 C, 0 to 1.
    delivered_per_kelvin : float
        Relative change of that share with temperature [K^-1].
    """

    roughness_length: float
    wetness: float
    surface_resistance: float
    canopy: bool
    snow: bool
    exposure: str = "field"
    delivered: float = 0.0
    delivered_per_kelvin: float = 0.0


@dataclass(frozen=True)
class Soil:
    """What a material with pores, dry in the library, needs to say what water in them changes.

    Attributes
    ----------
    texture : str
        "gravel" (and coarse sand), "sand", "sandy_loam", "loam", "silt", "clay" or "organic".
    porosity : float
        Share of the volume that is pores.
    solid_conductivity : float
        Thermal conductivity of the grains [W m^-1 K^-1].
    layers : int
        1 or 2: how many layers of the stack, from the skin inwards, are of this soil.
    """

    texture: str
    porosity: float
    solid_conductivity: float
    layers: int


@dataclass(frozen=True)
class Stand:
    """Plants whose leaves a material's skin is, as far as the gaps between them tell.

    Attributes
    ----------
    leaf_area_index : float
        One-sided area of the leaves per area of ground [m^2 m^-2].
    soil : str
        Name of the material below the leaves.
    moisture : float or None
        Volume fraction of water in it where a job says nothing of that; None: as the library has it.
    clumping : float
        Share of the leaf area that leaves spread at random would need for the same gaps, 0 to 1.
    """

    leaf_area_index: float
    soil: str
    moisture: float | None = None
    clumping: float = 1.0


@dataclass(frozen=True)
class SpectralRange:
    """Where one stretch of a reflectance spectrum comes from.

    Attributes
    ----------
    lower, upper : float
        [um]
    kind : str
        "measured", "modelled" (by the source), "fresnel" (from optical constants), "proxy" (another sample
        of its kind), "constant" (a cited number), "held" (the nearest measured value) or "interpolated".
    note : str
    """

    lower: float
    upper: float
    kind: str
    note: str


@dataclass(frozen=True, eq=False)
class Material:
    """A scene material.

    Attributes
    ----------
    code : int
        1 to 65535, stable between versions of the library.
    name, description, group : str
    thermal : ThermalStack
    surface : SurfaceProperties
    wavelength : ndarray, shape (n,)
        [um], increasing.
    reflectance : ndarray, shape (n,)
        Hemispherical, 0 to 1.
    absorptance : ndarray, shape (n,)
        What heats the surface and, by Kirchhoff's law, what it emits: 1 - reflectance except where the
        material transmits.
    transmits : bool
        Whether `absorptance` differs from 1 - reflectance.
    ranges : tuple of SpectralRange
    specular_fraction : float
        Share of the reflected light in the specular lobe, 0 to 1.
    lobe_fwhm : float
        Full width of the lobe at half its maximum [degree].
    sources : dict of str to str
        Source of each number, by its field ("skin.thickness", "specular_fraction", "reflectance", ...).
    reflectance_note : str
        The comment header of the spectrum: sample, file, citation, credit, geometry.
    soil : Soil or None
        Soil of a material whose properties depend on soil moisture.
    stand : Stand or None
        Canopy of leaves over another material.
    operated : mapping of str to Back
        Backs in operation by name, which a job may choose in place of that of `thermal`.
    moisture : float or None
        Volume fraction of water that a job has put into its soil.
    dry : Material or None
        The material before that water; None where there is none.
    opened : OpenStand or None
        Canopy with gaps through which soil is visible, as a job requests; the spectra are then those of leaves and soil
        together, seen from above. None: a closed surface.
    """

    code: int
    name: str
    description: str
    group: str
    thermal: ThermalStack
    surface: SurfaceProperties
    wavelength: np.ndarray
    reflectance: np.ndarray
    absorptance: np.ndarray
    transmits: bool
    ranges: tuple[SpectralRange, ...]
    specular_fraction: float
    lobe_fwhm: float
    sources: dict[str, str]
    reflectance_note: str
    soil: Soil | None = None
    stand: Stand | None = None
    operated: Mapping[str, Back] = field(default_factory=dict)
    moisture: float | None = None
    dry: Material | None = None
    opened: OpenStand | None = None


@dataclass(frozen=True, eq=False)
class OpenStand:
    """Leaves and the soil that is seen between them.

    Attributes
    ----------
    leaf_area : float
        Leaf area index times clumping [m^2 m^-2].
    leaves, soil : Material
        Each as if alone.
    """

    leaf_area: float
    leaves: Material
    soil: Material
