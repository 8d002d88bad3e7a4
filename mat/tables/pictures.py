"""Pictures of the databases."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.axes import PERIODIC
from skyshine.mat.tables.files import ATMQ, BAND, HTT, LUNAR_ATMQ
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.mat.tables.loader import open_table
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
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAMED = ("state", "band", "date", "source")  # attributes that tell databases of one type apart
SHOWN_PARTS = 8  # absorbers drawn in a spectrum
RADIANCE = "W m⁻² sr⁻¹"
PER_WAVENUMBER = "W m$^{-2}$ sr$^{-1}$ (cm$^{-1}$)$^{-1}$"
_PIXELS = 360  # across the disc of a sky, as in its picture
SHOWN = 12  # lines in one plot beyond which colours no longer tell them apart


def draw(file: StrPath, picture: StrPath) -> Path:
    """Draw a database into a PNG.

    Raises
    ------
    InputError
        The file is not a database of the table builder.
    """
    with chart_style():
        return save_figure(figure_of(open_table(file)), picture)


def figure_of(table: Table) -> Figure:
    """The picture of a database."""
    with chart_style():
        drawn, size = _DRAWN[table.filetype]
        figure = new_figure(*size, arranged=False)
        names = ", ".join(str(table.attributes[key]) for key in NAMED if key in table.attributes)
        figure.suptitle(f"{table.path.name}  ({table.attributes['title']})  {names}".rstrip(), fontsize=10)
        drawn(figure, table)
    return figure


def spectrum_figure(spectrum: Any) -> Figure:
    """The picture of one line of sight: transmittance, of all and of what absorbs most, and path radiance."""
    with chart_style():
        figure = new_figure(12, 7)
        figure.suptitle(repr(spectrum).strip("<>"), fontsize=10)
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
        lower.set(xlabel="wavenumber, cm$^{-1}$", ylabel=PER_WAVENUMBER)
        if spectrum.wavenumber.size > 1:
            lower.set_xlim(float(np.min(spectrum.wavenumber)), float(np.max(spectrum.wavenumber)))
        brightest = float(np.max(spectrum.path_thermal + spectrum.path_scattered))
        if brightest > 0:
            lower.set_ylim(1e-6 * brightest, 2 * brightest)
        micrometres = upper.secondary_xaxis("top", functions=(_reciprocal, _reciprocal))
        micrometres.set_xlabel("wavelength, µm")
        for axis in (upper, lower):
            name_lines(axis)
    return figure


def draw_comparison(comparison: Any, title: str, picture: StrPath) -> Path:
    """Draw a `SpectrumComparison` into a PNG: both spectra of each quantity, and their difference below.

    Raises
    ------
    InputError
        The picture cannot be written.
    """
    with chart_style():
        names = list(comparison.computed)
        figure = new_figure(12, 4 * len(names))
        figure.suptitle(title, fontsize=10)
        axes = figure.subplots(2 * len(names), 1, sharex=True, squeeze=False, height_ratios=[3, 1] * len(names))[:, 0]
        for name, both, below in zip(names, axes[::2], axes[1::2], strict=True):
            both.plot(
                comparison.wavenumber, comparison.reference[name], color=ORANGE, lw=1.0, label=comparison.file.name
            )
            both.plot(comparison.wavenumber, comparison.computed[name], color=BLACK, lw=0.8, label="computed")
            both.set(ylabel=name.replace("_", " ") + ("" if name == "transmittance" else f"\n{PER_WAVENUMBER}"))
            below.plot(comparison.wavenumber, comparison.difference[name], color=BLUE, lw=0.8)
            below.set(ylabel=f"difference\nrms {comparison.rms[name]:.2g}")
            name_lines(both)
        axes[-1].set_xlabel("wavenumber, cm$^{-1}$")
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
    day, aspect = figure.add_axes((0.05, 0.12, 0.33, 0.72)), figure.add_axes((0.57, 0.12, 0.33, 0.72))
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
    figure.colorbar(mesh, cax=figure.add_axes((0.92, 0.12, 0.012, 0.72)), label="temperature, °C")
    name_lines(day)


def _band(figure: Figure, table: Table) -> None:
    axes, variables = table.root.axes, table.root.variables
    radiance, materials = figure.add_axes((0.06, 0.12, 0.38, 0.76)), figure.add_axes((0.63, 0.16, 0.35, 0.72))
    kelvin = axes["temperature"].values
    radiance.semilogy(kelvin, variables["blackbody_radiance"].data)
    radiance.set(xlabel="temperature, K", ylabel=f"blackbody radiance, {RADIANCE}")
    _plain_powers(radiance.yaxis)
    names = variables["material_name"].data
    rows = np.arange(names.size)
    for shift, (name, colour) in enumerate((("reflectance", BLUE), ("reflectance_solar", ORANGE))):
        materials.barh(rows + 0.38 * shift, variables[name].data, 0.38, color=colour, label=name)
    materials.set(xlabel="reflectance", yticks=rows + 0.19)
    materials.set_yticklabels(names, fontsize=7)
    materials.grid(visible=False, axis="y")
    materials.legend(fontsize=8, loc="upper left", bbox_to_anchor=(0.0, -0.1), ncols=2)


def _atmosphere(figure: Figure, table: AtmosphereTable) -> None:
    low, highest = (float(altitude) for altitude in table.nodes_of("altitude")[[0, -1]])
    high = min(low + 2.0, highest)
    _reach(figure.add_axes((0.06, 0.56, 0.34, 0.36)), table, high)
    _section(figure, table, high)
    _sky(figure, table, low)
    source = figure.add_axes((0.6, 0.06, 0.3, 0.36))
    up = table.nodes_of("source_elevation")
    coordinates = {"range": table.nodes_of("range")[0], "altitude": low, "elevation": table.nodes_of("elevation")[-1]}
    source.semilogy(up, table.value("ambient_radiance", **coordinates, source_elevation=up), label="ambient")
    direct = table.value("direct_radiance", **coordinates, source_elevation=up)
    source.semilogy(up[direct > 0], direct[direct > 0], label="direct")
    source.set(xlabel="source elevation, °", ylabel=RADIANCE, title=f"light of sky and source at {low:.4g} km")
    _plain_powers(source.yaxis)
    name_lines(source)


def _ranges(table: AtmosphereTable, count: int) -> np.ndarray:
    """So many ranges beyond 0, even in their logarithm."""
    nodes = table.nodes_of("range")
    nodes = nodes[nodes > 0]
    return nodes if nodes.size < 2 else np.geomspace(nodes[0], nodes[-1], count)


def _transmittance(
    table: AtmosphereTable, ranges: npt.NDArray[np.float64], altitude: float, elevation: npt.ArrayLike
) -> npt.NDArray[np.float64]:
    """Transmittance by range and elevation, behind the ground that to it."""
    beta = table.value("beta_star", range=ranges, altitude=altitude, elevation=elevation)
    return table.transmittance(range=ranges, beta_star=beta)


def _reach(axis: Any, table: AtmosphereTable, altitude: float) -> None:
    elevations = table.nodes_of("elevation")
    chosen = elevations[np.unique(np.linspace(0, elevations.size - 1, 9).round().astype(int))]
    ranges = _ranges(table, 100)
    where: dict[str, Any] = {"altitude": altitude, "elevation": chosen[:, np.newaxis]}
    through = np.where(
        table.value("valid", range=ranges, **where) > 0,
        _transmittance(table, ranges, altitude, chosen[:, np.newaxis]),
        np.nan,
    )
    for elevation, tau in zip(chosen, through, strict=True):
        axis.semilogx(ranges, tau, label=f"{elevation:g}°")
    axis.set(xlabel="range, km", ylabel="transmittance", ylim=(-0.02, 1.02))
    axis.set_title(f"observer at {altitude:.4g} km, by elevation")
    _plain_powers(axis.xaxis)
    if ranges.size > 1:
        axis.set_xlim(ranges[0], ranges[-1])
    name_lines(axis)


def _section(figure: Figure, table: AtmosphereTable, altitude: float) -> None:
    """Transmittance in a vertical plane: outwards the range, around it the elevation of the line of sight."""
    title = f"transmittance by elevation and range, from {altitude:.4g} km"
    ranges, elevations = _ranges(table, 60), table.nodes_of("elevation")
    x, y = np.meshgrid(np.linspace(0.0, 1.0, _PIXELS // 2), np.linspace(-1.0, 1.0, _PIXELS))
    share, up = np.hypot(x, y), np.degrees(np.arctan2(y, x))
    axis = _disc(figure, (0.56, 0.53, 0.18, 0.37), title, (0.0, 1.0))
    if ranges.size < 2 or elevations.size < 2:
        return
    low, high = np.log(ranges[[0, -1]])
    steps = np.unique(np.concatenate([elevations, np.linspace(elevations[0], elevations[-1], 91)]))
    tau = _transmittance(table, ranges, altitude, steps[:, np.newaxis])
    drawn = (share <= 1) & (up >= steps[0]) & (up <= steps[-1])
    # The exponential of a logarithm may round beyond the range.
    reach = np.clip(np.exp(low + share * (high - low)), ranges[0], ranges[-1])
    inside = np.clip(up, steps[0], steps[-1])
    drawn &= table.value("valid", range=reach, altitude=altitude, elevation=inside) > 0
    rows, columns = np.interp(inside, steps, np.arange(steps.size)), np.clip(share, 0, 1) * (ranges.size - 1)
    pixels = np.where(drawn, _between(tau, rows, columns), np.nan)
    image = axis.imshow(pixels, extent=(0, 1, -1, 1), origin="lower", cmap=AMOUNT, vmin=0, vmax=1)
    for angle in (-90, -60, -30, 0, 30, 60, 90):
        _at_the_rim(axis, 90.0 - angle, f"{angle}°")
    for power in np.arange(np.ceil(low / np.log(10)), np.floor(high / np.log(10)) + 1):
        position = (power * np.log(10) - low) / (high - low)
        axis.text(-0.04, -position, f"{10.0**power:g} km", fontsize=7, ha="right", va="center")
    figure.colorbar(image, cax=figure.add_axes((0.86, 0.57, 0.012, 0.3)), label="transmittance")


def _sky(figure: Figure, table: AtmosphereTable, low: float) -> None:
    """Path radiance to the end of the range axis over the sky: the zenith in the middle, the source's azimuth at the
    top.
    """
    sun = float(np.clip(30.0, *table.nodes_of("source_elevation")[[0, -1]]))
    far = float(table.nodes_of("range")[-1])
    axis = _disc(figure, (0.06, 0.04, 0.3, 0.38), f"path radiance over {far:g} km, source at {sun:.3g}°", (-1.0, 1.0))
    # Steps of elevation and azimuth are finest at the horizon and around the source, where the sky changes most.
    ups = np.unique(np.concatenate([90 * np.linspace(0, 1, 46) ** 2, _around(max(sun, 0.0), 90.0)]))
    turns = np.unique(np.concatenate([np.linspace(0.0, 180.0, 37), _around(0.0, 180.0)]))
    where: dict[str, Any] = {"range": far, "altitude": low, "elevation": ups[:, np.newaxis]}
    tau = _transmittance(table, np.array(far), low, ups[:, np.newaxis])
    radiance = (1 - tau) * table.value("path_radiance_ratio", **where, source_elevation=sun, source_azimuth=turns)
    x, y = np.meshgrid(np.linspace(-1, 1, _PIXELS), np.linspace(-1, 1, _PIXELS))
    up, turn = 90 * (1 - np.minimum(np.hypot(x, y), 1.0)), np.degrees(np.arctan2(np.abs(x), y))
    rows, columns = (np.interp(at, steps, np.arange(steps.size)) for at, steps in ((up, ups), (turn, turns)))
    pixels = np.where(np.hypot(x, y) <= 1, _between(radiance, rows, columns), np.nan)
    image = axis.imshow(pixels, extent=(-1, 1, -1, 1), origin="lower", cmap=AMOUNT)
    axis.plot(0, (90 - sun) / 90, "o", markersize=7, markerfacecolor="none", markeredgecolor="white")
    for angle in range(0, 360, 45):
        _at_the_rim(axis, angle, f"{min(angle, 360 - angle)}°")
    for elevation in (30, 60):
        circle = np.radians(np.linspace(0, 360, 121))
        axis.plot(*((90 - elevation) / 90 * np.array([np.sin(circle), np.cos(circle)])), color="white", lw=0.5, ls="-")
        axis.text(0.0, (elevation - 90) / 90, f"{elevation}°", color="white", fontsize=7, ha="center", va="bottom")
    figure.colorbar(image, cax=figure.add_axes((0.43, 0.08, 0.012, 0.3)), label=RADIANCE)


def _around(source: float, highest: float) -> npt.NDArray[np.float64]:
    """Angles within 30 degree of a source, finest beside it, from 0 to the highest."""
    near = 30.0 * np.linspace(0, 1, 16) ** 2
    angles: npt.NDArray[np.float64] = np.clip(np.concatenate([source - near, source + near]), 0.0, highest)
    return angles


def _between(
    values: npt.NDArray[np.float64], rows: npt.NDArray[np.float64], columns: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Values between their rows and columns, linear."""
    low, column = (np.clip(at.astype(int), 0, size - 2) for at, size in zip((rows, columns), values.shape, strict=True))
    above, weight = rows - low, columns - column
    lower, upper = (values[row, column] * (1 - weight) + values[row, column + 1] * weight for row in (low, low + 1))
    between: npt.NDArray[np.float64] = lower * (1 - above) + upper * above
    return between


def _disc(
    figure: Figure, rectangle: tuple[float, float, float, float], title: str, across: tuple[float, float]
) -> Axes:
    """A chart without axes, for what is drawn around a middle: from -1 to 1 upwards."""
    axis = figure.add_axes(rectangle, aspect="equal", xlim=across, ylim=(-1.0, 1.0))
    axis.set_axis_off()
    axis.set_title(title, pad=18)
    return axis


def _at_the_rim(axis: Axes, azimuth: float, text: str) -> None:
    """A label outside the disc at an angle clockwise from the top, degree."""
    turn = np.radians(azimuth)
    axis.text(1.1 * np.sin(turn), 1.07 * np.cos(turn), text, fontsize=8, ha="center", va="center")


def _plain_powers(axis: Any) -> None:
    """Numbers at the powers of ten of a logarithmic axis alone, as they are written in units: drawn without TeX."""
    from matplotlib.ticker import FuncFormatter, NullLocator

    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


# Function and size in inches of the picture of each file type.
_DRAWN: dict[str, tuple[Callable[..., None], tuple[float, float]]] = {
    HTT.name: (_temperatures, (12.5, 4.6)),
    BAND.name: (_band, (12.5, 4.6)),
    ATMQ.name: (_atmosphere, (11.5, 9.2)),
    LUNAR_ATMQ.name: (_atmosphere, (11.5, 9.2)),
}
