"""Errors of a pixel by what no table of a job contains, on the views of the error budget."""

from __future__ import annotations

import numpy as np

from skyshine.mat.budget.measurement import Measurement
from skyshine.mat.budget.unmodelled import (
    OBSTACLES_DEG,
    PIXEL_RAD,
    ShadedDay,
    aureole_heat,
    aureole_light,
    depth_buffer_range,
    light_of_ground,
    microfacet_reflection,
    share_beyond_edge,
)
from skyshine.mat.budget.views import NEAR_KM
from skyshine.schemas.arrays import Floats


def unmodelled_errors(measured: Measurement, generator: np.random.Generator) -> dict[str, Floats]:
    """Errors (n, M) of radiance, W m^-2 sr^-1: none of them is a source of the pixel's.

    Parameters
    ----------
    generator : numpy.random.Generator
        Random numbers for the buildings before the Sun and the material beyond an edge.
    """
    errors = _of_shade(measured, generator) if measured.truth.source == "sun" and measured.tables.shades else {}
    return errors | {"lobe": _of_lobe(measured), "depth_buffer": _of_depth(measured)} | _of_edges(measured, generator)


def _of_shade(measured: Measurement, generator: np.random.Generator) -> dict[str, Floats]:
    views, circumstances = measured.views, measured.circumstances
    day = ShadedDay(measured.tables, views, circumstances)
    building = generator.integers(len(OBSTACLES_DEG), size=len(views))
    too_warm = -day.warmer_by(-aureole_heat(measured.prepared, day, building))
    light = aureole_light(measured.prepared, views, measured.reduced_light, circumstances.in_shade)
    errors = {"aureole": _warmer(measured, too_warm) + measured.of_ambient(light)}
    of_ground = light_of_ground(day, measured.full)
    if of_ground is not None:
        errors["seen_faces"] = measured.of_ambient(of_ground)
    return errors


def _warmer(measured: Measurement, kelvin: Floats) -> Floats:
    return measured.warmer(kelvin) - measured.base


def _of_lobe(measured: Measurement) -> Floats:
    views, finish = measured.views, measured.finish
    facets = microfacet_reflection(views, views.normal, finish)
    dark = measured.circumstances.in_shade & (measured.truth.source == "sun")
    return measured.base - measured.reflected_by(np.where(dark[:, None], 0.0, facets))


def _of_depth(measured: Measurement) -> Floats:
    views = measured.views
    farthest = max(float(measured.grid.range_km.max()), float(views.range.max()))
    read = depth_buffer_range(views.range, min(NEAR_KM[0], float(views.range.min())), farthest)
    return measured.at_range(read) - measured.base


def _of_edges(measured: Measurement, generator: np.random.Generator) -> dict[str, Floats]:
    views, base = measured.views, measured.base
    count = base.shape[1]
    if count == 1:
        return {}
    share = share_beyond_edge(views.face, 1e3 * views.range * PIXEL_RAD, views.share)
    neighbour = (np.arange(count) + generator.integers(1, count, size=base.shape)) % count
    return {"aliasing": share[:, None] * (base - np.take_along_axis(base, neighbour, axis=1))}
