"""Aerosol of a state in layers of its own, and of particles that the job describes."""

from __future__ import annotations

from typing import Annotated, Any, Self

import pydantic
from pydantic import Field

from skyshine.mat.atmosphere.particles.aerosol import MODELS
from skyshine.mat.atmosphere.particles.aerosol_column import BOUNDARY_MODELS
from skyshine.mat.atmosphere.particles.aerosol_layer import HIGHEST, LARGEST_OPTICAL_DEPTH, SCALE_HEIGHTS, THINNEST
from skyshine.mat.atmosphere.particles.aerosol_table import LARGEST_INDEX
from skyshine.mat.atmosphere.particles.size_distribution import GEOMETRIC_SDS, MEDIAN_RADII
from skyshine.mat.job.fields import one_of
from skyshine.mat.job.files import JobFile
from skyshine.schemas.documents import StrictModel

LAYER_MODELS = tuple(dict.fromkeys((*BOUNDARY_MODELS, *MODELS)))
MOST_MODES, MOST_LAYERS = 4, 8

_RealPart = Annotated[float, Field(gt=0, le=LARGEST_INDEX)]
_ImaginaryPart = Annotated[float, Field(ge=0, le=LARGEST_INDEX)]


def _number_or_file(value: Any) -> str:
    return "number" if isinstance(value, list | tuple) else "file"


Index = Annotated[
    Annotated[tuple[_RealPart, _ImaginaryPart], pydantic.Tag("number")] | Annotated[JobFile, pydantic.Tag("file")],
    pydantic.Discriminator(_number_or_file),
]


class Mode(StrictModel):
    """Spheres of one material, whose radii have a log-normal distribution."""

    median_radius_um: float = Field(
        ge=MEDIAN_RADII[0], le=MEDIAN_RADII[1], description="Median radius of the number distribution."
    )
    geometric_sd: float = Field(
        ge=GEOMETRIC_SDS[0], le=GEOMETRIC_SDS[1], description="Geometric standard deviation of the radius."
    )
    number: float = Field(1.0, gt=0, le=1e12, description="Number of particles, in a measure common to all modes.")
    refractive_index: Index = Field(
        description="[n, k] at all wavelengths, or a CSV of wavelength[um], real and imaginary."
    )


class AerosolLayer(StrictModel):
    """Aerosol of one kind over some heights, beside that of the column."""

    model: Annotated[str, one_of(LAYER_MODELS)] | None = Field(None, description="A packaged aerosol.")
    table: JobFile | None = Field(
        None, description="CSV of wavelength[um], extinction, single_scattering_albedo and asymmetry."
    )
    size_distribution: Annotated[list[Mode], Field(min_length=1, max_length=MOST_MODES)] | None = Field(
        None, description="Modes of spheres, whose optical properties follow by Mie theory."
    )
    height_km: tuple[float, float] | None = Field(None, description="Bottom and top above the ground, even between.")
    scale_height_km: float | None = Field(
        None,
        ge=SCALE_HEIGHTS[0] / 1e3,
        le=SCALE_HEIGHTS[1] / 1e3,
        description="Scale height of extinction, from the ground on.",
    )
    profile: JobFile | None = Field(
        None, description="CSV of height[km] above the ground and extinction[km^-1] at 0.55 um, linear between."
    )
    optics: JobFile | None = Field(
        None,
        description=(
            "CSV of height[km] above the ground, wavelength[um], extinction[km^-1], single_scattering_albedo and"
            " asymmetry, linear between heights; says what the particles are, where they are and how much there is."
        ),
    )
    optical_depth: float | None = Field(
        None,
        ge=0,
        le=LARGEST_OPTICAL_DEPTH,
        description="Vertical, at 0.55 um; by default, with a profile, that of the profile.",
    )

    @pydantic.model_validator(mode="after")
    def _one_of_each(self) -> Self:
        if self.optics is not None:
            others = [name for name in type(self).model_fields if name != "optics" and getattr(self, name) is not None]
            if others:
                raise ValueError(f"found optics and {' and '.join(others)}; allowed: optics alone; remove the others")
            return self
        for names, hint in (
            (("model", "table", "size_distribution"), "say what the particles are, or give optics"),
            (("height_km", "scale_height_km", "profile"), "say where they are"),
        ):
            amounts = [name for name in names if getattr(self, name) is not None]
            if len(amounts) != 1:
                allowed = ", ".join(names)
                raise ValueError(f"found {' and '.join(amounts) or 'none of them'}; allowed: one of {allowed}; {hint}")
        if self.profile is None and self.optical_depth is None:
            raise ValueError("found no optical_depth; allowed: 0 to 100, which a profile alone may leave out; add it")
        if self.height_km is not None:
            bottom, top = self.height_km
            if not (bottom >= 0 and bottom + THINNEST / 1e3 <= top <= HIGHEST / 1e3):
                raise ValueError(
                    f"found height_km [{bottom:g}, {top:g}]; allowed: a bottom of at least 0 and a top at least"
                    f" {THINNEST / 1e3:g} km higher, at most {HIGHEST / 1e3:g} km; fix them"
                )
        return self

    @property
    def particles(self) -> str:
        """Name of the particles, for files and people."""
        if self.optics is not None:
            return f"optics of {self.optics.name}"
        if self.table is not None:
            return self.table.name
        return self.model or "spheres"

    @property
    def place(self) -> str:
        """Where they are, for files and people."""
        if self.optics is not None:
            return "by height"
        if self.profile is not None:
            return f"by {self.profile.name}"
        if self.height_km is not None:
            return "{:g} to {:g} km".format(*self.height_km)
        return f"scale height {self.scale_height_km:g} km"
