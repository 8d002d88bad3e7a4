"""Frames in one picture, beside a photograph, and as an animation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.job.fields import clock_text
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.render.scene_file import LoadedScene
from skyshine.schemas.arrays import Floats
from skyshine.schemas.chart_style import HEAT
from skyshine.schemas.errors import InputError
from skyshine.tmm.database.reader import find_image, open_tmm
from skyshine.tmm.images.raster import read_channels

TAIL = 0.2  # % of the pixels at each end that may lie beyond the colours
FRAME_MS = 400
COLUMNS, MOST = 4, 16  # frames in a row, and frames of a band
_WIDTH_IN, _DPI, _PHOTOGRAPH = 14.0, 100, 0.4  # width of the picture, and what the photograph has of it
_SHOWN_SIDE = 960  # pixels of the longer side that pictures of the day show at most


def draw_frames(
    bands: Mapping[str, Sequence[Floats]],
    titles: Sequence[str],
    picture: Path,
    photograph: npt.NDArray[Any] | None = None,
) -> Path:
    """Draw apparent temperatures of frames, such as those of a day, in one scale of colours.

    Parameters
    ----------
    bands : dict of str to sequence of (rows, columns) arrays
        Frames of each band [K].
    titles : sequence of str
        Of the frames of a band.
    picture : Path
    photograph : (h, w, 3) array, optional
        Beside them.

    Raises
    ------
    InputError
        The picture cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    shown = _shown(len(titles))
    low, high = _limits(bands)
    across = min(len(shown), COLUMNS)
    rows = -(-len(shown) // across)
    shape = next(iter(bands.values()))[0].shape
    side = _WIDTH_IN * (1.0 if photograph is None else 1.0 - _PHOTOGRAPH)
    height = len(bands) * rows * (side / across * shape[0] / shape[1] + 0.25) + 0.8
    figure = Figure(figsize=(_WIDTH_IN, height), layout="constrained")
    FigureCanvasAgg(figure)
    widths = [1.0] * across if photograph is None else [across * _PHOTOGRAPH / (1.0 - _PHOTOGRAPH), *[1.0] * across]
    grid = figure.add_gridspec(len(bands) * rows, len(widths), width_ratios=widths)
    if photograph is not None:
        axis = figure.add_subplot(grid[:, 0])
        axis.imshow(photograph)
        axis.set_axis_off()
        axis.set_title("photograph", fontsize=10)
    axes = []
    for number, (band, frames) in enumerate(bands.items()):
        for place, frame in enumerate(shown):
            axis = figure.add_subplot(grid[number * rows + place // across, len(widths) - across + place % across])
            drawn = axis.imshow(frames[frame] - ZERO_CELSIUS, cmap=HEAT, vmin=low, vmax=high)
            axis.set(xticks=[], yticks=[])
            axis.set_title(titles[frame], fontsize=9)
            if place % across == 0:
                axis.set_ylabel(band, fontsize=10)
            axes.append(axis)
    bar = figure.colorbar(drawn, ax=axes, location="bottom", fraction=0.05, aspect=60, pad=0.01)
    bar.set_label("apparent temperature, °C", fontsize=9)
    try:
        figure.savefig(picture, dpi=_DPI, format="png", pil_kwargs={"optimize": True})
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}; check the folder", file=picture) from None
    return picture


def animate(frames: Sequence[Floats], hours: Sequence[float], picture: Path) -> Path:
    """Write the frames of one band [K] as an animated PNG, in one scale of colours.

    Raises
    ------
    InputError
        The picture cannot be written.
    """
    from matplotlib import colormaps
    from PIL import Image, ImageDraw

    low, high = _limits({"": frames})
    images = []
    for kelvin, hour in zip(frames, hours, strict=True):
        share = np.clip((kelvin - ZERO_CELSIUS - low) / (high - low), 0.0, 1.0)
        image = Image.fromarray((colormaps[HEAT](share)[..., :3] * 255).astype(np.uint8))
        ImageDraw.Draw(image).text(
            (4, 2), clock_text(hour), fill=(255, 255, 255), stroke_width=1, stroke_fill=(0, 0, 0)
        )
        images.append(image)
    try:
        images[0].save(picture, save_all=True, append_images=images[1:], duration=FRAME_MS, loop=0)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}; check free space", file=picture) from None
    return picture


def shown_step(columns: int, rows: int) -> int:
    """Every how many columns and rows of its frames the pictures of a day show."""
    return -(-max(columns, rows) // _SHOWN_SIDE)


def photograph(scene: LoadedScene) -> npt.NDArray[Any] | None:
    """The image from which the texture of a plan was made; None for a mesh, or where the image is not there."""
    plan = scene.model.surface.plan
    if plan is None:
        return None
    try:
        with open_tmm(plan.texture) as texture:
            image = read_channels(find_image(texture, plan.texture, None))
    except InputError:  # the picture does without it
        return None
    if image.shape[-1] < 3 or image.dtype != np.uint8:
        return None
    return image[..., :3]


def _limits(bands: Mapping[str, Sequence[Floats]]) -> tuple[float, float]:
    """Ends of the colours [deg C]: of all frames, without the outermost pixels."""
    values = np.concatenate([frame.ravel() for frames in bands.values() for frame in frames]) - ZERO_CELSIUS
    low, high = np.percentile(values, [TAIL, 100.0 - TAIL])
    return float(low), float(max(high, low + 0.1))


def _shown(count: int) -> list[int]:
    """Numbers of the frames that are drawn: all, or `MOST` that are spread evenly."""
    return [round(number * (count - 1) / max(min(count, MOST) - 1, 1)) for number in range(min(count, MOST))]
