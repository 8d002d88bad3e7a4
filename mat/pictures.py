"""Pictures of the databases."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from skyshine.mat.tables.loader import AtmosphereTable, BandTable, Table, TemperatureTable, open_table

SHOWN = 12  # lines in one plot beyond which colours no longer tell them apart


def draw(file: str | os.PathLike, picture: str | os.PathLike) -> Path:
    """Draw a database into a PNG.

    Raises
    ------
    InputError
        The file is not a database of the table builder.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    table = open_table(file)
    figure = Figure(figsize=(12, 4.6), layout="constrained")
    FigureCanvasAgg(figure)
    drawers = {TemperatureTable: _temperatures, BandTable: _band, AtmosphereTable: _atmosphere}
    drawers[type(table)](figure, table)
    figure.suptitle(f"{table.path.name}  ({table.attributes['title']})", fontsize=10)
    figure.savefig(picture, dpi=110, metadata={"Software": None})
    return Path(picture)


def _colours(count: int) -> np.ndarray:
    from matplotlib import colormaps

    return colormaps["tab20" if count > 10 else "tab10"](np.arange(count))


def _temperatures(figure, table: Table) -> None:
    axes = table.root.axes
    hours = np.append(axes["time"].values, axes["time"].values[0] + 24.0)
    low, faces = float(axes["altitude"].values[0]), axes["azimuth"].values
    codes = axes["material"].values[:SHOWN]
    names = {code: name for name, code in table.materials.items()}
    day, aspect = figure.subplots(1, 2)
    flat = float(np.min(axes["slope"].values))
    for code, colour in zip(codes, _colours(codes.size)):
        kelvin = table.temperature(material=code, altitude=low, azimuth=faces[0], slope=flat, time=hours)
        day.plot(hours, kelvin - 273.15, color=colour, label=names[int(code)])
    day.set(xlabel="local time, h", ylabel="temperature, °C", title=f"slope {flat:g}°, altitude {low:g} km")
    day.legend(fontsize=7)
    steep = float(axes["slope"].values[np.argmin(np.abs(axes["slope"].values - 60.0))])
    facing = np.append(faces, faces[0] + 360.0)
    grid = table.temperature(
        material=codes[0], altitude=low, azimuth=facing[:, None], slope=steep, time=hours[None, :]
    )  # fmt: skip
    mesh = aspect.pcolormesh(hours, facing, grid - 273.15, shading="gouraud", cmap="inferno")
    aspect.set(xlabel="local time, h", ylabel="facing, ° from north", title=f"{names[int(codes[0])]}, slope {steep:g}°")
    figure.colorbar(mesh, ax=aspect, label="temperature, °C")


def _band(figure, table: Table) -> None:
    axes, variables = table.root.axes, table.root.variables
    radiance, materials = figure.subplots(1, 2)
    kelvin = axes["temperature"].values
    radiance.semilogy(kelvin, variables["blackbody_radiance"].data)
    radiance.set(xlabel="temperature, K", ylabel="blackbody radiance, W m$^{-2}$ sr$^{-1}$")
    radiance.grid(alpha=0.3)
    names = variables["material_name"].data
    rows = np.arange(names.size)
    for shift, (name, colour) in enumerate((("reflectance", "tab:blue"), ("reflectance_solar", "tab:orange"))):
        materials.barh(rows + 0.38 * shift, variables[name].data, 0.38, color=colour, label=name)
    materials.set(xlabel="reflectance", yticks=rows + 0.19)
    materials.set_yticklabels(names, fontsize=7)
    materials.legend(fontsize=7)


def _atmosphere(figure, table: Table) -> None:
    axes = table.root.axes
    low = float(axes["altitude"].values[0])
    elevations = axes["elevation"].values
    chosen = elevations[np.unique(np.linspace(0, elevations.size - 1, 9).round().astype(int))]
    ranges = axes["range"].values[axes["range"].values > 0]
    heights = axes["altitude"].values
    high = float(heights[np.argmin(np.abs(heights - low - 2.0))])
    reach, glow, source = figure.subplots(1, 3)
    for elevation, colour in zip(chosen, _colours(chosen.size)):
        beta = table.value("beta_star", range=ranges, altitude=high, elevation=elevation)
        tau = table.transmittance(range=ranges, beta_star=beta)
        inside = table.value("valid", range=ranges, altitude=high, elevation=elevation) > 0.99
        reach.semilogx(ranges[inside], tau[inside], color=colour, label=f"{elevation:g}°")
    reach.set(xlabel="range, km", ylabel="transmittance", title=f"observer at {high:g} km", ylim=(-0.02, 1.02))
    reach.legend(fontsize=7, title="elevation", title_fontsize=7)
    _sky(figure, glow, table, low)
    up = axes["source_elevation"].values
    place = {"range": axes["range"].values[0], "altitude": low, "elevation": elevations[-1]}
    source.semilogy(up, table.value("ambient_radiance", **place, source_elevation=up), label="ambient")
    direct = table.value("direct_radiance", **place, source_elevation=up)
    source.semilogy(up[direct > 0], direct[direct > 0], label="direct")
    source.set(xlabel="source elevation, °", ylabel="W m$^{-2}$ sr$^{-1}$", title=f"at {low:g} km")
    source.legend(fontsize=7)


def _sky(figure, glow, table: Table, low: float) -> None:
    """Path radiance to the end of the range axis, by elevation and azimuth from the source."""
    axes = table.root.axes
    ups = np.array([e for e in axes["elevation"].values if e >= 0])
    if ups.size < 2:
        glow.set(title="no upward elevation in this table")
        return
    turn = axes["source_azimuth"].values
    sun = float(axes["source_elevation"].values[np.argmin(np.abs(axes["source_elevation"].values - 30.0))])
    far = float(axes["range"].values[-1])
    where = {"range": far, "altitude": low, "elevation": ups[:, None]}
    tau = table.transmittance(range=far, beta_star=table.value("beta_star", **where))
    radiance = (1 - tau) * table.value("path_radiance_ratio", **where, source_elevation=sun, source_azimuth=turn)
    mesh = glow.pcolormesh(turn, ups, radiance, shading="gouraud", cmap="viridis")
    glow.set(xlabel="azimuth from the source, °", ylabel="elevation, °", title=f"path radiance, source at {sun:g}°")
    figure.colorbar(mesh, ax=glow, label="W m$^{-2}$ sr$^{-1}$")
