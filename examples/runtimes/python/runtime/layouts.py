"""What files of each type must hold, and how their axes are read."""

from __future__ import annotations

import math
from collections.abc import Sequence

FACE = ("material", "altitude", "azimuth", "slope", "time")
PATH = ("range", "altitude", "elevation", "source_elevation", "source_azimuth")
MATERIAL = ("material",)
RESPONSE = ("material", "response_altitude", "response_slope", "response_hour")
OVERHEAD = ("altitude", "forcing_time")
FORMATS = {"htt": ("1.",), "band": ("1.",), "atmq": ("2.", "3.")}
Layouts = dict[str, tuple[Sequence[str], float, float]]
# What a file must hold: axes, least and largest value of each array.
ARRAYS: dict[str, Layouts] = {
    "htt": {"temperature": (FACE, 1.0, 1e4)},
    "band": {
        "blackbody_radiance": (("temperature",), 0.0, math.inf),
        "reflectance": (MATERIAL, 0.0, 1.0),
        "specular_fraction": (MATERIAL, 0.0, 1.0),
        "shininess": (MATERIAL, 0.0, math.inf),
        "normalisation": (MATERIAL, 0.0, math.inf),
    },
    "atmq": {
        "beta_star": (PATH[:3], 1e-12, math.inf),
        "path_radiance_ratio": (PATH, 0.0, math.inf),
        "ambient_radiance": (PATH[:4], 0.0, math.inf),
        "direct_radiance": (PATH[:4], 0.0, math.inf),
    },
}
# What an .htt that holds the first of them must hold, to shade surfaces.
SHADE: Layouts = {
    "response_kernel": ((*RESPONSE, "lag"), -math.inf, math.inf),
    "response_temperature": (RESPONSE, 0.0, 1e4),
    "heat_loss_slope": (RESPONSE, 1e-6, math.inf),
    "heat_loss_excess": ((*RESPONSE, "temperature_offset"), -math.inf, math.inf),
    "solar_absorptance": (MATERIAL, 0.0, 1.0),
    "thermal_emissivity": (MATERIAL, 0.0, 1.0),
    "melting_heat": (RESPONSE, 0.0, math.inf),
    "highest_temperature": (MATERIAL, 1.0, 1e4),
    "direct_normal_irradiance": (OVERHEAD, 0.0, math.inf),
    "diffuse_irradiance": (OVERHEAD, 0.0, math.inf),
    "sky_irradiance": (OVERHEAD, 0.0, math.inf),
    "air_temperature": (OVERHEAD, 1.0, 1e4),
    "solar_elevation": (("forcing_time",), -90.0, 90.0),
    "solar_azimuth": (("forcing_time",), -360.0, 360.0),
    "extraterrestrial_irradiance": (("forcing_time",), 1e-6, math.inf),
}
# Of an .htt that holds the first of them: films of water on surfaces, which last longer in the shade.
FILM: Layouts = {
    "film_heat_loss": ((*RESPONSE, "temperature_offset"), -math.inf, math.inf),
    "film_evaporation": ((*RESPONSE, "temperature_offset"), -math.inf, math.inf),
    "film_sunlight": (RESPONSE, -math.inf, math.inf),
    "absorbed_sunlight": (RESPONSE, 0.0, math.inf),
    "film_capacity": (MATERIAL, 0.0, math.inf),
    "rain": (("forcing_time",), 0.0, math.inf),
}
# Of an .htt whose day does not repeat.
FILM_BEFORE: Layouts = {"film_before": (RESPONSE[:3], 0.0, math.inf)}
# Of an .htt that holds the first of them: where Sun and Moon stand.
TRACKS: Layouts = {
    "sun_elevation": (("track_time",), -90.0, 90.0),
    "sun_azimuth": (("track_time",), -1080.0, 1080.0),
    "sun_distance": (("track_time",), 0.9, 1.1),
    "moon_elevation": (("track_time",), -90.0, 90.0),
    "moon_azimuth": (("track_time",), -1080.0, 1080.0),
    "moon_distance": (("track_time",), 3e5, 4.5e5),
    "moon_phase_angle": (("track_time",), 0.0, 180.0),
    "moon_illuminated_fraction": (("track_time",), 0.0, 1.0),
}
# Of an .atmq file that has them: coefficients of the light around faces of any direction.
LIGHT, GLOW = "ambient_radiance_harmonics", "ground_radiance_harmonics"
HARMONICS: Layouts = {
    LIGHT: ((*PATH[:4], "harmonic"), -math.inf, math.inf),
    GLOW: ((*PATH[:3], "ground_temperature", "zonal_harmonic"), -math.inf, math.inf),
}
# Of an .atmq that holds the first of them: its quantities without the source.
NIGHT: Layouts = {
    "thermal_path_radiance_ratio": (PATH[:3], 0.0, math.inf),
    "thermal_ambient_radiance": (PATH[:3], 0.0, math.inf),
}
NIGHT_HARMONICS: Layouts = {"thermal_radiance_harmonics": ((*PATH[:3], "harmonic"), -math.inf, math.inf)}
# Of an .atmq of format 3: what transmittance, path radiance and light on surfaces are computed from.
NODES = ("share", "height_root", "direction")
CHANNELS: Layouts = {
    "effective_radius": (("height_root",), 1e-3, math.inf),
    "log_mean_extinction": (("absorber", *NODES), -200.0, 200.0),
    "absorber_factor": (("channel", "absorber"), -math.inf, math.inf),
    "channel_weight": (("channel",), 0.0, 1.00001),
    "thermal_reference": (("channel",), 0.0, math.inf),
    "thermal_ratio": (NODES, 0.0, math.inf),
    "source_reference": (("channel",), 0.0, math.inf),
    "scattered_ratio": (("source_part", *NODES), 0.0, math.inf),
    "source_factor": (("source_part", "source_elevation", "scattering_angle"), -math.inf, math.inf),
    "source_rise": (("target_height",), -90.0, 90.0),
    "direct_light": (("direct_light_part", "target_height", "elevation_above_rise"), -math.inf, math.inf),
    "direct_light_factor": (("channel", "direct_light_part"), -math.inf, math.inf),
    "thermal_sky": (("thermal_sky_part", "surface_height"), -math.inf, math.inf),
    "thermal_sky_factor": (("channel", "thermal_sky_part"), -math.inf, math.inf),
    "scattered_sky": (("scattered_sky_part", "surface_height", "sky_source_elevation"), -math.inf, math.inf),
    "scattered_sky_factor": (("channel", "scattered_sky_part"), -math.inf, math.inf),
}
# Of one that holds any of them.
CHANNEL_HARMONICS: Layouts = {
    "thermal_harmonics": (("thermal_harmonics_part", "surface_height", "harmonic"), -math.inf, math.inf),
    "thermal_harmonics_factor": (("channel", "thermal_harmonics_part"), -math.inf, math.inf),
    "scattered_harmonics": (
        ("scattered_harmonics_part", "surface_height", "sky_source_elevation", "harmonic"),
        -math.inf,
        math.inf,
    ),
    "scattered_harmonics_factor": (("channel", "scattered_harmonics_part"), -math.inf, math.inf),
    "ground_harmonics": (("ground_harmonics_part", "surface_height", "zonal_harmonic"), -math.inf, math.inf),
    "ground_harmonics_factor": (("channel", "ground_harmonics_part"), -math.inf, math.inf),
    "ground_emission": (("ground_temperature", "channel"), 0.0, math.inf),
}
# Of one whose paths refraction bends far: height of their ends above those of straight lines, over the range.
CHANNEL_BENDING: Layouts = {"end_rise": (("share", "height_root", "direction"), -1.0, 1.0)}
# Of one that holds either of them, and of a .band that does: what light is parted with at the wavelengths of the band.
WAVELENGTH = "band_wavelength"
CHANNEL_SHARES: Layouts = {
    "thermal_wavelength_share": (("channel", WAVELENGTH), 0.0, 1.00001),
    "source_wavelength_share": (("channel", WAVELENGTH), 0.0, 1.00001),
}
SPECTRA: Layouts = {
    "reflectance_spectrum": ((*MATERIAL, WAVELENGTH), 0.0, 1.0),
    "emission_share": (("planck_temperature", WAVELENGTH), 0.0, 1.00001),
}
# Arrays whose rows sum to 1.
SHARES = (*CHANNEL_SHARES, "emission_share")
WAVELENGTH_ROUNDING = 1e-6  # relative: the files of one band have the same wavelengths
# What it must state: how many numbers, the least and the largest.
STATED = {
    "ground_altitude_km": (1, -1.0, 10.0),
    "scale_height_km": (1, 1e-12, 1000.0),
    "range_km": (2, 0.0, 1e9),
    "altitude_km": (2, -1.0, 1e9),
}
WEIGHT_ROUNDING = 1e-5  # of the sum of the channels' weights, and of a row of shares, which is 1
# Read at the nearest node outside, whatever the file says.
CLAMPED = (*NODES, "surface_height", "target_height", "elevation_above_rise", "planck_temperature")
WITHOUT_SOURCE = {
    "path_radiance_ratio": "thermal_path_radiance_ratio",
    "ambient_radiance": "thermal_ambient_radiance",
    "direct_radiance": "",
    LIGHT: "thermal_radiance_harmonics",
}
CIVIL_TWILIGHT = -6.0  # degree: a table whose lowest source elevation is above says nothing of twilight
# Codes 10 l + m of the harmonics, and of those without azimuth; a file has as many as suit its l.
CODES = {"harmonic": (0, 10, 11, 20, 21, 22, 40, 41, 42, 43, 44), "zonal_harmonic": (0, 10, 20, 40)}
COUNTS = {"harmonic": (6, 11), "zonal_harmonic": (3, 4)}
GROUND = ("ground_emissivity", "ground_temperature", "ground_radiance")
# How the format reads an axis: rules and period; others are linear and do not repeat.
RULES = {
    **dict.fromkeys(
        (
            "material",
            "channel",
            "absorber",
            *(axes[0] for axes, _, _ in (CHANNELS | CHANNEL_HARMONICS).values() if axes[0].endswith("_part")),
        ),
        (("exact",), 0.0),
    ),
    "harmonic": (("exact",), 0.0),
    "zonal_harmonic": (("exact",), 0.0),
    "azimuth": (("linear_periodic",), 360.0),
    "source_azimuth": (("linear_folded",), 360.0),
    "time": (("linear_periodic", "linear"), 24.0),
    "response_hour": (("linear_periodic",), 24.0),
    "forcing_time": (("linear_periodic",), 24.0),
}
LAST_CODE = 65535
