"""Names, axes, units and descriptions of the arrays of atmospheric databases, for their writer, reader and laws."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.tables.band import RADIANCE, WAVELENGTH
from skyshine.schemas.hdf5 import Variable
from skyshine.schemas.hdf5_digest import DIFFERENCES

NODES = ("share", "height_root", "direction")
SOURCE_ELEVATION, SKY_ELEVATION, ABOVE_RISE = "source_elevation", "sky_source_elevation", "elevation_above_rise"
SURFACE, TARGET = "surface_height", "target_height"
END_RISE = "end_rise"
THERMAL_SHARE, SOURCE_SHARE = "thermal_wavelength_share", "source_wavelength_share"
GROUND_EMISSION = "ground_emission"
NOT_READ = "channel_wavenumber"  # which a runtime does without


@dataclass(frozen=True)
class Field:
    """An array of the file: its axes, its units, and what it is."""

    dims: tuple[str, ...]
    units: str
    words: str
    comment: str = ""
    differences: tuple[str, ...] = ()  # axes along which the file has differences

    def variable(self, data: npt.NDArray[Any]) -> Variable:
        """The array with its values."""
        texts = {"comment": self.comment, DIFFERENCES: " ".join(self.differences)}
        return Variable(
            self.dims, np.asarray(data), self.units, self.words, {name: text for name, text in texts.items() if text}
        )


_SHARES = ("channel", WAVELENGTH), "1"
_LINEAR = "linear between the wavelengths, as reflectance_spectrum of the .band file; each row sums to 1"
ALWAYS = {
    "effective_radius": Field(
        ("height_root",), "km", "radius of an Earth without refraction that has the same horizon at that height"
    ),
    "log_mean_extinction": Field(
        ("absorber", *NODES),
        "1",
        "logarithm of the mean extinction of an absorber along the path, in km^-1",
        differences=NODES[:2],
    ),
    "absorber_factor": Field(("channel", "absorber"), "1", "optical depth of a channel per absorber's"),
    NOT_READ: Field(("channel",), "cm^-1", "wavenumber of the channel"),
    "channel_weight": Field(("channel",), "1", "weight in the band's transmittance"),
    "thermal_reference": Field(("channel",), RADIANCE, "black body at 288 K in the channel, with its weight"),
    "thermal_ratio": Field(NODES, "1", "thermal path radiance over that of air at 288 K", differences=NODES[:2]),
    "source_reference": Field(("channel",), "1", "the source's light in the channel, with its weight"),
    "scattered_ratio": Field(
        ("source_part", *NODES),
        RADIANCE,
        "field of scattered path radiance over sum of source_reference (1 - exp(-optical depth))",
        differences=NODES[:2],
    ),
    "source_factor": Field(
        ("source_part", SOURCE_ELEVATION, "scattering_angle"), "1", "share of each field by direction of the source"
    ),
    "source_rise": Field((TARGET,), "degree", "geometric elevation at which the source rises"),
    THERMAL_SHARE: Field(*_SHARES, "share of a wavelength in the emitted light of a channel", _LINEAR),
    SOURCE_SHARE: Field(*_SHARES, "share of a wavelength in the source's light in a channel", _LINEAR),
}
# Where the file says how refraction lowers the ends of paths.
BENT = {END_RISE: Field(NODES, "1", "height of the end of the path above that of a straight line, over the range")}
# Light on surfaces, in parts by spectrum: axes of a part.
LIGHT = {
    "direct_light": Field((TARGET, ABOVE_RISE), RADIANCE, "direct irradiance over pi, normal to the beam"),
    "thermal_sky": Field((SURFACE,), RADIANCE, "what the air emits on a level surface, over pi"),
    "scattered_sky": Field((SURFACE, SKY_ELEVATION), RADIANCE, "scattered light on a level surface, over pi"),
}
HARMONIC_LIGHT = {
    "thermal_harmonics": Field((SURFACE, "harmonic"), RADIANCE, "harmonics of what the air emits"),
    "scattered_harmonics": Field(
        (SURFACE, SKY_ELEVATION, "harmonic"), RADIANCE, "harmonics of scattered light around the surface"
    ),
    "ground_harmonics": Field((SURFACE, "zonal_harmonic"), RADIANCE, "harmonics of the transmittance to the ground"),
}
# With those harmonics.
GROUND = {GROUND_EMISSION: Field(("ground_temperature", "channel"), "cm", "emission of the ground, per unit in band")}


def parted(name: str, light: Field) -> dict[str, Field]:
    """The two arrays of light on surfaces: its parts, and the factor of each in each channel."""
    return {
        name: Field((f"{name}_part", *light.dims), light.units, light.words),
        f"{name}_factor": Field(("channel", f"{name}_part"), "1", f"of {name} in each channel"),
    }


def fields_of(*, harmonics: bool, bent: bool) -> dict[str, Field]:
    """All arrays of a file, with or without those of tilted faces and of refraction at the ends of paths."""
    fields = ALWAYS | (BENT if bent else {}) | (GROUND if harmonics else {})
    for name, light in (LIGHT | (HARMONIC_LIGHT if harmonics else {})).items():
        fields |= parted(name, light)
    return fields
