"""Errors of stored tables off the centre of a frame, by field of view and by where a runtime reads them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from skyshine.mat.budget.built_tables import Tables, frame_centres
from skyshine.mat.budget.runtime_terms import AtmosphereReadings
from skyshine.mat.budget.views import Views
from skyshine.mat.quantities.grid import PathGrid
from skyshine.schemas.arrays import Floats

FIELDS_OF_VIEW = (1.0, 2.0, 5.0, 10.0, 20.0, 40.0)  # degree
# Where the quantities of a pixel are read: at the centre of its frame, along the centre's line, at the pixel.
READINGS = ("centre", "profile", "frame")


def frame_errors(
    tables: Tables,
    views: Views,
    grid: PathGrid,
    offset: Floats,
    here: Floats,
    radiance: Callable[[AtmosphereReadings], Floats],
    temperature: Floats | None = None,
) -> dict[str, Floats]:
    """Errors (F, n, M) of the stored tables off the centre of frames, by `FIELDS_OF_VIEW`, for each of `READINGS`.

    Parameters
    ----------
    offset : (2, n) array
        Offset of the pixels from the centre, in fields of view.
    here : (n, M) array
        Radiance with the quantities computed at the pixels.
    radiance : callable
        Radiance (n, M) with other `AtmosphereReadings`.
    temperature : (n, M) array, optional
        Temperature of the surfaces [K], if the transmittance of what they emit is read too.
    """
    errors: dict[str, list[Floats]] = {name: [] for name in READINGS}
    pixel = tables.readings(views, temperature)
    for width in FIELDS_OF_VIEW:
        centre = frame_centres(views, grid, offset * width)
        read = tables.readings(centre, temperature)
        # The same line of sight, ended at the pixel's own range.
        along = tables.readings(replace(centre, range=views.range), temperature)
        ways = read.at_range(centre.range, views.range), along, pixel
        for name, readings in zip(READINGS, ways, strict=True):
            errors[name].append(radiance(readings) - here)
    return {name: np.array(values) for name, values in errors.items()}
