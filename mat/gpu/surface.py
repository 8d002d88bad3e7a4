"""A ``.htt`` database as textures: temperatures of faces through the day, and their response to shade.

At 300 K half floats are .25 K apart. The textures therefore hold the difference from the level face of the same
material, altitude and time, which has a table in single precision.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from skyshine.mat.gpu.air import source_of
from skyshine.mat.gpu.container import GpuFile, Texture, texture
from skyshine.mat.tables import response, shade
from skyshine.mat.tables.axes import PERIODIC, AxisRule
from skyshine.mat.tables.surface_tables import TemperatureTable

_SCALED = (response.KERNEL, response.LOSS_SLOPE, response.LOSS_EXCESS, response.MELT)
_LIGHT = (shade.DIRECT, shade.DIFFUSE, shade.LONGWAVE, shade.AIR)
_SUN = (shade.SUN_ELEVATION, shade.SUN_AZIMUTH, shade.EXTRATERRESTRIAL)
_PER_MATERIAL = (shade.ABSORPTANCE, shade.EMISSIVITY, response.HIGHEST)
_TRACKS = ("sun_elevation", "sun_azimuth", "moon_elevation", "moon_azimuth")


def export_surface(
    surface: TemperatureTable,
    *,
    hour: float | None = None,
    level: bool = False,
    altitudes_km: Sequence[float] | None = None,
) -> GpuFile:
    """Textures of a table of temperatures.

    Parameters
    ----------
    surface : TemperatureTable
    hour : float, optional
        Local clock [h]: with it the textures are those of one frame.
    level : bool
        Level faces alone.
    altitudes_km : sequence of float, optional
        Of the surface, ascending; by default those of the table.
    """
    axes = surface.root.axes
    codes = np.asarray(axes["material"].values)
    altitudes = np.asarray(axes["altitude"].values if altitudes_km is None else altitudes_km, float)
    azimuths, slopes = (np.asarray(axes[name].values, float) for name in ("azimuth", "slope"))
    azimuths, slopes = (azimuths[:1], slopes[:1] * 0.0) if level else (azimuths, slopes)
    repeats = AxisRule.of("azimuth", axes["azimuth"]).interpolation == PERIODIC and azimuths.size > 1
    wide = np.append(azimuths, azimuths[0] + 360.0) if repeats else azimuths
    clock = AxisRule.of("time", axes["time"])
    times = np.asarray(clock.nodes, float) if hour is None else np.array([hour])
    reference = surface.temperature(
        material=codes[:, None, None], altitude=altitudes[:, None], azimuth=azimuths[0], slope=slopes[0], time=times
    )
    layers = np.empty((times.size, codes.size, altitudes.size, slopes.size, wide.size), np.float16)
    largest = 0.0
    for place, time in enumerate(times):  # one time after the other keeps memory small
        temperature = surface.temperature(
            material=codes[:, None, None, None],
            altitude=altitudes[:, None, None],
            slope=slopes[:, None],
            azimuth=np.mod(wide, 360.0) if repeats else wide,
            time=float(time),
        )
        above = temperature - reference[..., place][..., None, None]
        layers[place] = above
        largest = max(largest, float(np.abs(layers[place].astype(float) - above).max()))
    textures = {
        "temperature": texture(
            "R16F",
            layers.reshape(-1, slopes.size, wide.size),
            "temperature above the reference, K; layers by time, material and altitude, rows by slope, columns by"
            " azimuth",
        ),
        "reference": texture(
            "R32F",
            np.moveaxis(reference, -1, 0).reshape(times.size, -1),
            "temperature of the first slope and azimuth, K; rows by time, columns by material and altitude",
        ),
    }
    numbers: dict[str, Any] = {
        "material": [int(code) for code in codes],
        "material_name": list(surface.materials),
        "altitude": altitudes.tolist(),
        "azimuth": wide.tolist(),
        "azimuth_repeats": bool(repeats),
        "slope": slopes.tolist(),
        "time": times.tolist(),
        "time_repeats": clock.interpolation == PERIODIC,
        "scale": {},
    }
    if "track_time" in axes:
        track = np.asarray(axes["track_time"].values, float)
        numbers["track_time"] = track.tolist()
        angles = [np.asarray(surface.root.variables[name].data, float) for name in _TRACKS]
        textures["tracks"] = texture(
            "RGBA32F", np.stack(angles, -1)[None], ", ".join(_TRACKS) + ", degree; by track_time"
        )
    if response.KERNEL in surface.root.variables and not level:
        _add_response(surface, textures, numbers)
    stated = {"units": "K", "largest": largest, "of": "temperature"}
    return GpuFile("surface", source_of(surface.path.name, surface.attributes), textures, numbers, stated)


def _add_response(surface: TemperatureTable, textures: dict[str, Texture], numbers: dict[str, Any]) -> None:
    """Arrays by which a runtime shades objects: those of the format, scaled to their largest value as half floats."""
    root = surface.root
    for name in _SCALED:
        data = np.asarray(root.variables[name].data, float)
        scale = float(np.abs(data).max()) or 1.0
        numbers["scale"][name] = scale
        texels = (data / scale).reshape(-1, *data.shape[-2:])
        textures[name] = texture("R16F", texels, f"{root.variables[name].long_name}; times its scale")
    for name in (response.REFERENCE,):
        data = np.asarray(root.variables[name].data, float)
        textures[name] = texture("R32F", data.reshape(-1, *data.shape[-2:]), root.variables[name].long_name)
    sky = np.stack([np.asarray(root.variables[name].data, float) for name in _LIGHT], -1)
    textures["light"] = texture("RGBA32F", sky, ", ".join(_LIGHT) + "; rows by altitude, columns by forcing_time")
    sun = [np.asarray(root.variables[name].data, float) for name in _SUN]
    textures["sun"] = texture(
        "RGBA32F", np.stack([*sun, sun[0] * 0], -1)[None], ", ".join(_SUN) + ", 0; by forcing_time"
    )
    own = [np.asarray(root.variables[name].data, float) for name in _PER_MATERIAL]
    textures["response_material"] = texture(
        "RGBA32F", np.stack([*own, own[0] * 0], -1)[:, None], ", ".join(_PER_MATERIAL) + ", 0; by material"
    )
    for axis in (response.ALTITUDE, response.SLOPE, response.HOUR, response.LAG, response.OFFSET, shade.FORCING_TIME):
        numbers[axis] = np.asarray(root.axes[axis].values, float).tolist()
