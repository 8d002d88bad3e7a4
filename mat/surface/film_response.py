"""What a film of water changes in the response of surfaces to heat: in shade a surface stays wet for longer.

The heat loss of a surface under a film that covers the share s of it is that of the dry one and s times what a whole
film adds. A reader that knows rain, capacity and the evaporation by temperature finds s itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.film import evaporated
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.schemas.arrays import Floats, Integers

DRY_FILM = np.zeros((1, 1))


@dataclass(frozen=True, eq=False)
class FilmResponse:
    """A whole film of water on some columns, at hours of the day and offsets of temperature.

    Attributes
    ----------
    heat_loss : ndarray, shape (columns, H, O)
        Above that of the dry surface, without sunlight [W m^-2].
    evaporation : ndarray, shape (columns, H, O)
        [kg m^-2 s^-1]; negative where dew falls.
    sunlight : ndarray, shape (columns, H)
        Absorbed above that of the dry surface [W m^-2].
    dry_sunlight : ndarray, shape (columns, H)
        Absorbed by the dry surface [W m^-2].
    before : ndarray, shape (columns,)
        Water at midnight before the day [kg m^-2].
    """

    heat_loss: Floats
    evaporation: Floats
    sunlight: Floats
    dry_sunlight: Floats
    before: Floats

    @classmethod
    def empty(cls, columns: int, hours: int, offsets: int) -> FilmResponse:
        """Response of surfaces on which no water stays."""
        loss, evaporation = np.zeros((2, columns, hours, offsets))
        sunlight, dry_sunlight = np.zeros((2, columns, hours))
        return cls(loss, evaporation, sunlight, dry_sunlight, np.zeros(columns))

    def put(self, columns: Integers, part: FilmResponse) -> None:
        """Write the response of some columns."""
        for field in fields(self):
            getattr(self, field.name)[columns] = getattr(part, field.name)


def under_film(forcing: Forcing, share: Floats) -> Forcing:
    """A forcing with a film that covers a share of all columns; without rain surfaces know no film."""
    return forcing if forcing.rain is None else replace(forcing, film=share)


def film_response(
    material: SurfaceMaterial, forcing: Forcing, temperatures: Sequence[Floats], before: Floats
) -> FilmResponse:
    """Film response of columns of a material with a film.

    Parameters
    ----------
    forcing : Forcing
        Forcing with rain, at H hours.
    temperatures : sequence of O ndarray, shape (columns, H)
        Those of the offsets [K].
    before : ndarray, shape (columns,)
        Water at midnight before the day [kg m^-2].
    """
    dry, wet = (Balance(under_film(forcing, DRY_FILM + share), material) for share in (0.0, 1.0))
    shape = forcing.shape
    sunlight = wet.shortwave - dry.shortwave + np.zeros(shape)
    more = [wet.loss(kelvin) - dry.loss(kelvin) + sunlight for kelvin in temperatures]
    water = [evaporated(material, forcing, kelvin) for kelvin in temperatures]
    return FilmResponse(
        np.stack(more, axis=-1), np.stack(water, axis=-1), sunlight, dry.shortwave + np.zeros(shape), before
    )
