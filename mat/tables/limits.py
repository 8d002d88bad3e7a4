"""The range that each stored quantity may take, whatever job it is from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.quantities.formulas import BETA_CAP_KM
from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import StrPath

ROUNDING = 1e-5  # relative, of what was computed in double and is stored in single precision
COLDEST_K, HOTTEST_K = 50.0, 2000.0  # limits of what a material may rest on, `materials.files.Kelvin`


@dataclass(frozen=True)
class Limits:
    """A range of values.

    Attributes
    ----------
    words : str
        What a value must do, for messages.
    above : bool
        Whether `low` itself is outside.
    """

    words: str
    low: float = 0.0
    high: float = np.inf
    above: bool = False

    def outside(self, values: npt.NDArray[np.number]) -> npt.NDArray[np.bool_]:
        """Which values lie outside; NaN does."""
        inside: npt.NDArray[np.bool_] = (values > self.low if self.above else values >= self.low) & (
            values <= self.high
        )
        return ~inside


_SHARE = Limits("lie in 0 to 1", 0.0, 1.0)
_PARTS = Limits("lie in 0 to 1", 0.0, 1.0 + ROUNDING)
_NOT_NEGATIVE = Limits("lie at 0 or above")
_POSITIVE = Limits("lie above 0", above=True)
_BETA = Limits(
    f"give a transmittance above 0 and up to 1 (beta* in 0 to {BETA_CAP_KM:g} km)",
    0.0,
    BETA_CAP_KM * (1 + ROUNDING),
    above=True,
)
_ELEVATION = Limits("lie in -90 to 90 degree", -90.0, 90.0)
_AZIMUTH = Limits("lie in -1080 to 1080 degree", -1080.0, 1080.0)  # a day and a half, without jumps
LIMITS: dict[str, Limits] = {
    "temperature": Limits(f"lie in {COLDEST_K:g} to {HOTTEST_K:g} K", COLDEST_K, HOTTEST_K),
    "beta_star": _BETA,
    "path_radiance_ratio": _NOT_NEGATIVE,
    "ambient_radiance": _NOT_NEGATIVE,
    "direct_radiance": _NOT_NEGATIVE,
    "blackbody_radiance": _NOT_NEGATIVE,
    "response": _SHARE,
    "reflectance": _SHARE,
    "reflectance_planck": _SHARE,
    "reflectance_solar": _SHARE,
    "emissivity": _SHARE,
    "emissivity_planck": _SHARE,
    "specular_fraction": _SHARE,
    "shininess": _POSITIVE,
    "lobe_fwhm": _POSITIVE,
    "normalisation": _POSITIVE,
    "normalisation_by_angle": _NOT_NEGATIVE,
    "response_temperature": _NOT_NEGATIVE,
    "heat_loss_slope": _POSITIVE,
    "solar_absorptance": _SHARE,
    "thermal_emissivity": _SHARE,
    "melting_heat": _NOT_NEGATIVE,
    "absorbed_sunlight": _NOT_NEGATIVE,
    "film_capacity": _NOT_NEGATIVE,
    "film_before": _NOT_NEGATIVE,
    "rain": _NOT_NEGATIVE,
    "highest_temperature": _POSITIVE,
    "direct_normal_irradiance": _NOT_NEGATIVE,
    "diffuse_irradiance": _NOT_NEGATIVE,
    "sky_irradiance": _NOT_NEGATIVE,
    "air_temperature": _POSITIVE,
    "aureole_share": _SHARE,
    "solar_elevation": _ELEVATION,
    "solar_azimuth": Limits("lie in -360 to 360 degree", -360.0, 360.0),
    "sun_elevation": _ELEVATION,
    "sun_azimuth": _AZIMUTH,
    "sun_distance": Limits("lie in 0.9 to 1.1 au", 0.9, 1.1),
    "moon_elevation": _ELEVATION,
    "moon_azimuth": _AZIMUTH,
    "moon_distance": Limits("lie in 300,000 to 450,000 km", 3e5, 4.5e5),
    "moon_phase_angle": Limits("lie in 0 to 180 degree", 0.0, 180.0),
    "moon_illuminated_fraction": _SHARE,
    "effective_radius": _POSITIVE,
    "log_mean_extinction": Limits("lie in -200 to 200", -200.0, 200.0),
    "channel_wavenumber": _POSITIVE,
    "end_rise": Limits("lie in -1 to 1", -1.0, 1.0),
    "thermal_wavelength_share": _PARTS,
    "source_wavelength_share": _PARTS,
    "emission_share": _PARTS,
    "reflectance_spectrum": _SHARE,
    "channel_weight": _PARTS,
    "thermal_reference": _NOT_NEGATIVE,
    "thermal_ratio": _NOT_NEGATIVE,
    "source_reference": _NOT_NEGATIVE,
    "source_rise": _ELEVATION,
    "ground_emission": _NOT_NEGATIVE,
}


def refuse_values(path: StrPath, name: str, values: npt.NDArray[np.number]) -> None:
    """Refuse an array with values that no database may contain.

    Parameters
    ----------
    path : path
        Named in messages.
    name : str
        Name of the array in the file, with its groups.

    Raises
    ------
    InputError
        A value of a quantity is not finite or outside its `LIMITS`. Stated errors may be unknown, as NaN.
    """
    name = name.lstrip("/")
    if values.dtype.kind != "f" or "accuracy/" in name:
        return
    if not np.isfinite(values).all():
        raise InputError(f"'{name}' contains values that are not finite; build the file again", file=path)
    limits = LIMITS.get(name.removeprefix("grid/"))
    if limits is not None and limits.outside(values).any():
        raise InputError(f"'{name}' contains values that do not {limits.words}; build the file again", file=path)
