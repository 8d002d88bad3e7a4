"""A ``.htt`` database as textures: temperatures of faces through the day, and their response to shade.

At 300 K half floats are 0.25 K apart. The textures therefore contain the difference from the level face of the same
material, altitude and time, which has a table in single precision.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from skyshine.mat.gpu.air import source_of
from skyshine.mat.gpu.container import GpuFile, Texture, texture
from skyshine.mat.runtime.shade import air_temperature, shaded_temperature
from skyshine.mat.tables import film_response, response, shade
from skyshine.mat.tables.axes import PERIODIC, AxisRule
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.schemas.arrays import Floats

_SCALED = (response.KERNEL, response.LOSS_SLOPE, response.LOSS_EXCESS, response.MELT)
_WET = (film_response.LOSS, film_response.EVAPORATION, film_response.SUNLIGHT, film_response.DRY_SUNLIGHT)
_LIGHT = (shade.DIRECT, shade.DIFFUSE, shade.LONGWAVE, shade.AIR)
_SUN = (shade.SUN_ELEVATION, shade.SUN_AZIMUTH, shade.AUREOLE)
_PER_MATERIAL = (shade.ABSORPTANCE, shade.EMISSIVITY, response.HIGHEST)
# Degree between nodes of temperatures in the shade, which follow the Sun's angle within the cells of the table: a slope
# of 31 degree errs by 2 K between slopes of 0 and 45 and azimuths of 90, by 0.04 K (97 % of faces) with these.
_SLOPE_STEP, _AZIMUTH_STEP = 7.5, 15.0
_TRACKS = ("sun_elevation", "sun_azimuth", "moon_elevation", "moon_azimuth")


def export_surface(
    surface: TemperatureTable,
    *,
    hour: float | None = None,
    level: bool = False,
    altitudes_km: Sequence[float] | None = None,
    shaded_sky: float | None = None,
) -> GpuFile:
    """Textures of a table of temperatures.

    Parameters
    ----------
    hour : float, optional
        Local clock [h]: with it the textures are those of one frame.
    level : bool
        Level faces alone.
    altitudes_km : sequence of float, optional
        Altitudes of the surface, ascending; by default those of the table.
    shaded_sky : float, optional
        Open share of the sky above faces in the shade all day: with it the textures contain their temperatures too.

    Raises
    ------
    InputError
        Temperatures in the shade are asked of a table without the response to it.
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
    for index, time in enumerate(times):  # one time after the other keeps memory small
        temperature = surface.temperature(
            material=codes[:, None, None, None],
            altitude=altitudes[:, None, None],
            slope=slopes[:, None],
            azimuth=np.mod(wide, 360.0) if repeats else wide,
            time=float(time),
        )
        above = temperature - reference[..., index][..., None, None]
        layers[index] = above
        largest = max(largest, float(np.abs(layers[index].astype(float) - above).max()))
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
    if shaded_sky is not None:
        columns = {
            "altitude": altitudes,
            "slope": _divided(slopes, _SLOPE_STEP),
            "azimuth": _divided(wide, _AZIMUTH_STEP),
        }
        hours = _shaded_times(clock) if hour is None else times
        error = _add_shaded(surface, columns, hours, shaded_sky, textures, numbers)
        largest = max(largest, error)
    if response.KERNEL in surface.root.variables and not level:
        _add_response(surface, textures, numbers)
    stated = {"units": "K", "largest": largest, "of": "temperature"}
    return GpuFile("surface", source_of(surface.path.name, surface.attributes), textures, numbers, stated)


def _add_shaded(
    surface: TemperatureTable,
    columns: dict[str, Floats],
    times: Floats,
    shaded_sky: float,
    textures: dict[str, Texture],
    numbers: dict[str, Any],
) -> float:
    """What faces in the shade all day have above those in the Sun, and the temperature of the air around them; returns
    the largest error of the half floats [K].
    """
    codes = np.asarray(surface.root.axes["material"].values)
    shape = codes.size, *(values.size for values in columns.values())
    material, *coordinates = (values.ravel() for values in np.meshgrid(codes, *columns.values(), indexing="ij"))
    where = dict(zip(columns, coordinates, strict=True))
    # The last azimuth may be the first one again.
    where["azimuth"] = np.where(where["azimuth"] >= 360.0, where["azimuth"] - 360.0, where["azimuth"])
    hours = np.broadcast_to(times, (material.size, times.size))
    dark = shaded_temperature(surface, material.astype(int), np.full(material.size, shaded_sky), **where, time=hours)
    grid = {name: values[:, None] for name, values in where.items()}
    change = dark - surface.temperature(material=material[:, None], **grid, time=hours)
    layers = change.T.reshape(-1, *shape[2:]).astype(np.float16)
    textures["shaded_change"] = texture(
        "R16F",
        layers,
        "temperature of a face in the shade all day above that in the Sun, K; layers by shaded_time, material and"
        " altitude, rows by shaded_slope, columns by shaded_azimuth",
    )
    numbers |= {f"shaded_{name}": columns[name].tolist() for name in ("azimuth", "slope")}
    air = air_temperature(surface, columns["altitude"], times[:, None])
    numbers |= {"shaded_sky": shaded_sky, "shaded_time": times.tolist(), "air_temperature": air.tolist()}
    return float(np.abs(layers.ravel() - change.T.ravel()).max())


def _divided(nodes: Floats, step: float) -> Floats:
    """Nodes with more between them: cells in equal parts of at most a step."""
    parts = [np.linspace(low, high, int(np.ceil((high - low) / step)), endpoint=False) for low, high in pairwise(nodes)]
    return np.concatenate([*parts, nodes[-1:]])


def _shaded_times(clock: AxisRule) -> Floats:
    """Hours between which the change of temperatures in the shade is linear: the steps of the response to it."""
    if clock.interpolation == PERIODIC:
        return response.forcing_hours()
    start, stop = clock.nodes[[0, -1]]
    steps = np.concatenate([response.forcing_hours() + day * response.DAY_H for day in (0, 1)])
    return np.unique([start, *steps[(steps > start) & (steps < stop)], stop])


def _add_response(surface: TemperatureTable, textures: dict[str, Texture], numbers: dict[str, Any]) -> None:
    """Arrays by which a runtime shades objects: those of the format, scaled to their largest value as half floats."""
    root = surface.root
    wet = film_response.LOSS in root.variables
    for name in (*_SCALED, *(_WET if wet else ())):
        data = np.asarray(root.variables[name].data, float)
        scale = float(np.abs(data).max()) or 1.0
        numbers["scale"][name] = scale
        texels = (data / scale).reshape(-1, *data.shape[-2:])
        textures[name] = texture("R16F", texels, f"{root.variables[name].long_name}; times its scale")
    for name in (response.REFERENCE, *((film_response.BEFORE,) if film_response.BEFORE in root.variables else ())):
        data = np.asarray(root.variables[name].data, float)
        textures[name] = texture("R32F", data.reshape(-1, *data.shape[-2:]), root.variables[name].long_name)
    sky = np.stack([np.asarray(root.variables[name].data, float) for name in _LIGHT], -1)
    textures["light"] = texture("RGBA32F", sky, ", ".join(_LIGHT) + "; rows by altitude, columns by forcing_time")
    sun = [np.asarray(root.variables[name].data, float) for name in _SUN]
    rain = np.asarray(root.variables[film_response.RAIN].data, float) if wet else sun[0] * 0
    textures["sun"] = texture("RGBA32F", np.stack([*sun, rain], -1)[None], ", ".join(_SUN) + ", rain; by forcing_time")
    per_material = [np.asarray(root.variables[name].data, float) for name in _PER_MATERIAL]
    water = np.asarray(root.variables[film_response.CAPACITY].data, float) if wet else per_material[0] * 0
    textures["response_material"] = texture(
        "RGBA32F",
        np.stack([*per_material, water], -1)[:, None],
        ", ".join(_PER_MATERIAL) + f", {film_response.CAPACITY}; by material",
    )
    for axis in (response.ALTITUDE, response.SLOPE, response.HOUR, response.LAG, response.OFFSET, shade.FORCING_TIME):
        numbers[axis] = np.asarray(root.axes[axis].values, float).tolist()
