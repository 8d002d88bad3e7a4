"""Errors that a runtime avoids when it reads more than the classic tables, and the cost of doing so.

Each option is measured as the same error before and after. Tables that the job's build has written are read as a
runtime reads them, with interpolation, both before and after; other tables are replaced by exact computation in both.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.budget.built_tables import Tables, ViewLine, frame_centres
from skyshine.mat.budget.runtime_terms import (
    AtmosphereReadings,
    Emission,
    Finish,
    ReflectedLight,
    incidence,
    runtime_radiance,
    spectral_thermal,
)
from skyshine.mat.budget.views import Views, fold
from skyshine.mat.job.extra_tables import NORMALISATION_BY_ANGLE, WEIGHTED_TRANSMITTANCE
from skyshine.mat.quantities.emission import emission_weights
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.results import SpectralLines
from skyshine.mat.tables import response
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.band import WAVELENGTH
from skyshine.mat.tables.build_record import cost_of
from skyshine.mat.tables.channel_table import ChannelTable
from skyshine.mat.tables.channels import NODES, SOURCE_SHARE, THERMAL_SHARE
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.hdf5 import Group

FIELDS_OF_VIEW = (1.0, 2.0, 5.0, 10.0, 20.0, 40.0)  # degree
READINGS = ("centre", "profile", "frame")  # where the quantities of a pixel are read
_STARRED = ("beta_star", "path_radiance_ratio", "ambient_radiance", "direct_radiance")


@dataclass(frozen=True)
class Cost:
    """What an option costs.

    Attributes
    ----------
    bytes : int or None
        Of its arrays or file, packed; None where the job has not written it.
    seconds : float or None
        Of its build; None where it was not built, where its record is missing, or where another table's build
        includes it.
    per_frame, per_pixel : float
        Table values that a runtime reads beyond the 72 a frame of the classic tables (fewer where an axis has one
        node); not a number where the number of classes is not known.
    """

    bytes: int | None
    seconds: float | None
    per_frame: float
    per_pixel: float


@dataclass(frozen=True, eq=False)
class Option:
    """An error before and after an option.

    Attributes
    ----------
    before, after : (n, M) arrays
        W m^-2 sr^-1.
    stored : bool
        Read from tables that the job wrote.
    cost : Cost
    exact : tuple of two (n, M) arrays, optional
        Before and after, computed exactly.
    """

    before: Floats
    after: Floats
    stored: bool
    cost: Cost
    exact: tuple[Floats, Floats] | None = None


@dataclass(frozen=True, eq=False)
class BudgetViews:
    """n views of M materials as the error budget has them.

    Attributes
    ----------
    views : Views
    lines : SpectralLines
    band : BandPoints
    reflectance : (M, P) array
    kelvin, glow : (n, M) arrays
        Temperature of the surfaces, and (7) there.
    bounce : (n, M) array
        From `FacetTruth.bounce` with N_s of the very angle.
    full, read : AtmosphereReadings
        Integrated over all points; interpolated in the tables, with the light of walls.
    light : ReflectedLight or None
        As the tables have it, where they have light by wavelength.
    truth : (n, M) array
        Radiance by the integrals.
    """

    views: Views
    lines: SpectralLines
    band: BandPoints
    reflectance: Floats
    kelvin: Floats
    glow: Floats
    bounce: Floats
    full: AtmosphereReadings
    read: AtmosphereReadings
    light: ReflectedLight | None
    truth: Floats

    def classic(self, finish: Finish, bounce: Floats | None = None) -> Floats:
        """Radiance (n, M) by the note's equations with exact quantities."""
        readings = replace(self.full, emitted=None)
        emission = Emission(self.glow, finish.reflectance)
        return runtime_radiance(readings, emission, self.bounce if bounce is None else bounce, finish)


def options_of_averages(tables: Tables, seen: BudgetViews, bounce: Callable[[Finish], Floats]) -> dict[str, Option]:
    """Options against averages over band and source angle; `bounce` gives the reflection (n, M) of a finish."""
    by_angle = _by_angle(tables, seen, bounce)
    if seen.light is not None:
        return {"light_by_wavelength": _light_by_wavelength(tables, seen, seen.light)} | by_angle
    return {
        "weighted_reflectance": _weighted_reflectance(tables, seen),
        WEIGHTED_TRANSMITTANCE: _weighted_transmittance(tables, seen),
        **by_angle,
    }


def shade_option(tables: Tables, before: Floats, after: Floats) -> Option:
    """The response to shadows and walls: errors (n, M) without and with it."""
    names = (response.KERNEL, response.REFERENCE, response.LOSS_SLOPE, response.LOSS_EXCESS, response.MELT)
    size = sum(tables.surface.stored_bytes(name) for name in names)
    return Option(before, after, True, Cost(size, None, float("nan"), float("nan")))


def _light_by_wavelength(tables: Tables, seen: BudgetViews, light: ReflectedLight) -> Option:
    """Both read from the tables, with the true temperatures."""
    means = replace(seen.read, emitted=None)
    flat = Emission(seen.glow, tables.finish.reflectance)
    before = runtime_radiance(means, flat, seen.bounce, tables.finish) - seen.truth
    after = runtime_radiance(seen.read, tables.emission(seen.kelvin), seen.bounce, tables.finish, light) - seen.truth
    held = ((tables.air, (THERMAL_SHARE, SOURCE_SHARE)), (tables.band, ("reflectance_spectrum", "emission_share")))
    size = sum(table.stored_bytes(name) for table, names in held for name in names)
    wavelengths = tables.band.root.axes[WAVELENGTH].values.size
    return Option(before, after, True, Cost(size, None, 0, 3 * wavelengths))


def _weighted_reflectance(tables: Tables, seen: BudgetViews) -> Option:
    size = sum(tables.band.stored_bytes(name) for name in ("reflectance_planck", "reflectance_solar"))
    after = _shown(tables, seen, seen.full, seen.full.transmittance) - seen.truth
    return Option(seen.classic(tables.finish) - seen.truth, after, True, Cost(size, None, 0, 3))


def _shown(tables: Tables, seen: BudgetViews, readings: AtmosphereReadings, emitted_transmittance: Floats) -> Floats:
    """Equation (1) with weighted reflectances and another transmittance in (6)."""
    rho, solar = tables.weighted_reflectance(seen.kelvin)
    reflected = readings.ambient * tables.finish.reflectance + readings.direct * seen.bounce * solar
    path = readings.path_radiance_ratio * (1 - readings.transmittance)
    radiance: Floats = seen.glow * (1 - rho) * emitted_transmittance + reflected * readings.transmittance + path
    return radiance


def _weighted_transmittance(tables: Tables, seen: BudgetViews) -> Option:
    """Used together with the weighted reflectances.

    The error without interpolation is measured in the thermal term alone.
    """
    emitted = seen.glow * (1 - tables.weighted_reflectance(seen.kelvin)[0])
    thermal = spectral_thermal(seen.lines.transmittance, seen.band, seen.kelvin, seen.reflectance)
    by_material = seen.full.emitted
    if by_material is None:
        by_material = emitted_transmittance(seen.band, seen.reflectance, seen.lines, seen.kelvin)
    exact = emitted * seen.full.transmittance - thermal, emitted * by_material - thermal
    if tables.thermal is None:
        before, after = exact
        return Option(before, after, False, Cost(None, None, float("nan"), 4), exact)
    read = seen.read
    by_class = tables.emitted_transmittance(seen.views, seen.kelvin)
    before, after = (_shown(tables, seen, read, values) - seen.truth for values in (read.transmittance, by_class))
    axes, path = tables.thermal.root.axes, tables.thermal.path
    groups, nodes = (axes[name].values.size for name in ("material_class", "planck_temperature"))
    cost = Cost(
        path.stat().st_size, _seconds(path), groups * nodes * _corners(tables.thermal.root, "beta_star_thermal") // 2, 4
    )
    return Option(before, after, True, cost, exact)


def emitted_transmittance(band: BandPoints, reflectance: Floats, lines: SpectralLines, kelvin: Floats) -> Floats:
    """Transmittance (n, M) of what materials with reflectances (M, P) emit at temperatures (n, M) [K]."""
    transmittance = np.empty(kelvin.shape)
    for row, kelvins in enumerate(kelvin):
        for column, own in enumerate(kelvins):
            weights = emission_weights(band, reflectance[[column]], own)[0]
            transmittance[row, column] = weights @ lines.transmittance[row]
    return transmittance


def _by_angle(tables: Tables, seen: BudgetViews, bounce: Callable[[Finish], Floats]) -> dict[str, Option]:
    finish, cosine = tables.finish, incidence(seen.views, seen.views.normal)
    right = seen.classic(finish)

    def error_with(values: Floats) -> Floats:
        return seen.classic(finish, bounce(replace(finish, normalisation=values))) - right

    normalisation = error_with(finish.normalisation)
    coarse = Option(
        normalisation,
        error_with(tables.normalisation_at(cosine)),
        True,
        Cost(tables.band.stored_bytes("normalisation_by_angle"), None, 0, 2),
    )
    if "normalisation_fine" not in tables.band.root.variables:
        return {
            "normalisation_in_steps": coarse,
            NORMALISATION_BY_ANGLE: Option(normalisation, 0 * normalisation, False, Cost(None, None, 0, 2)),
        }
    cost = Cost(
        tables.band.stored_bytes("normalisation_fine"), _seconds(tables.band.path, NORMALISATION_BY_ANGLE), 0, 2
    )
    fine = Option(normalisation, error_with(tables.finish_at(cosine).normalisation), True, cost)
    return {"normalisation_in_steps": coarse, NORMALISATION_BY_ANGLE: fine}


def frame_errors(
    tables: Tables,
    views: Views,
    grid: PathGrid,
    offset: Floats,
    here: Floats,
    shown: Callable[[AtmosphereReadings], Floats],
    temperature: Floats | None = None,
) -> dict[str, Floats]:
    """Errors (F, n, M) of the stored tables off the centre of frames, by `FIELDS_OF_VIEW`, for each of `READINGS`.

    Parameters
    ----------
    offset : (2, n) array
        Of the pixels from the centre, in fields of view.
    here : (n, M) array
        Radiance with the quantities computed at the pixels.
    shown : callable
        Radiance (n, M) with other `AtmosphereReadings`.
    temperature : (n, M) array, optional
        Of the surfaces [K], where the transmittance of what they emit is read too.
    """
    errors: dict[str, list[Floats]] = {name: [] for name in READINGS}
    pixel = tables.readings(views, temperature=temperature)
    for width in FIELDS_OF_VIEW:
        centre = frame_centres(views, grid, offset * width)
        read = tables.readings(views, centre, temperature)
        # The same line of sight, ended at the pixel's own range.
        along = tables.readings(
            views,
            ViewLine(views.range, centre.elevation, centre.heading, centre.surface_altitude, centre.normal),
            temperature,
        )
        ways = read.at_range(centre.range, views.range), along, pixel
        for name, readings in zip(READINGS, ways, strict=True):
            errors[name].append(shown(readings) - here)
    return {name: np.array(values) for name, values in errors.items()}


def options_of_frames(
    tables: Tables, views: Views, grid: PathGrid, errors: dict[str, Floats], chosen: Integers
) -> dict[str, Option]:
    """Options against extrapolation, each view in the field of view that `chosen` (n,) counts.

    Parameters
    ----------
    errors : dict
        From `frame_errors`.
    """
    row = np.arange(len(views))
    picked = {name: values[chosen, row] for name, values in errors.items()}
    width = np.array(FIELDS_OF_VIEW)[chosen]
    elevation = grid.elevation_deg
    low, high = (np.clip(views.elevation + side * width / 2, elevation[0], elevation[-1]) for side in (-1, 1))
    azimuth = fold(views.source_azimuth - views.heading)
    parts: dict[str, list[Cost]] = {"profile": [], "frame": []}
    for i in range(len(views)):
        fixed_axes = {"altitude": views.altitude[i], "source_elevation": views.source_elevation[i]}
        parts["frame"].append(_cost(tables.air, fixed_axes | {"elevation": (low[i], high[i])}))
        parts["profile"].append(
            _cost(tables.air, fixed_axes | {"elevation": views.elevation[i], "source_azimuth": azimuth[i]})
        )
    return {
        f"{name}_of_the_tables": Option(
            picked["centre"],
            picked[name],
            True,
            Cost(
                round(float(np.mean([c.bytes for c in costs]))),
                None,
                float(np.mean([c.per_frame for c in costs])),
                costs[0].per_pixel,
            ),
        )
        for name, costs in parts.items()
    }


def _cost(table: AtmosphereTable, where: Mapping[str, float | tuple[float, float]]) -> Cost:
    """Of one frame's part of a table: bytes of its values as float32, values read to make it, and for each pixel.

    A table in channels is taken whole, each pixel reads its fields once.
    """
    if isinstance(table, ChannelTable):
        fields = [variable for variable in table.root.variables.values() if set(NODES) <= set(variable.dims)]
        count = sum(variable.data.size // np.prod(variable.data.shape[-len(NODES) :], dtype=int) for variable in fields)
        values = sum(variable.data.size for variable in table.root.variables.values() if variable.kind == "f")
        return Cost(4 * values, None, values, 2 ** len(NODES) * int(count))
    part = table.part(out_of_range="clamp", **where).root
    sizes = {name: part.variables[name].data.size for name in _STARRED}
    read = sum(size * _corners(table.root, name) // _corners(part, name) for name, size in sizes.items())
    return Cost(4 * sum(sizes.values()), None, read, sum(_corners(part, name) for name in _STARRED))


def _seconds(path: Path, stage: str | None = None) -> float | None:
    """Seconds that a file's build took without its picture, or those of one stage."""
    cost = cost_of(path)
    if cost is None:
        return None
    stages: dict[str, float] = cost["stages"]
    return float(cost["seconds"]) - stages.get("pictures", 0.0) if stage is None else stages.get(stage)


def _corners(root: Group, name: str) -> int:
    """Table values that one reading of a quantity takes."""
    dims = root.variables[name].dims
    interpolated = sum(
        root.axes[dim].values.size > 1 and root.axes[dim].attributes.get("interpolation") != "exact" for dim in dims
    )
    return int(2**interpolated)
