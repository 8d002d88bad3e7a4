"""Cloud and rain of a state."""

from __future__ import annotations

from typing import Annotated, Self

import pydantic
from pydantic import Field

from skyshine.mat.atmosphere.particles.cloud import DEFAULT_RADII, LARGEST_OPTICAL_DEPTH, PHASES, CloudLayer, cloud_type
from skyshine.mat.atmosphere.particles.cloud import TYPES as CLOUD_TYPES
from skyshine.mat.atmosphere.particles.rain import RATES
from skyshine.mat.job.fields import one_of
from skyshine.schemas.documents import StrictModel
from skyshine.schemas.errors import InputError


class Cloud(StrictModel):
    """A layer of cloud: one of LOWTRAN7's types, what is written beside it in its place; or all of it written out."""

    type: Annotated[str, one_of(CLOUD_TYPES)] | None = Field(
        None, description="One of LOWTRAN7's; by default all is written out."
    )
    phase: Annotated[str, one_of(PHASES)] | None = Field(
        None, description="Phase of the particles; by default that of the type, else water."
    )
    height_km: tuple[float, float] | None = Field(None, description="Base and top above the ground.")
    optical_depth: float | None = Field(None, ge=0, le=LARGEST_OPTICAL_DEPTH, description="Vertical, at 0.55 um.")
    water_path_g_m2: float | None = Field(
        None, ge=0, le=100_000, description="Liquid water or ice, in the place of optical depth."
    )
    effective_radius_um: float | None = Field(
        None,
        ge=2,
        le=100,
        description="Three quarters of volume over projected area; by default that of the type, else 10 (ice 30).",
    )

    @pydantic.model_validator(mode="after")
    def _whole(self) -> Self:
        if self.optical_depth is not None and self.water_path_g_m2 is not None:
            raise ValueError("found optical_depth and water_path_g_m2; allowed: one of them; remove the other")
        if self.type is None:
            if self.height_km is None:
                raise ValueError(
                    "found no height_km; allowed: [base, top] above the ground, or a type that has them; add it"
                )
            if self.optical_depth is None and self.water_path_g_m2 is None:
                raise ValueError(
                    "found neither optical_depth nor water_path_g_m2; allowed: one of them, or a type; add it"
                )
        self.layer()
        return self

    def layer(self) -> CloudLayer:
        """The layer in SI units.

        Raises
        ------
        ValueError
            What is written is out of range together.
        """
        typical = None if self.type is None else cloud_type(self.type)
        phase = self.phase or (typical.phase if typical else "water")
        radius, depth = DEFAULT_RADII[phase], self.optical_depth
        if typical is not None:
            radius = typical.effective_radius if typical.phase == phase else radius
            depth = typical.optical_depth if depth is None else depth
        radius = self.effective_radius_um or radius
        if self.height_km is not None:
            base, top = (1e3 * km for km in self.height_km)
        else:
            assert typical is not None  # `_whole` asks for a height without a type
            base, top = typical.base, typical.top
        try:
            layer: CloudLayer
            if self.water_path_g_m2 is not None:
                layer = CloudLayer.of_water_path(phase, base, top, radius, 1e-3 * self.water_path_g_m2)
            else:
                assert depth is not None  # `_whole` asks for one without a type
                layer = CloudLayer(phase, base, top, radius, depth)
            return layer
        except InputError as error:
            raise ValueError(error.message) from None


class Rain(StrictModel):
    """Even rain from the ground to a height."""

    rate_mm_h: float = Field(
        ge=RATES[0],
        le=RATES[1],
        description="Rate of rainfall at the ground; it sets the size of the drops (Marshall and Palmer 1948).",
    )
    top_km: float = Field(3.0, ge=0.02, le=15, description="Top of the rain above the ground.")
