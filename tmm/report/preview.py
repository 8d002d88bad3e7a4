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

_WIDTH, _LEGEND, _GAP = 14.0, 3.2, 0.6  # inches: of the figure, beside its panels for the legend, between panels
MAX_SIDE = 1600  # texels drawn a side; larger textures are thinned
UNKNOWN = (0.0, 0.0, 0.0)


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
        figure, axes, bars = _panels(file.height / file.width)
        axes[0].imshow(on_screen(pixels, valid))
        axes[0].set_title(f"{file.attributes['texture']}, {file.width} x {file.height}")
        code = file.thinned("code", step)
        legend = _draw_codes(file, axes[1], code)
        artist = axes[2].imshow(file.thinned("confidence", step), vmin=0, vmax=1, cmap="viridis")
        axes[2].set_title("confidence")
        figure.colorbar(artist, cax=bars[0])
        if file.has_shade:
            artist = axes[3].imshow(file.thinned("shade", step) / SHADE_TOTAL, vmin=0, vmax=1, cmap="gray_r")
            axes[3].set_title("share in cast shade")
            figure.colorbar(artist, cax=bars[1])
        else:
            bars[1].remove()
        for axis in axes:
            axis.set_axis_off()
        figure.legend(handles=legend, loc="upper right", frameon=False)
    save_figure(figure, os.fspath(out))


def _panels(shape: float) -> tuple[Figure, list[Axes], list[Axes]]:
    """A figure with four panels for images of a height over width, and narrow ones for the bars of the last two."""
    rows, columns = (4, 1) if shape < 0.5 else (2, 2)
    across = (_WIDTH - _LEGEND) / columns
    wide = across - _GAP
    tall = wide * shape
    height = rows * (tall + _GAP)
    figure = new_figure(_WIDTH, height, arranged=False)

    def place(left: float, row: int, width: float) -> tuple[float, float, float, float]:
        return left / _WIDTH, 1 - (row + 1) * (tall + _GAP) / height + 0.1 / height, width / _WIDTH, tall / height

    panels = [divmod(number, columns) for number in range(4)]
    axes = [figure.add_axes(place(0.1 + column * across, row, wide)) for row, column in panels]
    bars = [figure.add_axes(place(0.15 + column * across + wide, row, 0.12)) for row, column in panels[2:]]
    return figure, axes, bars


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


def _draw_codes(file: TmmFile, axis: Axes, code: npt.NDArray[np.uint16]) -> list[Patch]:
    """Draw level 0 and return the legend's handles, each with the material's share."""
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
    axis.imshow(canvas, interpolation="nearest")
    axis.set_title("material codes")
    return handles
