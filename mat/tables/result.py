"""What the objects that functions return have in common: how they look in a notebook, and their pictures."""

from __future__ import annotations

import html
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine.schemas.chart_style import chart_style, hours_of_day, new_figure, save_figure
from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import StrPath

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_LINES = 12  # largest number of lines of a chart: more cannot be distinguished


@dataclass(frozen=True, eq=False)
class Chart:
    """A picture of a result; notebooks show it.

    Attributes
    ----------
    figure : matplotlib.figure.Figure
        Figure without a window, for changes of titles, limits and lines.
    """

    figure: Figure

    def save(self, path: StrPath) -> Path:
        """Write the picture as PNG; `figure.savefig` writes other formats.

        Raises
        ------
        InputError
            The name ends otherwise, or the file cannot be written.
        """
        if Path(path).suffix.lower() != ".png":
            raise InputError(f"found '{path}'; allowed: a name that ends in .png; use figure.savefig for other formats")
        return save_figure(self.figure, path)

    def _repr_png_(self) -> bytes:
        picture = io.BytesIO()
        self.figure.savefig(picture, format="png", dpi=110)
        return picture.getvalue()


@dataclass(frozen=True, eq=False)
class Panel:
    """Lines of one chart over one axis.

    Attributes
    ----------
    x : (N,) array
        Values of the axis, hours of the local clock where its label is "local clock, h".
    x_label, y_label : str
        Quantities with their units.
    lines : mapping of str to (N,) array
    upright : bool
        Whether the axis is vertical, as altitude is.
    """

    x: Any
    x_label: str
    y_label: str
    lines: Mapping[str, Any]
    upright: bool = False
    logarithmic: bool = False


CLOCK = "local clock, h"


class Result:
    """Base of results: representation in notebooks by `to_xarray`, pictures by the panels that a class gives."""

    def to_xarray(self) -> Any:
        """The result as an `xarray.Dataset`."""
        raise NotImplementedError

    def _panels(self) -> Sequence[Panel]:
        raise InputError(f"{type(self).__name__} has no picture; use to_xarray()")

    def plot(self) -> Chart:
        """The result as a picture, which notebooks show and `Chart.save` writes.

        Raises
        ------
        InputError
            The result has no picture, or more lines than a chart can distinguish.
        """
        return line_chart(self._panels(), repr(self).strip("<>"))

    def _repr_html_(self) -> str:
        text = f"<pre>{html.escape(repr(self))}</pre>"
        try:
            return text + str(self.to_xarray()._repr_html_())
        except (ModuleNotFoundError, InputError):  # without xarray
            return text


def line_chart(panels: Sequence[Panel], title: str) -> Chart:
    """Panels side by side with legends.

    Raises
    ------
    InputError
        A panel has more lines than a chart can distinguish.
    """
    for panel in panels:
        if len(panel.lines) > MOST_LINES:
            raise InputError(f"found {len(panel.lines)} lines to draw; allowed: {MOST_LINES}; choose fewer")
    with chart_style():
        figure = new_figure(6.0 * len(panels), 4.2)
        for axes, panel in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
            x = np.asarray(panel.x)
            lines = {name: np.asarray(values, float) for name, values in panel.lines.items()}
            if panel.logarithmic:
                lines = {name: np.where(y > 0, y, np.nan) for name, y in lines.items() if np.any(y > 0)}
            for name, y in lines.items():
                axes.plot(*((y, x) if panel.upright else (x, y)), label=name)
            labels = (panel.y_label, panel.x_label) if panel.upright else (panel.x_label, panel.y_label)
            axes.set(xlabel=labels[0], ylabel=labels[1])
            if panel.logarithmic:
                (axes.set_xscale if panel.upright else axes.set_yscale)("log")
            if panel.x_label == CLOCK:
                hours_of_day(axes)
            if len(lines) > 1:
                axes.legend(fontsize=8)
        figure.suptitle(title[:160], fontsize=9)
    return Chart(figure)
