"""The ``.band`` database, written and read: band-averaged data of sensor and materials that a runtime needs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.radiometry.band_wavelengths import band_wavelengths, emission_shares, reflectance_spectra
from skyshine.mat.radiometry.blackbody import SpectralResponse, band_radiance
from skyshine.mat.radiometry.lobe import SOURCE_ANGLES, normalisation, shininess
from skyshine.mat.radiometry.reflectance import band_emissivity, band_reflectance
from skyshine.mat.tables.axes import EXACT, table_axis
from skyshine.mat.tables.files import BAND
from skyshine.mat.tables.named_materials import with_names
from skyshine.mat.tables.table import Table
from skyshine.schemas.hdf5 import Axis, Group, Variable

if TYPE_CHECKING:
    from skyshine.materials.library import Material

TEMPERATURES = np.arange(150.0, 1500.25, 0.5)  # K; linear interpolation is then within 0.01 K from 3 um on
PLANCK_TEMPERATURES = np.array([200.0, 250.0, 275.0, 300.0, 325.0, 350.0, 400.0, 500.0, 700.0, 1000.0])  # K
RADIANCE = "W m^-2 sr^-1"
WAVELENGTH = "band_wavelength"  # axis of spectra that are linear between few wavelengths, here and in channels


def band_group(
    response: SpectralResponse, materials: Sequence[Material], irradiance: tuple[np.ndarray, np.ndarray]
) -> Group:
    """Compute and arrange the properties of a band.

    Parameters
    ----------
    materials : (M,) sequence of Material
        Codes ascending.
    irradiance : (wavelength, spectral irradiance)
        Spectrum of the Sun, in um and W m^-2 um^-1, for the solar-weighted reflectance.
    """
    axes = {
        "wavelength": Axis(response.wavelength, "um", "wavelength"),
        "temperature": table_axis(TEMPERATURES, "K", "temperature of a black body"),
        "material": table_axis(
            np.array([m.code for m in materials], np.int32), "1", "material code", interpolation=EXACT
        ),
        "planck_temperature": table_axis(PLANCK_TEMPERATURES, "K", "temperature of the Planck weighting"),
        "source_angle": table_axis(np.array(SOURCE_ANGLES), "degree", "angle of incidence"),
        WAVELENGTH: table_axis(band_wavelengths(response), "um", "wavelength in the band"),
    }
    variables = {
        "response": Variable(("wavelength",), response.response, "1", "sensor response, peak 1"),
        "blackbody_radiance": Variable(
            ("temperature",), band_radiance(response, TEMPERATURES), RADIANCE, "band radiance of a black body, (7)"
        ),
        "material_name": Variable(("material",), np.array([m.name for m in materials], object), "1", "material name"),
    }
    variables |= _reflectances(response, materials, irradiance) | _spectra(response, materials) | _lobes(materials)
    return Group(axes, with_names(variables))


def _reflectances(
    response: SpectralResponse, materials: Sequence[Material], irradiance: tuple[np.ndarray, np.ndarray]
) -> dict[str, Variable]:
    flat = np.array([band_reflectance(m, response, "flat") for m in materials])
    planck = np.array([band_reflectance(m, response, "planck", temperature=PLANCK_TEMPERATURES) for m in materials])
    emitted = np.array([band_emissivity(m, response, PLANCK_TEMPERATURES) for m in materials])
    solar = np.array([band_reflectance(m, response, "solar", irradiance=irradiance) for m in materials])
    per_material, per_temperature = ("material",), ("material", "planck_temperature")
    return {
        "reflectance": Variable(per_material, flat, "1", "hemispherical reflectance, flat mean over the band"),
        "reflectance_planck": Variable(per_temperature, planck, "1", "reflectance weighted by Planck radiance"),
        "reflectance_solar": Variable(per_material, solar, "1", "reflectance weighted by solar irradiance"),
        "emissivity": Variable(per_material, 1.0 - flat, "1", "1 - reflectance, the emissivity of equation (6)"),
        "emissivity_planck": Variable(
            per_temperature,
            emitted,
            "1",
            "emissivity weighted by Planck radiance; below 1 - reflectance where light passes",
        ),
    }


def _spectra(response: SpectralResponse, materials: Sequence[Material]) -> dict[str, Variable]:
    return {
        "reflectance_spectrum": Variable(
            ("material", WAVELENGTH),
            reflectance_spectra(materials, response),
            "1",
            "hemispherical reflectance, linear between the wavelengths",
        ),
        "emission_share": Variable(
            ("planck_temperature", WAVELENGTH),
            emission_shares(response, PLANCK_TEMPERATURES),
            "1",
            "share of a wavelength in blackbody_radiance; each row sums to 1",
        ),
    }


def _lobes(materials: Sequence[Material]) -> dict[str, Variable]:
    widths = np.array([m.lobe_fwhm for m in materials])
    by_angle = np.array([normalisation(width, SOURCE_ANGLES) for width in widths])
    per_material = ("material",)
    return {
        "specular_fraction": Variable(
            per_material, np.array([m.specular_fraction for m in materials]), "1", "specular share of the reflection"
        ),
        "lobe_fwhm": Variable(per_material, widths, "degree", "full width at half maximum of the specular lobe"),
        "shininess": Variable(per_material, shininess(widths), "1", "shininess, equation (42)"),
        "normalisation": Variable(per_material, by_angle.mean(axis=1), "1", "N_s, mean of (43) over source angles"),
        "normalisation_by_angle": Variable(("material", "source_angle"), by_angle, "1", "N_s by source angle, (43)"),
    }


@dataclass(frozen=True, eq=False)
class BandSpectra:
    """Spectra in a band, linear between B wavelengths.

    Attributes
    ----------
    wavelength : (B,) array
        um.
    reflectance : (..., B) array
    emission : (..., B) array
        Share of each wavelength in the radiance of a black body.
    """

    wavelength: npt.NDArray[np.float64]
    reflectance: npt.NDArray[np.float64]
    emission: npt.NDArray[np.float64]


class BandTable(Table):
    """A ``.band`` database."""

    filetypes = (BAND.name,)

    def blackbody_radiance(self, temperature: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Band radiance of a black body, equation (7), W m^-2 sr^-1, at `temperature` in kelvin."""
        return self.value("blackbody_radiance", temperature=temperature)

    def spectra(self, *, material: Any, temperature: npt.ArrayLike) -> BandSpectra:
        """Reflectance and emission by wavelength, of materials at temperatures in kelvin.

        Temperatures beyond those of the table have the shares at its ends.

        Raises
        ------
        InputError
            A material that the table lacks.
        """
        nodes = np.asarray(self.root.axes[WAVELENGTH].values, float)
        where: dict[str, Any] = {WAVELENGTH: nodes}
        codes, kelvin = self.material_codes(material)[..., None], np.asarray(temperature, float)[..., None]
        return BandSpectra(
            nodes,
            self.value("reflectance_spectrum", material=codes, **where),
            self.clamped("planck_temperature").value("emission_share", planck_temperature=kelvin, **where),
        )

    def normalisation(self, *, material: Any, angle: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """N_s of (43) at angles of incidence in degree, 0 to 75."""
        return self.value("normalisation_by_angle", material=material, source_angle=angle)
