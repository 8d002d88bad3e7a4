"""Ambient radiance of faces of any direction, read from the harmonics of an atmospheric table."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from skyshine.mat.radiometry.spherical_harmonics import ambient_of_faces, face_normal
from skyshine.mat.tables.atmq import AMBIENT_HARMONICS, GROUND_HARMONICS
from skyshine.mat.tables.axes import AxisRule
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Group


class Readable(Protocol):
    """A table as `loader.Table` is."""

    @property
    def path(self) -> Path: ...

    @property
    def root(self) -> Group: ...

    @property
    def attributes(self) -> dict[str, Any]: ...

    @property
    def quantities(self) -> list[str]: ...

    def rules(self, quantity: str) -> list[AxisRule]: ...


@dataclass(frozen=True)
class StatedGround:
    """What a file states of the ground around faces.

    Attributes
    ----------
    emissivity : float
    temperature : float
        K.
    radiance : float
        Emitted in the band at that temperature, W m^-2 sr^-1.
    """

    emissivity: float
    temperature: float
    radiance: float


def stated_ground(path: Path, attributes: Mapping[str, Any]) -> StatedGround:
    """The ground of a file's root attributes.

    Raises
    ------
    InputError
        One of them is missing, no number, or negative.
    """
    names = ("ground_emissivity", "ground_temperature", "ground_radiance")
    try:
        values = [float(attributes[name]) for name in names]
    except (KeyError, TypeError, ValueError):
        raise InputError(f"lacks {', '.join(names)} or one of them; build the file again", file=path) from None
    if not all(np.isfinite(value) and value >= 0 for value in values):
        raise InputError(f"states {', '.join(names)} that no ground has; build the file again", file=path)
    return StatedGround(*values)


def ambient_radiance(
    table: Readable,
    read: Callable[..., npt.NDArray[np.float64]],
    slope: npt.ArrayLike,
    azimuth: npt.ArrayLike,
    ground_temperature: npt.ArrayLike | None,
    blackbody: Callable[[npt.ArrayLike], npt.NDArray[np.float64]] | None,
    where: Mapping[str, Any],
    *,
    by_wavelength: bool,
) -> npt.NDArray[np.float64]:
    """As `loader.AtmosphereTable.ambient_radiance`, whose values `read` gives, parted by wavelength along a last axis
    or not; `blackbody` gives the band radiance (7) of temperatures in K.
    """
    level = read("ambient_radiance", **where)
    parts = level.shape[-1:] if by_wavelength else ()
    if AMBIENT_HARMONICS not in table.quantities:
        if np.any(np.asarray(slope) != 0):
            raise InputError(
                f"has no {AMBIENT_HARMONICS}; allowed: slope 0; build the file from a job whose surface_grid.slope_deg"
                " has tilted faces",
                file=table.path,
            )
        places = level.shape[:-1] if by_wavelength else level.shape
        shape = np.broadcast_shapes(places, np.shape(slope), np.shape(azimuth))
        level = level.reshape((1,) * (len(shape) - len(places)) + level.shape)
        return np.array(np.broadcast_to(level, shape + parts))
    stated = stated_ground(table.path, table.attributes)
    kelvin, emitted = np.asarray(stated.temperature), np.asarray(stated.radiance)
    if ground_temperature is not None and blackbody is not None:
        kelvin = np.asarray(ground_temperature, float)
        emitted = stated.emissivity * blackbody(kelvin)
    light = _coefficients(table, read, AMBIENT_HARMONICS, "harmonic", where)
    of_ground = {**where, "ground_temperature": kelvin}
    ground = _coefficients(table, read, GROUND_HARMONICS, "zonal_harmonic", of_ground)
    normal = face_normal(slope, azimuth)
    if by_wavelength:
        light, ground = np.swapaxes(light, -1, -2), np.swapaxes(ground, -1, -2)
        emitted, normal = emitted[..., None], normal[..., None, :]
    return ambient_of_faces(level, light, ground, emitted, normal)


def _coefficients(
    table: Readable,
    read: Callable[..., npt.NDArray[np.float64]],
    quantity: str,
    harmonic: str,
    where: Mapping[str, Any],
) -> npt.NDArray[np.float64]:
    """Values of a quantity at places, for all harmonics along the axis behind that of the places."""
    rules = {rule.name: rule for rule in table.rules(quantity)}
    place = {name: np.asarray(values)[..., None] for name, values in where.items() if name in rules}
    return read(quantity, **place, **{harmonic: rules[harmonic].nodes})
