"""Frames in one picture, beside a photograph, and as an animation."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.job.fields import clock_text
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.render.scene_file import LoadedScene
from skyshine.mat.tables.tracks import SUNRISE_ELEVATION
from skyshine.schemas.arrays import Floats
from skyshine.schemas.chart_style import HEAT, WHITE_HOT, new_figure
from skyshine.schemas.errors import InputError
from skyshine.tmm.database.reader import find_image, open_tmm
from skyshine.tmm.images.raster import read_channels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TAIL = 0.2  # % of the pixels at each end that may lie beyond the colours
FRAME_MS = 400  # duration of a frame of an animated picture [ms]
COLUMNS, MOST = 4, 16  # frames in a row, and frames of a band
_PANEL, _GAP, _TITLE, _BAR = 6.0, 0.12, 0.34, 0.75  # inches: width of a frame, and heights around it
_DPI = 100  # 600 pixels a frame
_SHOWN_SIDE = 960  # pixels of the longer side that pictures of the day show at most


def draw_frames(
    bands: Mapping[str, Sequence[Floats]],
    titles: Sequence[str],
    picture: Path,
    *,
    sun_elevation: Sequence[float],
    photograph: npt.NDArray[Any] | None = None,
) -> Path:
    """Draw apparent temperatures of frames, such as those of a day: white-hot, day and night of each band on a scale of
    their own.

    Parameters
    ----------
    bands : dict of str to sequence of (rows, columns) arrays
        Frames of each band [K].
    titles : sequence of str
        Titles of the frames of a band.
    sun_elevation : sequence of float
        Elevation of the Sun in each frame [degree].
    photograph : (h, w, 3) array, optional
        Image drawn above the frames.

    Raises
    ------
    InputError
        The picture cannot be written.
    """
    numbers = _shown(len(titles))
    columns = min(len(numbers), COLUMNS)
    rows = -(-len(numbers) // columns)
    height, width = next(iter(bands.values()))[0].shape
    tall = _PANEL * height / width
    band_height = rows * (tall + _TITLE) + _BAR
    above = 0.0 if photograph is None else _PANEL * photograph.shape[0] / photograph.shape[1] + _TITLE
    full = (columns * (_PANEL + _GAP) + _GAP, len(bands) * band_height + above)
    figure = new_figure(*full, arranged=False)

    def axes(left: float, top: float, wide: float, high: float) -> Axes:
        """Axes at inches from the upper left corner."""
        return figure.add_axes((left / full[0], 1 - (top + high) / full[1], wide / full[0], high / full[1]))

    if photograph is not None:
        axis = axes(_GAP, _TITLE, _PANEL, above - _TITLE)
        axis.imshow(photograph)
        axis.set_axis_off()
        axis.set_title("photograph", fontsize=14)
    for number, (band, frames) in enumerate(bands.items()):
        top = above + number * band_height
        scales = {}
        nights = sum(sun_elevation[frame] < SUNRISE_ELEVATION for frame in numbers)
        for position, frame in enumerate(numbers):
            night = sun_elevation[frame] < SUNRISE_ELEVATION
            group = [frames[k] for k in numbers if (sun_elevation[k] < SUNRISE_ELEVATION) == night]
            limits = _limits({band: group})
            row, column = divmod(position, columns)
            axis = axes(_GAP + column * (_PANEL + _GAP), top + row * (tall + _TITLE) + _TITLE, _PANEL, tall)
            scales[night] = axis.imshow(frames[frame] - ZERO_CELSIUS, cmap=WHITE_HOT, vmin=limits[0], vmax=limits[1])
            axis.set_axis_off()
            axis.set_title(f"{band}, {titles[frame]}, {'night' if night else 'day'}", fontsize=14)
        left = _GAP
        for night in sorted(scales, reverse=True):  # as wide as its frames are many
            wide = (full[0] - 2 * _GAP) * (nights if night else len(numbers) - nights) / len(numbers)
            axis = axes(left + 0.03 * wide, top + band_height - _BAR + 0.1, 0.94 * wide, 0.16)
            left += wide
            bar = figure.colorbar(scales[night], cax=axis, orientation="horizontal")
            bar.ax.tick_params(labelsize=12)
            name = f"{band}, {'night' if night else 'day'}: apparent temperature, °C"
            bar.set_label(name, fontsize=12, labelpad=1)
    _write_picture(figure, picture, grey=photograph is None)
    return picture


def _write_picture(figure: Figure, picture: Path, *, grey: bool) -> None:
    """Write a figure as PNG; one channel is enough where all of it is grey."""
    from PIL import Image

    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=_DPI)
    image = Image.open(drawn).convert("RGB")
    try:
        (image.convert("L") if grey else image).save(picture, format="png", optimize=True)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}; check the folder", file=picture) from None


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
