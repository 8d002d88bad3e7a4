"""The radiance of one pixel; equation numbers are those of DSTO-TN-0193."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .axis import Floats, SceneError
from .database import Database
from .layouts import CODES, FACE, GLOW, GROUND, LIGHT
from .shade import absorbed_change, temperature_under
from .texture import Texture
from .walls import hide_sky

SHADED_SKY = 0.5  # open share of the sky above what lies in the shade, where the scene says nothing else


def unit(vector: Sequence[float]) -> Floats:
    """A direction of length 1."""
    parts: Floats = np.asarray(vector, float)
    length = float(np.linalg.norm(parts))
    if parts.shape != (3,) or not math.isfinite(length) or length == 0:
        raise SceneError("a direction must be three finite numbers that are not all 0")
    direction: Floats = parts / length
    return direction


def scattering_angle(elevation: float, source_elevation: float, azimuth: float) -> float:
    """Angle between line of sight and source, all in degree."""
    line, source = math.radians(elevation), math.radians(source_elevation)
    half = (
        math.sin((line - source) / 2) ** 2
        + math.cos(line) * math.cos(source) * math.sin(math.radians(azimuth) / 2) ** 2
    )
    return 2 * math.degrees(math.asin(math.sqrt(min(max(half, 0.0), 1.0))))


def lobe(normal: Floats, to_source: Floats, to_observer: Floats, shininess: float) -> float:
    """Equations (37) and (38): chi of the half vector to the power of the shininess."""
    between = to_source + to_observer
    length = float(np.linalg.norm(between))
    chi = max(float(between @ normal) / length, 0.0) if length > 0 else 0.0
    return float(min(chi, 1.0) ** shininess)


def temperature_of(surface: Database, face: dict[str, float], given: dict[str, Any]) -> float:
    """Temperature of the table, or with the heat or the surroundings that the pixel has."""
    if given.get("surroundings"):
        return temperature_under(surface, face, absorbed_change(surface, face, given["surroundings"]))
    if given.get("absorbed_change"):
        return temperature_under(surface, face, given["absorbed_change"])
    return surface.value("temperature", face)


def temperature_in_shade(surface: Database, face: dict[str, float], given: dict[str, Any], open_sky: float) -> float:
    """Temperature of what lies in the shade all day, with the surroundings that the pixel has."""
    if given.get("absorbed_change") and not given.get("surroundings"):
        raise SceneError("a texel in the shade takes 'surroundings' in place of 'absorbed_change'")
    around = given.get("surroundings") or {}
    view = min(around.get("sky_view", 1.0), open_sky)
    heat = absorbed_change(surface, face, around | {"shade": [(0.0, 24.0)], "sky_view": view})
    return temperature_under(surface, face, heat)


def irradiance_harmonics(x: float, y: float, z: float) -> tuple[float, ...]:
    """A_l / pi times Y_lm of a unit normal, in the order of the codes."""
    even = x * x - y * y
    return (
        0.28209479177387814,
        0.32573500793527993 * z,
        0.32573500793527993 * x,
        0.15769578262626002 * (3 * z * z - 1) / 2,
        0.2731371076480198 * x * z,
        0.1365685538240099 * even,
        -0.03526184897173477 * (35 * z**4 - 30 * z * z + 3) / 8,
        -0.0557538786297741 * x * z * (7 * z * z - 3) / 2,
        -0.039423945656565 * even * (7 * z * z - 1) / 2,
        -0.14751089748166088 * x * z * (x * x - 3 * y * y) / 2,
        -0.026076488977049006 * (even * even - 4 * x * x * y * y),
    )


def ambient(
    air: Database, where: Mapping[str, float], face: Mapping[str, float], ground: tuple[float, float]
) -> Floats:
    """L_ambient of a face, as `Database.light`: slope, and azimuth from that of the source, in degree; temperature of
    the ground and the radiance that it emits.
    """
    level = air.light("ambient_radiance", where)
    slope, turn = math.radians(face["slope"]), math.radians(face["azimuth"])
    normal = math.sin(slope) * math.cos(turn), math.sin(slope) * math.sin(turn), math.cos(slope)
    facing, upright, square = irradiance_harmonics(*normal), irradiance_harmonics(0.0, 0.0, 1.0), normal[2] ** 2
    codes = air.codes_of(LIGHT)
    total = [air.light(LIGHT, {**where, "harmonic": code}) for code in codes]
    for code in air.codes_of(GLOW):
        place = {**where, "ground_temperature": ground[0], "zonal_harmonic": code}
        total[CODES["harmonic"].index(int(code))] += ground[1] * air.light(GLOW, place)
    missing = level - sum(part * up for part, up in zip(total, upright, strict=False))
    if codes.size == 6:
        share = (35 * square**2 - 30 * square + 3) / 8
    else:
        share = (231 * square**3 - 315 * square**2 + 105 * square - 5) / 16
    return np.maximum(sum(part * at for part, at in zip(total, facing, strict=False)) + missing * share, 0.0)


def ambient_of_pixel(
    surface: Database, band: Database, air: Database, centre: Mapping[str, float], given: dict[str, Any]
) -> Floats:
    """L_ambient of a pixel's face, as `Database.light`; of a level one where the file or the pixel says no more."""
    if not air.ground or "source_heading" not in given:
        return air.light("ambient_radiance", centre)
    emissivity, temperature, radiance = (air.ground[name] for name in GROUND)
    if "ground_material" in given:
        place = {"material": band.material(given["ground_material"]), "azimuth": 0.0, "slope": 0.0}
        temperature = surface.value(
            "temperature", {**place, "altitude": given["surface_altitude"], "time": given["time"]}
        )
        radiance = emissivity * band.value("blackbody_radiance", {"temperature": temperature})
    face = {"slope": given["surface_slope"], "azimuth": given["surface_azimuth"] - given["source_heading"]}
    return ambient(air, centre, face, (temperature, radiance))


def reflectance_and_emission(band: Database, code: float, temperature: float, *, parted: bool) -> tuple[Floats, Floats]:
    """Reflectance of a material, and the share in what a black body emits, at each wavelength or in the whole band."""
    if not parted:
        return np.array([band.value("reflectance", {"material": code})]), np.ones(1)
    emission = band.spectrum("emission_share", {"planck_temperature": temperature})
    return band.spectrum("reflectance_spectrum", {"material": code}), emission


def with_source(surface: Database, air: Database, given: dict[str, Any]) -> dict[str, Any]:
    """The pixel with the source from the tracks of the surface file, where it does not say where the source is."""
    if "source_elevation" in given:
        return given
    if "sun_elevation" not in surface.arrays:
        raise SceneError("the surface file holds no tracks of Sun and Moon")
    source = "moon" if air.filetype == "lunar_atmq" else "sun"
    elevation, azimuth = (
        surface.value(f"{source}_{angle}", {"track_time": given["time"]}) for angle in ("elevation", "azimuth")
    )
    up, turn = math.radians(elevation), math.radians(azimuth)
    place = {
        "source_elevation": elevation,
        "source_azimuth": azimuth - given["line_heading"],
        "source_heading": azimuth,
        "to_source": [math.cos(up) * math.sin(turn), math.cos(up) * math.cos(turn), math.sin(up)],
    }
    return place | given


def materials_of(
    band: Database, texture: Texture | None, given: dict[str, Any]
) -> tuple[list[tuple[float, float]], float]:
    """Codes and shares of the materials that the pixel sees, and its share in the shade: of a texel, or of one
    material.
    """
    if "texel" not in given:
        return [(band.material(given["material"]), 1.0)], 0.0
    if texture is None:
        raise SceneError("the scene lacks 'texture'")
    across, down = given["texel"]
    place = float(across), float(down), int(given.get("level", 0))
    return texture.mixture(*place), texture.shade(*place)


def open_share(pixel: dict[str, Any], name: str, default: float) -> float:
    """A share of the sky."""
    share = float(pixel.get(name, default))
    if not 0 <= share <= 1:
        raise SceneError(f"{name}: found {share:g}; allowed: 0 to 1")
    return share


def pixel(
    scene: dict[str, Any],
    surface: Database,
    band: Database,
    air: Database,
    texture: Texture | None,
    given: dict[str, Any],
) -> dict[str, float]:
    """Equations (1) to (44) for one pixel."""
    given = with_source(surface, air, given)
    centre = {name: given[f"centre_{name}"] for name in ("range", "elevation")} | {
        name: given[name] for name in ("altitude", "source_elevation", "source_azimuth")
    }
    centre["scattering_angle"] = scattering_angle(
        *(centre[name] for name in ("elevation", "source_elevation", "source_azimuth"))
    )
    beta = air.value("beta_star", centre)
    depth = 5.5 * given["range"] / beta
    tau = math.exp(-depth)  # (9)
    materials, shade = materials_of(band, texture, given)
    own = open_share(given, "sky_view", 1.0)
    under = min(own, open_share(scene, "shaded_sky", SHADED_SKY))
    sky = ambient_of_pixel(surface, band, air, centre, given)
    if (hidden := 1 - own + shade * (own - under)) > 0:
        sky = hide_sky(surface, band, air, centre, given, hidden, sky)
    normal, to_source, to_observer = (unit(given[name]) for name in ("normal", "to_source", "to_observer"))
    incidence = max(float(normal @ to_source), 0.0)
    beam = air.light("direct_radiance", centre) if incidence > 0 else np.zeros(sky.size)
    through = air.transmittance(centre, given["range"])
    sums = dict.fromkeys(("temperature", "blackbody_radiance", "thermal", "skyshine", "diffuse", "specular"), 0.0)
    for code, share in materials:
        face = {name: given[f"surface_{name}"] for name in FACE[1:-1]} | {"material": code, "time": given["time"]}
        parts = [(share * (1 - shade), temperature_of(surface, face, given))]
        if shade > 0:
            parts.append((share * shade, temperature_in_shade(surface, face, given, under)))
        for part, temperature in parts:
            rho, emission = reflectance_and_emission(band, code, temperature, parted=air.parted)
            blackbody = band.value("blackbody_radiance", {"temperature": temperature})  # (7)
            sums["temperature"] += part * temperature
            sums["blackbody_radiance"] += part * blackbody
            sums["thermal"] += part * blackbody * float(((1.0 - rho) * emission) @ through)  # (5), or (6)
        fraction, shininess, normalisation = (
            band.value(name, {"material": code}) for name in ("specular_fraction", "shininess", "normalisation")
        )
        direct = max(float(rho @ beam), 0.0) * tau * (1 - shade)
        sums["skyshine"] += share * max(float(rho @ sky), 0.0) * tau  # (18), or (19)
        sums["diffuse"] += share * direct * incidence * (1.0 - fraction)  # (34)
        shape = lobe(normal, to_source, to_observer, shininess)
        sums["specular"] += share * direct * shape * fraction * normalisation  # (35)
    path = air.value("path_radiance_ratio", centre) * -math.expm1(-depth)  # (11)
    radiance = sums["diffuse"] + sums["specular"] + sums["skyshine"] + sums["thermal"] + path  # (1)
    others = {"material": materials[0][0], "beta_star": beta, "transmittance": tau, "path": path}
    return sums | others | {"radiance": radiance, "pixel_value": pixel_value(radiance, scene)}


def pixel_value(radiance: float, scene: dict[str, Any]) -> int:
    """Equation (44), rounded to the nearest integer: the nearest to x - 1/2, halves upwards, is the floor of x."""
    size = int(2 ** scene["bits"])
    share = min(max(radiance / scene["gain"], 0.0), 1.0)
    value: int = math.floor(size * scene["buffer_gain"] * (share - scene["offset"]))
    return min(max(value, 0), size - 1)
