"""Radiation and air at the surfaces of some columns: what the heat balance is given.

Arrays are (columns, times) or broadcast to that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import cache, cached_property

import numpy as np
import numpy.typing as npt

from skyshine.mat.surface.convection import AIR_HEIGHT, LEAST_HEIGHT, WIND_HEIGHT
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.errors import InputError

# Least values of fields that are not just positive: K, 1, m.
_LIMITS = {"air_temperature": 1.0, "cos_slope": -1.0, "wind_height": LEAST_HEIGHT, "air_height": LEAST_HEIGHT}


@dataclass(frozen=True, eq=False)
class Forcing:
    """Radiation and air at the surface of each column and time; every field is (columns, N) or broadcasts to it.

    Attributes
    ----------
    shortwave_direct, shortwave_diffuse, shortwave_reflected : ndarray
        Shortwave irradiance on the plane of the column [W m^-2].
    longwave_sky, longwave_ground : ndarray
        Longwave irradiance on the plane, view factors included [W m^-2].
    air_temperature : ndarray
        [K]
    vapour_pressure, pressure : ndarray
        [Pa]; pressure 0 is vacuum.
    wind_speed : ndarray
        [m/s]
    cos_slope : ndarray
        1 face up, 0 a wall, -1 face down.
    wind_height, air_height : ndarray
        Heights at which wind, and air temperature and humidity, were measured [m]; by default 10 and 2.
    open_light : ndarray
        Sunlight on open level ground, to which leaves open [W m^-2]; by default that on the plane.
    rain : ndarray or None
        Rain on level ground, mean of the step that ends at the time [kg m^-2 s^-1]; None: surfaces have no film of
        water.
    film : ndarray or None
        Share of the surface under a film of water, 0 to 1.
    film_below : ndarray or None
        Film on the soil in the gaps of leaves, as `film`.
    soil_moisture : ndarray or None
        Volume fraction of water in soils, 0 to 1.
    snow_age : ndarray or None
        Time since snow fell [d].
    albedo : ndarray or None
        Albedo of the surface, which replaces the material's.
    sun_cosine : ndarray or None
        Cosine of the angle between the Sun and the normal of the plane, 0 where the Sun is behind it; None: not known.
    ground_mean, ground_amplitude, ground_day : ndarray or None
        Mean [K] and amplitude [K] of the annual wave at the surface of the ground, and time since its coldest day [d];
        None: backs of ground have the mean temperature of the air.
    """

    shortwave_direct: Floats
    shortwave_diffuse: Floats
    shortwave_reflected: Floats
    longwave_sky: Floats
    longwave_ground: Floats
    air_temperature: Floats
    vapour_pressure: Floats
    pressure: Floats
    wind_speed: Floats
    cos_slope: Floats
    wind_height: Floats = field(default_factory=lambda: np.array([[WIND_HEIGHT]]))
    air_height: Floats = field(default_factory=lambda: np.array([[AIR_HEIGHT]]))
    open_light: Floats = field(default_factory=lambda: np.empty((0, 0)))
    rain: Floats | None = None
    film: Floats | None = None
    film_below: Floats | None = None
    soil_moisture: Floats | None = None
    snow_age: Floats | None = None
    albedo: Floats | None = None
    sun_cosine: Floats | None = None
    ground_mean: Floats | None = None
    ground_amplitude: Floats | None = None
    ground_day: Floats | None = None

    def __post_init__(self) -> None:
        if not np.size(self.open_light):
            on_plane = self.shortwave_direct + self.shortwave_diffuse + self.shortwave_reflected
            object.__setattr__(self, "open_light", on_plane)

    @cached_property
    def shape(self) -> tuple[int, int]:
        """(columns, N)."""
        columns, steps = np.broadcast_shapes(*(np.shape(values) for values in self.given.values()))
        return columns, steps

    @property
    def given(self) -> dict[str, Floats]:
        """The fields that it has, by name."""
        return {name: array for name in _names() if (array := getattr(self, name)) is not None}

    @classmethod
    def stacked(cls, parts: Sequence[Forcing]) -> Forcing:
        """The columns of several forcings of the same times, one after the other."""
        shapes = [part.shape for part in parts]
        stacked = {
            name: np.concatenate(
                [np.broadcast_to(getattr(part, name), shape) for part, shape in zip(parts, shapes, strict=True)]
            )
            for name in parts[0].given
        }
        return cls(**stacked)

    def columns(self, chosen: slice | Integers) -> Forcing:
        """The forcing of a slice or index array of columns."""
        return Forcing(**{name: _rows(values, chosen) for name, values in self.given.items()})

    def times(self, chosen: Integers) -> Forcing:
        """The forcing at an index array of times."""
        steps = self.shape[1]
        parts = {name: np.atleast_2d(values) for name, values in self.given.items()}
        return Forcing(**{name: part[:, chosen] if part.shape[1] == steps else part for name, part in parts.items()})

    def check(self) -> None:
        """Refuse values that no balance can have.

        Raises
        ------
        InputError
            A value is not a number, or negative where only positive makes sense; it names field, column and time.
        """
        for name, bounds in self.given.items():
            values = np.asarray(bounds, float)
            limit = _LIMITS.get(name, 0.0)
            if values.min() >= limit and values.max() < np.inf:  # false where one is not a number
                continue
            wrong = ~(np.isfinite(values) & (values >= limit))
            position = np.argwhere(np.broadcast_to(wrong, self.shape))[0]
            value = np.broadcast_to(values, self.shape)[tuple(position)]
            raise InputError(
                f"found {name} = {value:g} in column {position[0]} at time step {position[1]}; "
                f"allowed: finite numbers of at least {limit:g}; check the weather or sky that it comes from"
            )


@cache
def _names() -> tuple[str, ...]:
    """Names of the fields: `dataclasses.fields` takes longer than what is done with them."""
    return tuple(item.name for item in fields(Forcing))


def _rows(values: npt.ArrayLike, chosen: slice | Integers) -> Floats:
    """Rows of an array, or the array itself where all columns share one row."""
    values = np.asarray(values, float)
    if values.ndim < 2 or values.shape[0] == 1:
        return values
    rows: Floats = values[chosen]
    return rows
