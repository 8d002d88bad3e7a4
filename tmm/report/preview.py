"""Pictures of a mapped texture: photograph, materials with a legend, confidence and cast shade, side by side."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from skyshine.materials.colours import material_colours
from skyshine.materials.library import load_library
from skyshine.schemas.chart_style import new_figure, save_figure
from skyshine.tmm.database.layout import SHADE_TOTAL
from skyshine.tmm.database.reader import TmmFile, find_image, open_tmm
from skyshine.tmm.images.texture import TextureFile

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

_WIDTH, _GAP, _BAR = 14.0, 0.4, 0.8  # inches: of the figure, between panels, beside a panel for its bar
_LEGEND_COLUMNS, _LEGEND_LINE = 4, 0.24  # entries side by side beneath the panels; inches of a line of them
_SHORT = 0.5  # height over width of an image below which panels are in one column
MAX_SIDE = 1600  # texels drawn a side; larger textures are thinned
UNKNOWN = (0.0, 0.0, 0.0)  # black


def draw(
    path: str | os.PathLike[str], out: str | os.PathLike[str], image: str | os.PathLike[str] | None = None
) -> None:
    """Draw a texture database into a PNG file.

    Raises InputError: the database or the image cannot be read, or the picture cannot be written.

    Parameters
    ----------
    path : path
        The database.
    out : path
    image : path, optional
        The texture; by default it is looked for by its name (see `find_image`).
    """
    with open_tmm(path) as file:
        step = -(-max(file.height, file.width) // MAX_SIDE)
        job = file.job
        image_file = find_image(file, Path(path), image)
        texture = TextureFile(image_file, job.colour_space, "ignore", job.near_infrared)
        pixels, valid = thinned(texture, step)
        code = file.thinned("code", step)
        canvas, legend = _coloured_codes(file, code)
        panels = [
            (f"{file.attributes['texture']}, {file.width} x {file.height}", on_screen(pixels, valid), None),
            ("material codes", canvas, None),
            ("confidence", file.thinned("confidence", step), ("viridis", "confidence: 0 none, 1 certain")),
        ]
        if file.has_shade:
            shade = file.thinned("shade", step) / SHADE_TOTAL
            panels.append(("cast shade", shade, ("gray_r", "share in cast shade: 0 sunlit, 1 shaded")))
        figure, axes, bars = _panels(file.height / file.width, len(panels), len(legend))
        for axis, bar, (title, values, scale) in zip(axes, bars, panels, strict=False):
            axis.set_title(title)
            axis.set_axis_off()
            if scale is None:
                axis.imshow(values, interpolation="nearest" if values is canvas else None)
                bar.remove()
            else:
                artist = axis.imshow(values, vmin=0, vmax=1, cmap=scale[0])
                figure.colorbar(artist, cax=bar, label=scale[1])
        _draw_legend(figure, axes, legend)
    save_figure(figure, os.fspath(out))


def _panels(shape: float, count: int, entries: int) -> tuple[Figure, list[Axes], list[Axes]]:
    """A figure with panels for images of a height over width and a bar beside each; an odd cell is for the legend,
    else there is room for its entries beneath.
    """
    columns = 1 if shape < _SHORT else 2
    wide = (_WIDTH - _GAP - columns * (_GAP + _BAR)) / columns
    tall, rows = wide * shape, -(-count // columns)
    beneath = 0.0 if count % columns else (1 + -(-entries // _LEGEND_COLUMNS)) * _LEGEND_LINE
    height = rows * (tall + _GAP) + beneath + _GAP / 2
    figure = new_figure(_WIDTH, height, arranged=False)

    def place(number: int, beside: float, width: float) -> tuple[float, float, float, float]:
        row, column = divmod(number, columns)
        left = _GAP + column * (wide + _GAP + _BAR) + beside
        return left / _WIDTH, 1 - (row + 1) * (tall + _GAP) / height, width / _WIDTH, tall / height

    cells = range(count + count % columns)
    axes = [figure.add_axes(place(number, 0.0, wide)) for number in cells]
    return figure, axes, [figure.add_axes(place(number, wide + 0.1, 0.14)) for number in range(count)]


def _draw_legend(figure: Figure, axes: list[Axes], legend: list[Patch]) -> None:
    """The legend in the last cell if it has no panel, else beneath all panels."""
    if axes[-1].images:
        figure.legend(handles=legend, loc="lower center", ncols=_LEGEND_COLUMNS, frameon=False)
    else:
        axes[-1].set_axis_off()
        axes[-1].legend(handles=legend, loc="upper left", frameon=False)


def thinned(texture: TextureFile, step: int) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Pixels (h, w, C) and validity (h, w) of every `step`-th row and column."""
    rows = [texture.window(slice(top, top + 1), slice(0, texture.width)) for top in range(0, texture.height, step)]
    pixels, valid = (np.concatenate([row[part][:, ::step] for row in rows]) for part in (0, 1))
    return pixels, valid


def on_screen(pixels: npt.NDArray[Any], valid: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Colours (h, w, 3) float32 for the screen; high dynamic range is cut at its 99th percentile."""
    pixels = pixels[..., :3]
    if pixels.dtype.kind == "u":
        return pixels / np.float32(np.iinfo(pixels.dtype).max)
    finite = np.where(valid[..., np.newaxis], pixels, 0)
    white = np.percentile(finite[valid], 99) if valid.any() else 1.0
    display: npt.NDArray[Any] = np.clip(finite / max(white, np.finfo(np.float32).tiny), 0, 1) ** np.float32(1 / 2.2)
    return display


def _coloured_codes(file: TmmFile, code: npt.NDArray[np.uint16]) -> tuple[npt.NDArray[np.float32], list[Patch]]:
    """Colours (h, w, 3) of level 0, and the legend's handles, each with the material's share."""
    from matplotlib.patches import Patch

    colours = material_colours(tuple(file.materials.values()), load_library()) / np.float32(255)
    canvas = np.empty((*code.shape, 3), np.float32)
    canvas[:] = UNKNOWN
    handles = []
    for colour, material, (name, share) in zip(colours, file.materials, file.usage.items(), strict=True):
        canvas[code == material] = colour
        handles.append(Patch(facecolor=colour, label=f"{name} ({material}), {100 * share:.1f} %"))
    unknown = max(1 - sum(file.usage.values()), 0.0)
    handles.append(Patch(facecolor=UNKNOWN, label=f"unknown or no data (0), {100 * unknown:.1f} %"))
    return canvas, handles
