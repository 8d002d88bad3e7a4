"""Pictures of the databases."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.axes import PERIODIC
from skyshine.mat.tables.loader import open_table
from skyshine.mat.tables.surface_tables import TemperatureTable
from skyshine.mat.tables.table import Table
from skyshine.schemas.chart_style import (
    AMOUNT,
    BLACK,
    BLUE,
    HEAT,
    ORANGE,
    chart_style,
    compass,
    hours_of_day,
    name_lines,
    new_figure,
    save_figure,
)
from skyshine.schemas.paths import StrPath

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAMED = ("state", "band", "date", "source")  # attributes that tell databases of one type apart
SHOWN_PARTS = 8  # absorbers drawn in a spectrum
SHOWN = 12  # lines in one plot beyond which colours no longer tell them apart


def draw(file: StrPath, picture: StrPath) -> Path:
    """Draw a database into a PNG.

    Raises
    ------
    InputError
        The file is not a database of the table builder.
    """
    table = open_table(file)
    with chart_style():
        figure = new_figure(*((11.5, 9.2) if isinstance(table, AtmosphereTable) else (12.5, 4.6)))
        names = ", ".join(str(table.attributes[key]) for key in NAMED if key in table.attributes)
        figure.suptitle(f"{table.path.name}  ({table.attributes['title']})  {names}".rstrip(), fontsize=10)
        if isinstance(table, TemperatureTable):
            _temperatures(figure, table)
        elif isinstance(table, AtmosphereTable):
            _atmosphere(figure, table)
        else:
            _band(figure, table)
        return save_figure(figure, picture)


def draw_spectrum(spectrum: Any, title: str, picture: StrPath) -> Path:
    """Draw a spectrum of `line_spectrum` into a PNG: transmittance, whole and by what absorbs most, and path radiance.

    Raises
    ------
    InputError
        The picture cannot be written.
    """
    with chart_style():
        figure = new_figure(12, 7)
        figure.suptitle(title, fontsize=10)
        upper, lower = figure.subplots(2, 1, sharex=True)
        parts = {
            **spectrum.transmittance_by_gas,
            "Rayleigh": spectrum.transmittance_rayleigh,
            "aerosol": spectrum.transmittance_aerosol,
        }
        upper.plot(spectrum.wavenumber, spectrum.transmittance, color=BLACK, lw=1.0, label="all")
        for name in sorted(parts, key=lambda name: np.mean(parts[name]))[:SHOWN_PARTS]:
            upper.plot(spectrum.wavenumber, parts[name], lw=0.8, alpha=0.8, label=name)
        upper.set(ylabel="transmittance", ylim=(-0.02, 1.02))
        for values, label in ((spectrum.path_thermal, "path, thermal"), (spectrum.path_scattered, "path, scattered")):
            if np.any(values > 0):
                lower.semilogy(spectrum.wavenumber, np.where(values > 0, values, np.nan), lw=0.8, label=label)
        lower.set(xlabel="wavenumber, cm$^{-1}$", ylabel="W m$^{-2}$ sr$^{-1}$ (cm$^{-1}$)$^{-1}$")
        lower.set_xlim(float(np.min(spectrum.wavenumber)), float(np.max(spectrum.wavenumber)))
        brightest = float(np.max(spectrum.path_thermal + spectrum.path_scattered))
        if brightest > 0:
            lower.set_ylim(1e-6 * brightest, 2 * brightest)
        micrometres = upper.secondary_xaxis("top", functions=(_reciprocal, _reciprocal))
        micrometres.set_xlabel("wavelength, µm")
        for axis in (upper, lower):
            name_lines(axis)
        return save_figure(figure, picture)


def _reciprocal(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Wavelength in um of wavenumber in cm^-1, and back."""
    return np.asarray(1e4 / np.maximum(values, 1e-6))


def _temperatures(figure: Figure, table: TemperatureTable) -> None:
    axes = table.root.axes
    hours = axes["time"].values
    if table.rules("temperature")[-1].interpolation == PERIODIC:
        hours = np.append(hours, hours[0] + 24.0)
    low, faces = float(axes["altitude"].values[0]), axes["azimuth"].values
    codes = axes["material"].values[:SHOWN]
    names = {code: name for name, code in table.materials.items()}
    day, aspect = figure.subplots(1, 2)
    flat = float(np.min(axes["slope"].values))
    for code in codes:
        kelvin = table.temperature(material=code, altitude=low, azimuth=faces[0], slope=flat, time=hours)
        day.plot(hours, kelvin - ZERO_CELSIUS, label=names[int(code)])
    day.set(ylabel="temperature, °C", title=f"slope {flat:g}°, altitude {low:g} km")
    hours_of_day(day, float(hours[0]), float(hours[-1]))
    steep = float(axes["slope"].values[np.argmin(np.abs(axes["slope"].values - 60.0))])
    facing = np.append(faces, faces[0] + 360.0)
    grid = table.temperature(material=codes[0], altitude=low, azimuth=facing[:, None], slope=steep, time=hours[None, :])
    mesh = aspect.pcolormesh(hours, facing, grid - ZERO_CELSIUS, shading="gouraud", cmap=HEAT)
    aspect.set(ylabel="facing", title=f"{names[int(codes[0])]}, slope {steep:g}°")
    aspect.grid(visible=False)
    hours_of_day(aspect, float(hours[0]), float(hours[-1]))
    compass(aspect)
    figure.colorbar(mesh, ax=aspect, label="temperature, °C")
    name_lines(day)


def _band(figure: Figure, table: Table) -> None:
    axes, variables = table.root.axes, table.root.variables
    radiance, materials = figure.subplots(1, 2)
    kelvin = axes["temperature"].values
    radiance.semilogy(kelvin, variables["blackbody_radiance"].data)
    radiance.set(xlabel="temperature, K", ylabel="blackbody radiance, W m$^{-2}$ sr$^{-1}$")
    names = variables["material_name"].data
    rows = np.arange(names.size)
    for shift, (name, colour) in enumerate((("reflectance", BLUE), ("reflectance_solar", ORANGE))):
        materials.barh(rows + 0.38 * shift, variables[name].data, 0.38, color=colour, label=name)
    materials.set(xlabel="reflectance", yticks=rows + 0.19)
    materials.set_yticklabels(names, fontsize=7)
    materials.grid(visible=False, axis="y")
    materials.legend(fontsize=8, loc="upper left", bbox_to_anchor=(0.0, -0.1), ncols=2)


def _atmosphere(figure: Figure, table: AtmosphereTable) -> None:
    low = float(table.nodes_of("altitude")[0])
    heights = table.nodes_of("altitude")
    high = float(heights[np.argmin(np.abs(heights - low - 2.0))])
    _reach(figure.add_subplot(2, 2, 1), table, high)
    _section(figure, figure.add_subplot(2, 2, 2, projection="polar"), table, high)
    _sky(figure, figure.add_subplot(2, 2, 3, projection="polar"), table, low)
    source = figure.add_subplot(2, 2, 4)
    up = table.nodes_of("source_elevation")
    place = {"range": table.nodes_of("range")[0], "altitude": low, "elevation": table.nodes_of("elevation")[-1]}
    source.semilogy(up, table.value("ambient_radiance", **place, source_elevation=up), label="ambient")
    direct = table.value("direct_radiance", **place, source_elevation=up)
    source.semilogy(up[direct > 0], direct[direct > 0], label="direct")
    source.set(
        xlabel="source elevation, °", ylabel="W m$^{-2}$ sr$^{-1}$", title=f"light of sky and source at {low:g} km"
    )
    name_lines(source)


def _ranges(table: AtmosphereTable) -> np.ndarray:
    """Ranges beyond 0, also between the nodes, for smooth lines."""
    nodes = table.nodes_of("range")
    nodes = nodes[nodes > 0]
    return nodes if nodes.size < 2 else np.unique(np.concatenate([nodes, np.geomspace(nodes[0], nodes[-1], 120)[1:-1]]))


def _transmittance(
    table: AtmosphereTable, ranges: npt.NDArray[np.float64], altitude: float, elevation: npt.ArrayLike
) -> npt.NDArray[np.float64]:
    """Transmittance by range (and elevation), not a number behind the ground."""
    where: dict[str, Any] = {"range": ranges, "altitude": altitude, "elevation": elevation}
    tau = table.transmittance(range=ranges, beta_star=table.value("beta_star", **where))
    return np.where(table.value("valid", **where) > 0.99, tau, np.nan)


def _reach(axis: Any, table: AtmosphereTable, altitude: float) -> None:
    elevations = table.nodes_of("elevation")
    chosen = elevations[np.unique(np.linspace(0, elevations.size - 1, 9).round().astype(int))]
    ranges = _ranges(table)
    for elevation in chosen:
        axis.semilogx(ranges, _transmittance(table, ranges, altitude, elevation), label=f"{elevation:g}°")
    axis.set(xlabel="range, km", ylabel="transmittance", ylim=(-0.02, 1.02))
    axis.set_title(f"observer at {altitude:g} km, by elevation")
    if ranges.size > 1:
        axis.set_xlim(ranges[0], ranges[-1])
    name_lines(axis)


def _section(figure: Figure, axis: Any, table: AtmosphereTable, altitude: float) -> None:
    """Transmittance in a vertical plane: outwards the range, around it the elevation of the line of sight."""
    ranges, elevations = _ranges(table), table.nodes_of("elevation")
    axis.set(thetamin=float(elevations[0]), thetamax=float(max(elevations[-1], elevations[0] + 10)))
    axis.set_title(f"transmittance by elevation and range, from {altitude:g} km")
    if ranges.size < 2 or elevations.size < 2:
        return
    up = np.unique(np.concatenate([elevations, np.linspace(elevations[0], elevations[-1], 181)]))
    tau = _transmittance(table, ranges[:, np.newaxis], altitude, up)
    mesh = axis.pcolormesh(np.radians(up), np.log10(ranges), tau, shading="nearest", cmap=AMOUNT, vmin=0, vmax=1)
    ticks = np.arange(np.ceil(np.log10(ranges[0])), np.floor(np.log10(ranges[-1])) + 1)
    axis.set_rticks(ticks, [f"{10.0**tick:g} km" for tick in ticks], fontsize=7)
    axis.grid(alpha=0.3)
    figure.colorbar(mesh, ax=axis, label="transmittance", shrink=0.8)


def _sky(figure: Figure, axis: Any, table: AtmosphereTable, low: float) -> None:
    """Path radiance to the end of the range axis over the sky: the zenith in the middle, the source's azimuth at the
    top.
    """
    axis.set_theta_zero_location("N")
    axis.set_thetagrids(range(0, 360, 45), [f"{min(a, 360 - a)}°" for a in range(0, 360, 45)])
    ups = np.array([e for e in table.nodes_of("elevation") if e >= 0])
    turn = table.nodes_of("source_azimuth") if "source_azimuth" in table.root.axes else np.array([0.0, 180.0])
    if ups.size < 2 or turn.size < 2:
        axis.set_title("no sky in this table: it needs two upward elevations and two azimuths", fontsize=8)
        return
    sun = float(table.nodes_of("source_elevation")[np.argmin(np.abs(table.nodes_of("source_elevation") - 30.0))])
    far = float(table.nodes_of("range")[-1])
    fine, around = np.linspace(ups[0], ups[-1], 91), np.linspace(turn[0], turn[-1], 91)
    where: dict[str, Any] = {"range": far, "altitude": low, "elevation": fine[:, np.newaxis]}
    tau = table.transmittance(range=far, beta_star=table.value("beta_star", **where))
    radiance = (1 - tau) * table.value("path_radiance_ratio", **where, source_elevation=sun, source_azimuth=around)
    whole = np.concatenate([-around[:0:-1], around])  # the two halves of the sky mirror each other
    mirrored = np.concatenate([radiance[:, :0:-1], radiance], axis=1)
    mesh = axis.pcolormesh(np.radians(whole), 90 - fine, mirrored, shading="gouraud", cmap=AMOUNT)
    axis.plot(0, 90 - sun, "o", markersize=7, markerfacecolor="none", markeredgecolor="white")
    axis.set_rticks([30, 60, 90], ["60°", "30°", "0°"], fontsize=7)
    axis.grid(alpha=0.3)
    axis.set_title(f"path radiance over {far:g} km, source at {sun:g}°")
    figure.colorbar(mesh, ax=axis, label="W m$^{-2}$ sr$^{-1}$", shrink=0.8)
