"""One style of charts: colours that colour-blind readers can distinguish, names at the lines, hours in threes, compass.

References
----------
Colours: Okabe and Ito (2008), Color Universal Design, https://jfly.uni-koeln.de/color/; lines do without yellow, which
is too pale on white.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import StrPath

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

BLACK, ORANGE, SKY, GREEN, YELLOW, BLUE, VERMILLION, PURPLE = (
    "#000000",
    "#E69F00",
    "#56B4E9",
    "#009E73",
    "#F0E442",
    "#0072B2",
    "#D55E00",
    "#CC79A7",
)
COLOURS = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY)  # colours of lines; black is for emphasis
HEAT, AMOUNT = "inferno", "viridis"  # maps of temperatures, and of everything else; both grow evenly in lightness
WHITE_HOT = "gray"  # map of what a camera sees
_DASHES = ("-", (0, (5, 2)), (0, (1.2, 1.2)))  # dashes of lines beyond the colours
_SMALL = 8  # points
_POINTS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")
_SETTINGS: dict[str, Any] = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.4,
    "image.cmap": AMOUNT,
    "legend.frameon": False,
}


@contextmanager
def chart_style() -> Iterator[None]:
    """Draw in the style of the project.

    Examples
    --------
    >>> import matplotlib
    >>> with chart_style():
    ...     matplotlib.rcParams["axes.prop_cycle"].by_key()["color"][0]
    '#0072B2'
    """
    from cycler import cycler
    from matplotlib import rc_context

    settings: Any = {**_SETTINGS, "axes.prop_cycle": cycler(linestyle=_DASHES) * cycler(color=COLOURS)}
    with rc_context(settings):
        yield


def new_figure(width: float, height: float, *, arranged: bool = True) -> Figure:
    """A figure of inches, without a window.

    With `arranged` matplotlib finds the places of its charts, which takes longer than drawing them.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained" if arranged else None)
    FigureCanvasAgg(figure)
    return figure


def save_figure(figure: Figure, picture: StrPath) -> Path:
    """Write a figure as a picture whose bytes do not depend on the time.

    Raises
    ------
    InputError
        The picture cannot be written.
    """
    try:
        # Level 2 packs to 1.2 times the size of 6 in a third of the time.
        figure.savefig(picture, dpi=110, metadata={"Software": None}, pil_kwargs={"compress_level": 2})
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise InputError(f"cannot be written: {why}; check the folder and the ending", file=picture) from None
    return Path(picture)


def name_lines(axis: Axes) -> None:
    """Write the label of each line beside its right end, apart from each other, in place of a legend.

    Parameters
    ----------
    axis : matplotlib Axes
        Axes with its lines and with fixed limits.
    """
    from matplotlib.figure import Figure

    figure = axis.get_figure()
    assert isinstance(figure, Figure)  # charts of the project have no figures within figures
    if figure.get_layout_engine() is not None:
        figure.draw_without_rendering()  # places are settled then
    axis.get_xlim(), axis.get_ylim()  # settled when they are asked for
    ends = []
    for line in axis.get_lines():
        label = str(line.get_label())
        if label.startswith("_"):
            continue
        point = _last_point(axis, line)
        if point is not None:
            ends.append((point, label, line.get_color()))
    if not ends:
        return
    height = axis.get_window_extent().height / figure.dpi * 72.0  # points
    ends.sort(key=lambda end: end[0][1])
    rows = spread([y for (_, y), _, _ in ends], 1.25 * _SMALL / height, (0.0, 1.0))
    for ((x, y), label, colour), row in zip(ends, rows, strict=True):
        axis.annotate(
            label,
            xy=(x, y),
            xytext=(1.035, row),
            xycoords="axes fraction",
            textcoords="axes fraction",
            fontsize=_SMALL,
            va="center",
            arrowprops={"arrowstyle": "-", "color": colour, "lw": 1.2, "shrinkA": 1, "shrinkB": 0, "relpos": (0, 0.5)},
        )


def _last_point(axis: Axes, line: Line2D) -> tuple[float, float] | None:
    """Fractions of the axes at which a line ends at the right, within them; None where nothing of it is seen."""
    x, y = np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)
    visible = np.isfinite(x) & np.isfinite(y)
    if axis.get_yscale() == "log":
        visible &= y > 0
    points = axis.transAxes.inverted().transform(line.get_transform().transform(np.column_stack([x, y])[visible]))
    inside = points[(points[:, 0] <= 1.0 + 1e-9) & (points[:, 0] >= -1e-9)]
    if not len(inside):
        return None
    right = inside[np.argmax(inside[:, 0])]
    return float(right[0]), float(np.clip(right[1], 0.0, 1.0))


def spread(targets: Sequence[float], gap: float, limits: tuple[float, float] = (-np.inf, np.inf)) -> list[float]:
    """Places as near to ascending wanted ones as a gap between them allows, in least squares, and within limits that
    have room for them.

    Examples
    --------
    >>> spread([0.1, 0.5, 0.5], 0.2)
    [0.1, 0.4, 0.6]
    >>> spread([0.9, 1.0], 0.2, (0.0, 1.0))
    [0.8, 1.0]
    """
    groups: list[tuple[float, int]] = []  # means of places less their rank, which may not descend; counts
    for rank, target in enumerate(targets):
        mean, count = target - rank * gap, 1
        while groups and groups[-1][0] >= mean:
            before, number = groups.pop()
            mean, count = (before * number + mean * count) / (number + count), number + count
        groups.append((mean, count))
    means = np.array([mean for mean, count in groups for _ in range(count)])
    means = np.maximum(np.minimum(means, limits[1] - (len(means) - 1) * gap), limits[0])
    return [round(float(mean + rank * gap), 12) for rank, mean in enumerate(means)]


def hours_of_day(axis: Axes, start: float = 0.0, stop: float = 24.0) -> None:
    """Hours of the local clock along the lower axis, marked every three."""
    ticks = np.arange(np.ceil(start / 3.0) * 3.0, stop + 1e-9, 3.0)
    axis.set_xlim(start, stop)
    axis.set_xticks(ticks, [f"{hour % 24:02.0f}" if hour != 24 else "24" for hour in ticks])
    axis.set_xlabel("local clock, h")


def compass(axis: Axes) -> None:
    """Points of the compass along the left axis, which is in degrees from north eastward."""
    axis.set_yticks(np.arange(0.0, 361.0, 45.0), [*_POINTS, _POINTS[0]])
