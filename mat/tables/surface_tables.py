"""Databases of surfaces: temperatures through the day, and the properties of a band."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.surface.surroundings import WALL_EMISSIVITY, Exposure, Surroundings
from skyshine.mat.tables import response
from skyshine.mat.tables.axes import CLOCK_UNIT
from skyshine.mat.tables.band import WAVELENGTH
from skyshine.mat.tables.files import BAND, HTT
from skyshine.mat.tables.shade import absorbed_change
from skyshine.mat.tables.table import Table
from skyshine.mat.tables.tracks import SourceTrack, source_track
from skyshine.schemas.errors import InputError

_PLACE = ("altitude", "azimuth", "slope")


class TemperatureTable(Table):
    """A ``.htt`` database."""

    filetypes = (HTT.name,)

    def temperature(
        self,
        *,
        material: Any,
        altitude: npt.ArrayLike | None = None,
        azimuth: npt.ArrayLike | None = None,
        slope: npt.ArrayLike | None = None,
        time: npt.ArrayLike | None = None,
        absorbed_change: npt.ArrayLike | None = None,
    ) -> npt.NDArray[np.float64]:
        """Surface temperature in kelvin.

        Parameters
        ----------
        material : int, str or array
            Code or name.
        altitude : km
            By default the lowest of the table.
        azimuth, slope : degree
            The face looks towards `azimuth`, from north eastward; by default level. A tilted face needs its azimuth.
        time : h
            Local clock.
        absorbed_change : (..., n) array_like, optional
            Heat that the surface absorbs beside that of the table [W m^-2], less where negative: means over n equal
            steps of the day, each centred on its time, the first on midnight; taken as every day's. The axes before
            the last are broadcast against the other arguments.

        Raises
        ------
        InputError
            A value is missing or outside its axis, or there is a change and the file holds no response to it.
        """
        place = self._place(slope, altitude=altitude, azimuth=azimuth, time=time)
        sunlit = self.value("temperature", material=material, **place)
        if absorbed_change is None:
            return sunlit
        history = partial(self.value, "temperature")
        column = {"material": self.material_codes(material)} | {name: place[name] for name in _PLACE}
        heat = np.asarray(absorbed_change, float)
        change = response.temperature_change(self.root, history, column, place["time"], heat)
        highest = self.value(response.HIGHEST, material=material)
        return np.asarray(np.where(change == 0, sunlit, np.minimum(sunlit + change, np.maximum(highest, sunlit))))

    def absorbed_change(
        self,
        *,
        material: Any,
        altitude: npt.ArrayLike | None = None,
        azimuth: npt.ArrayLike | None = None,
        slope: npt.ArrayLike | None = None,
        shade: Sequence[tuple[float, float]] = (),
        sky_view: float = 1.0,
        facing: float | None = None,
        facing_emissivity: float = WALL_EMISSIVITY,
    ) -> npt.NDArray[np.float64]:
        """Change of the heat that surfaces absorb, by a shadow and a wall that hides part of the sky [W m^-2].

        Parameters
        ----------
        material, altitude, azimuth, slope
            As in `temperature`.
        shade : sequence of (first, last)
            Clock hours in which no light comes from the direction of the Sun; over midnight where the first is later.
        sky_view : float
            Open share of the sky above the surface, 0 to 1; the rest is a wall, which reflects no sunlight.
        facing : float, optional
            Temperature of that wall [K]; by default that of the air.
        facing_emissivity : float

        Returns
        -------
        (..., 288) ndarray
            Of the broadcast shape of the arguments, for `temperature`.
        """
        around = Surroundings(tuple((float(a), float(b)) for a, b in shade), sky_view, facing, facing_emissivity)
        place = self._place(slope, altitude=altitude, azimuth=azimuth)
        places = [np.asarray(place[name], float) for name in _PLACE]
        return absorbed_change(self.root, around, self.material_codes(material), *places)

    def exposed_change(
        self,
        exposure: Exposure,
        *,
        material: Any,
        altitude: npt.ArrayLike | None = None,
        azimuth: npt.ArrayLike | None = None,
        slope: npt.ArrayLike | None = None,
    ) -> npt.NDArray[np.float64]:
        """As `absorbed_change`, for surfaces each of which has shade and a sky view of its own.

        Parameters
        ----------
        exposure : Exposure
            Of the P surfaces, in 288 steps of the day, each centred on its time, the first on midnight.
        material, altitude, azimuth, slope
            As in `temperature`; together of the shape (P,).
        """
        place = self._place(slope, altitude=altitude, azimuth=azimuth)
        places = [np.asarray(place[name], float) for name in _PLACE]
        return absorbed_change(self.root, exposure, self.material_codes(material), *places)

    def _place(self, slope: npt.ArrayLike | None, **given: npt.ArrayLike | None) -> dict[str, npt.ArrayLike]:
        """Values by axis: those given; else slope 0, the lowest altitude, of level faces any azimuth, the only hour.

        Axes that a part of a table has no more are left out.
        """
        nodes = {name: np.asarray(axis.values) for name, axis in self.root.axes.items()}
        if slope is None and "slope" in nodes:
            slope = 0.0 if nodes["slope"].size > 1 else nodes["slope"][0]
        level = slope is not None and not np.any(np.asarray(slope))
        place: dict[str, npt.ArrayLike] = {} if slope is None else {"slope": slope}
        for name, value in given.items():
            if value is not None:
                place[name] = value
            elif name in nodes:
                if nodes[name].size > 1 and name != "altitude" and not (name == "azimuth" and level):
                    units = CLOCK_UNIT if name == "time" else self.root.axes[name].units
                    span = f"{nodes[name][0]:g} to {nodes[name][-1]:g} {units}"
                    raise InputError(f"a temperature needs '{name}'; give {name}, {span}", file=self.path)
                place[name] = nodes[name][0]
        return place

    def sunlit_temperature(self, *, material: Any, **where: Any) -> npt.NDArray[np.float64]:
        """Temperature in kelvin of surfaces on which the Sun shines all day; `where` as in `temperature`."""
        return self.temperature(material=material, **where)

    def shaded_temperature(
        self,
        *,
        material: Any,
        sky_view: float = 1.0,
        facing: float | None = None,
        facing_emissivity: float = WALL_EMISSIVITY,
        **where: Any,
    ) -> npt.NDArray[np.float64]:
        """Temperature in kelvin of surfaces that are in the shade all day.

        Parameters
        ----------
        material, **where
            As in `temperature`.
        sky_view, facing, facing_emissivity
            As in `absorbed_change`.
        """
        column = {name: where[name] for name in _PLACE if name in where}
        change = self.absorbed_change(
            material=material,
            **column,
            shade=[(0.0, 24.0)],
            sky_view=sky_view,
            facing=facing,
            facing_emissivity=facing_emissivity,
        )
        return self.temperature(material=material, **where, absorbed_change=change)

    def source_track(self, source: str, *, time: npt.ArrayLike) -> SourceTrack:
        """Where the Sun or the Moon stands on the file's date and in the night after it.

        Parameters
        ----------
        source : {'sun', 'moon'}
        time : h
            Local clock, 0 to 36.

        Raises
        ------
        InputError
            Another source, a time beyond the track, or a file without tracks.
        """
        return source_track(self.root, source, time)


@dataclass(frozen=True, eq=False)
class BandSpectra:
    """Spectra in a band, linear between B wavelengths.

    Attributes
    ----------
    wavelength : (B,) array
        um.
    reflectance : (..., B) array
    emission : (..., B) array
        Share of each wavelength in the radiance of a black body.
    """

    wavelength: npt.NDArray[np.float64]
    reflectance: npt.NDArray[np.float64]
    emission: npt.NDArray[np.float64]


class BandTable(Table):
    """A ``.band`` database."""

    filetypes = (BAND.name,)

    def blackbody_radiance(self, temperature: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Band radiance of a black body, equation (7), W m^-2 sr^-1, at `temperature` in kelvin."""
        return self.value("blackbody_radiance", temperature=temperature)

    def spectra(self, *, material: Any, temperature: npt.ArrayLike) -> BandSpectra:
        """Reflectance and emission by wavelength, of materials at temperatures in kelvin.

        Temperatures beyond those of the table have the shares at its ends.

        Raises
        ------
        InputError
            A material that the table lacks.
        """
        nodes = np.asarray(self.root.axes[WAVELENGTH].values, float)
        where: dict[str, Any] = {WAVELENGTH: nodes}
        codes, kelvin = self.material_codes(material)[..., None], np.asarray(temperature, float)[..., None]
        return BandSpectra(
            nodes,
            self.value("reflectance_spectrum", material=codes, **where),
            self.clamped("planck_temperature").value("emission_share", planck_temperature=kelvin, **where),
        )

    def normalisation(self, *, material: Any, angle: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """N_s of (43) at angles of incidence in degree, 0 to 75."""
        return self.value("normalisation_by_angle", material=material, source_angle=angle)
