"""The contrast of two materials through the day as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from skyshine.mat.job.fields import clock_text
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.render.contrast import Contrast
from skyshine.schemas.errors import InputError


def draw_contrast(results: Sequence[Contrast], material: str, background: str, picture: Path) -> Path:
    """Draw apparent temperatures and their difference in each band, with the crossovers.

    Raises
    ------
    InputError
        The picture cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.8 * len(results) + 0.4, 5.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, len(results), squeeze=False, sharex=True)
    for column, result in enumerate(results):
        upper, lower = axes[:, column]
        upper.plot(result.hours, result.material - ZERO_CELSIUS, label=material)
        upper.plot(result.hours, result.background - ZERO_CELSIUS, label=background)
        upper.set_title(result.band, fontsize=10)
        upper.set_ylabel("apparent temperature, deg C")
        upper.legend(fontsize=8)
        lower.axhline(0.0, color="black", lw=0.8)
        lower.plot(result.hours, result.contrast, color="tab:red")
        for hour in result.crossovers:
            lower.axvline(hour, color="grey", lw=0.8, ls="--")
            text = clock_text(round(hour * 60) / 60 % 24)
            lower.annotate(text, (hour, 1.0), xycoords=("data", "axes fraction"), fontsize=8, rotation=90, va="top")
        lower.set(xlabel="local clock, h", ylabel="contrast, K", xlim=(0, 24), xticks=range(0, 25, 3))
    try:
        figure.savefig(picture, dpi=110, metadata={"Software": None})
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}; check the folder", file=picture) from None
    return picture
