"""The card of a material: spectrum, layers and a clear summer day on one picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.materials.colours import natural_colour
from skyshine.schemas.chart_style import (
    BLACK,
    BLUE,
    GREEN,
    VERMILLION,
    chart_style,
    hours_of_day,
    name_lines,
    new_figure,
    save_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from skyshine.materials.library import Material

BANDS = ((3.0, 5.0), (8.0, 12.0))  # MWIR and LWIR [um]
# Clear sky, midsummer, 45 degree north; the day on which all cards show their material.
DAY: dict[str, Any] = {
    "skyshine": 1,
    "name": "card",
    "site": {"latitude_deg": 45, "longitude_deg": 0, "date": "2026-06-21", "utc_offset_h": 0},
    "states": [
        {
            "profile": "midlatitude_summer",
            "weather": {"air_temperature_c": [14, 27], "wind_speed_m_s": 3, "relative_humidity_percent": 50},
        }
    ],
    "materials": "all",
    "bands": [],
}
_SHADES = ("#D9D9D9", "#BFBFBF", "#A6A6A6")


def draw_card(material: Material, summary: Mapping[str, float], file: Path) -> None:
    """Draw a material into a PNG.

    Parameters
    ----------
    material : Material
        Material of the library, so that its day can be solved by name.
    summary : mapping of str to float
        Result of `scene.material_summary`.

    Raises
    ------
    InputError
        The picture cannot be written.
    """
    with chart_style():
        figure = new_figure(11.5, 6.4)
        panels = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.5))
        figure.suptitle(
            f"{material.name}  (code {material.code}, {material.group}): {material.description}", fontsize=10
        )
        spectrum, stack = figure.add_subplot(panels[0, :]), figure.add_subplot(panels[1, 0])
        draw_spectra(spectrum, [material])
        spectrum.set_title(fill(_sample(material), 150), fontsize=7, loc="left")
        _stack(stack, material, summary)
        _day(figure.add_subplot(panels[1, 1]), material)
        name_lines(spectrum)
        save_figure(figure, file)


def _sample(material: Material) -> str:
    """What its spectrum was measured on, or whose it is: the line of its table."""
    lines = material.reflectance_note.splitlines()
    return next((line for line in lines if line.startswith("sample: ")), "")


def draw_spectra(axes: Axes, materials: Sequence[Material]) -> None:
    """Reflectance against wavelength, and 1 - absorptance of what lets light through.

    Of a single material, stretches that were not measured on it are marked at the foot with their kind.
    """
    from matplotlib.ticker import ScalarFormatter

    for lower, upper in BANDS:
        axes.axvspan(lower, upper, color="0.93")
    for material in materials:
        (line,) = axes.plot(material.wavelength, material.reflectance, label=material.name, linewidth=1)
        if material.transmits:
            through = 1 - material.absorptance
            label = f"{material.name}: 1 \u2212 absorptance"
            axes.plot(material.wavelength, through, ":", color=line.get_color(), label=label)
    for stretch in materials[0].ranges if len(materials) == 1 else ():
        if stretch.kind not in ("measured", "modelled", "fresnel"):
            axes.axvspan(stretch.lower, stretch.upper, ymax=0.03, color=VERMILLION, alpha=0.5)
            axes.text((stretch.lower * stretch.upper) ** 0.5, 0.035, stretch.kind, fontsize=6, ha="center")
    axes.set(xscale="log", ylim=(0, 1), xlabel="wavelength, µm", ylabel="hemispherical reflectance")
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.set_xticks([0.3, 0.5, 1, 2, 3, 5, 8, 12], minor=False)
    axes.set_xlim(materials[0].wavelength[0], max(material.wavelength[-1] for material in materials))


def _stack(axes: Axes, material: Material, summary: Mapping[str, float]) -> None:
    """Skin and layers from the top down, each a row of the same height, with what conducts and stores heat; the skin in
    its colour in daylight, the numbers of the surface above it.
    """
    from matplotlib.colors import to_rgb
    from matplotlib.patches import Rectangle

    thermal = material.thermal
    rows = [("skin", thermal.skin), *((f"layer {n}", layer) for n, layer in enumerate(thermal.layers, 1))]
    axes.axis("off")
    above = [
        f"solar absorptance {summary['solar_absorptance']:.2f}",
        f"emissivity {summary['thermal_emissivity']:.2f}"
        f"   (3\u20135 µm {summary['emissivity_3_5_um']:.2f}, 8\u201312 µm {summary['emissivity_8_12_um']:.2f})",
    ]
    axes.text(0.0, 1.0, "\n".join(above), transform=axes.transAxes, fontsize=8, va="top")
    height = 0.72 / (len(rows) + 1)
    skin: tuple[float, ...] = tuple(natural_colour(material.wavelength, material.reflectance).tolist())
    colours: list[Any] = [skin, *_SHADES]
    for number, ((name, layer), colour) in enumerate(zip(rows, colours, strict=False)):
        low = 0.80 - (number + 1) * height
        options: dict[str, Any] = {"transform": axes.transAxes}
        axes.add_patch(Rectangle((0.0, low), 0.98, height, facecolor=colour, edgecolor="white", **options))
        text = (
            f"{name}: {_length(layer.thickness)}   {layer.conductivity:.3g} W/(m K)   {layer.density:.4g} kg/m³"
            f"   {layer.heat_capacity:.4g} J/(kg K)"
        )
        ink = "white" if np.mean(to_rgb(colour)) < 0.45 else BLACK
        axes.text(0.02, low + height / 2, text, fontsize=7.5, va="center", color=ink, **options)
    why = material.sources["back.kind"]
    foot = 0.80 - len(rows) * height
    text = fill(f"behind: {thermal.back.kind} ({why})", 84)
    axes.text(0.02, foot - 0.03, text, transform=axes.transAxes, fontsize=7, va="top")


def _length(metres: float) -> str:
    return f"{1e3 * metres:.3g} mm" if metres < 0.1 else f"{metres:.3g} m"


def _day(axes: Axes, material: Material) -> None:
    """Temperature through the day: level in the Sun, facing south upright, level in the shade all day; the air."""
    from skyshine.mat.api.temperature import temperature

    faces: dict[str, tuple[str, dict[str, Any]]] = {
        "level": (VERMILLION, {}),
        "wall facing south": (BLUE, {"slope": 90.0, "azimuth": 180.0}),
        "level, in the shade": (GREEN, {"shade": "00:00-24:00"}),
    }
    for label, (colour, orientation) in faces.items():
        day = temperature(material.name, job=DAY, **orientation)
        axes.plot(np.asarray(day.time, float), day.temperature - ZERO_CELSIUS, color=colour, linestyle="-", label=label)
    low, high = DAY["states"][0]["weather"]["air_temperature_c"]
    axes.axhspan(low, high, color="0.93")
    axes.set_title(f"clear 21 June, 45° N; air {low} to {high} °C (grey), 3 m/s", fontsize=9)
    axes.set_ylabel("temperature, °C")
    hours_of_day(axes)
    name_lines(axes)
