"""The ``.htt`` database, written and read."""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.surface.response_nodes import LAG_STARTS, OFFSETS, RESPONSE_HOURS
from skyshine.mat.surface.surroundings import WALL_EMISSIVITY, Exposure, Surroundings
from skyshine.mat.tables import film_response as wet
from skyshine.mat.tables import response
from skyshine.mat.tables import shade as light
from skyshine.mat.tables.axes import CLOCK_UNIT, EXACT, LINEAR, PERIODIC, table_axis
from skyshine.mat.tables.files import HTT
from skyshine.mat.tables.kernel_tables import kernel_tables, messages
from skyshine.mat.tables.named_materials import with_names
from skyshine.mat.tables.open_air import OpenAir
from skyshine.mat.tables.table import Table
from skyshine.mat.tables.tracks import SourceTrack, source_track
from skyshine.schemas.arrays import Floats
from skyshine.schemas.digits import rounded_to
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Group, Variable
from skyshine.schemas.hdf5_digest import DIFFERENCES

if TYPE_CHECKING:
    from skyshine.mat.surface.enclosure import Enclosure
    from skyshine.mat.surface.forcing import Scene
    from skyshine.mat.surface.response import FilmTable, ResponseTable
    from skyshine.mat.surface.table import SurfaceTemperatures
    from skyshine.schemas.hdf5 import Axis

    Fields = tuple[dict[str, Axis], dict[str, Variable]]

# Steps of what is stored of light [W m^-2], air [K] and the share of light around the Sun.
_LIGHT_STEP, _AIR_STEP, _SHARE_STEP = 2.0**-4, 2.0**-6, 2.0**-10
COLUMN = ("material", "altitude", "azimuth", "slope")
_PLACE = COLUMN[1:]


def material_axis(codes: Sequence[int]) -> Axis:
    """The axis of material codes."""
    return table_axis(np.asarray(codes, np.int32), "1", "material code", interpolation=EXACT)


def htt_group(
    table: SurfaceTemperatures,
    codes: Sequence[int],
    names: Sequence[str],
    axes: dict[str, Any],
    accuracy: Group,
    attributes: dict[str, Any],
    *,
    midnight: str | None = None,
    whole_day: bool = True,
    shade: Fields | None = None,
    tracks: Fields | None = None,
    turbulence: Fields | None = None,
) -> Group:
    """Arrange the temperatures of a state for writing.

    Parameters
    ----------
    table : SurfaceTemperatures
        temperature (M, A, Z, S, T) and one diagnostic of each column (M, A, Z, S).
    codes, names : (M,)
        Codes and names of the materials, codes ascending.
    axes : dict
        altitude_km, azimuth_deg, slope_deg, time_h.
    attributes : dict
        State, site and weather, for the root.
    midnight : str, optional
        Time at which the day of the table begins, as `midnight_of` writes it; without it the hours belong to no date.
    whole_day : bool
        The times close to a day; otherwise they are a part of it, from 0 on and beyond 24 after midnight.
    shade : tuple of dict, optional
        Axes and arrays of `shade_fields`.
    tracks : tuple of dict, optional
        Axes and arrays of `tracks.track_fields`.
    turbulence : tuple of dict, optional
        Axes and array of Cn2.
    """
    column_axes = {
        "material": material_axis(codes),
        "altitude": table_axis(axes["altitude_km"], "km", "surface altitude above sea level"),
        "azimuth": table_axis(
            axes["azimuth_deg"],
            "degree",
            "azimuth that the surface faces, from north eastward",
            interpolation=PERIODIC,
            period=360.0,
        ),
        "slope": table_axis(axes["slope_deg"], "degree", "slope of the surface; 0 faces up, 90 is a wall"),
    }
    all_axes = column_axes | {
        "time": table_axis(
            axes["time_h"],
            CLOCK_UNIT if midnight is None else f"hours since {midnight}",
            "local clock time of day",
            interpolation=PERIODIC if whole_day else LINEAR,
            period=24.0,
            standard_name=None if midnight is None else "time",
        )
    }
    variables = {
        "temperature": Variable(
            (*COLUMN, "time"),
            table.temperature,
            "K",
            "surface temperature",
            {"standard_name": "surface_temperature"},
        ),
        "material_name": Variable(("material",), np.asarray(names, object), "1", "material name"),
    }
    diagnostics = {
        "residual": Variable(COLUMN, table.residual, "W m^-2", "largest residual of the surface heat balance"),
        "energy_closure": Variable(
            COLUMN, table.energy_closure, "W m^-2", "daily mean of the heat that does not close"
        ),
        "bound_excess": Variable(COLUMN, table.bound_excess, "K", "how far a temperature leaves its physical bounds"),
        "method": Variable(COLUMN, table.method, "1", "method that solved the column", {"comment": table.method_names}),
        "iterations": Variable(COLUMN, table.iterations, "1", "iterations of the solver"),
    }
    for fields in (shade, tracks, turbulence):
        if fields is not None:
            all_axes |= fields[0]
            variables |= fields[1]
    groups = {"diagnostics": Group(column_axes, diagnostics), "accuracy": accuracy}
    return Group(all_axes, with_names(variables), groups, attributes)


def midnight_of(date: dt.date, utc_offset_h: float) -> str:
    """The begin of a local day as CF writes a time of reference.

    >>> midnight_of(dt.date(2026, 6, 28), -3.5)
    '2026-06-28 00:00:00 -03:30'
    """
    minutes = round(60 * abs(utc_offset_h))
    return f"{date.isoformat()} 00:00:00 {'-' if utc_offset_h < 0 else '+'}{minutes // 60:02d}:{minutes % 60:02d}"


def enclosure_attributes(enclosure: Enclosure) -> dict[str, Any]:
    """Root attributes of the ground and the walls around the surfaces of a table."""
    attributes: dict[str, Any] = {
        "ground_emissivity": enclosure.ground.emissivity,
        "ground_albedo": enclosure.ground.albedo,
    }
    if not enclosure.open:
        attributes |= {
            "horizon_azimuth": np.array(enclosure.horizon.azimuth),
            "horizon_elevation": np.array(enclosure.horizon.elevation),
            "sky_view": enclosure.sky_view,
            "level_sky_view": float(enclosure.between.sky[0]),
            "wall_emissivity": enclosure.walls.emissivity,
            "wall_albedo": enclosure.walls.albedo,
        }
    return attributes


def shade_fields(table: ResponseTable, scene: Scene) -> Fields:
    """Axes and arrays with which a runtime shades surfaces.

    Parameters
    ----------
    scene : Scene
        Its altitudes are those of the temperatures.
    """
    steps = response.FORCING_STEPS
    axes = {
        response.ALTITUDE: table_axis(table.altitudes_m / 1e3, "km", "surface altitude at which the response is given"),
        response.SLOPE: table_axis(table.slopes_deg, "degree", "slope of the surface whose response is given"),
        response.HOUR: table_axis(
            RESPONSE_HOURS, CLOCK_UNIT, "local clock time of the response", interpolation=PERIODIC, period=24.0
        ),
        response.LAG: table_axis(
            LAG_STARTS, CLOCK_UNIT, "where a cell of lag begins; the last ends 24 h after the first begins"
        ),
        response.OFFSET: table_axis(OFFSETS, "K", "temperature above response_temperature"),
        light.FORCING_TIME: table_axis(
            response.forcing_hours(),
            CLOCK_UNIT,
            "local clock time of light and air",
            interpolation=PERIODIC,
            period=24.0,
        ),
    }
    column = ("material", response.ALTITUDE, response.SLOPE, response.HOUR)
    sky = ("altitude", light.FORCING_TIME)
    stored = (*[_LIGHT_STEP] * 3, _AIR_STEP, _SHARE_STEP)
    direct, diffuse, longwave, air, aureole = (
        rounded_to(values, step).astype(np.float32) for values, step in zip(scene.open_air(steps), stored, strict=True)
    )
    sun = (
        np.asarray(angle, float)[:: len(angle) // steps].astype(np.float32)
        for angle in (scene.sun.solar_elevation, scene.sun.solar_azimuth)
    )
    elevation, azimuth = sun
    variables = {
        response.KERNEL: Variable(
            (*column, response.LAG),
            table.kernel,
            "K m^2 W^-1",
            "change of temperature per mean change of absorbed heat over the cell of lag",
        ),
        response.REFERENCE: Variable(column, table.temperature, "K", "air temperature, from which offsets count"),
        response.LOSS_SLOPE: Variable(
            column, table.loss_slope, "W m^-2 K^-1", "mean derivative of the heat loss by temperature"
        ),
        response.LOSS_EXCESS: Variable(
            (*column, response.OFFSET),
            table.loss_excess,
            "W m^-2",
            "heat loss above that at response_temperature, less the slope times the offset",
            {DIFFERENCES: f"{response.SLOPE} {response.HOUR}"},
        ),
        light.ABSORPTANCE: Variable(("material",), table.solar_absorptance, "1", "solar absorptance"),
        light.EMISSIVITY: Variable(("material",), table.thermal_emissivity, "1", "thermal emissivity"),
        response.MELT: Variable(column, table.melt, "W m^-2", "heat spent on melting"),
        response.HIGHEST: Variable(
            ("material",), table.highest, "K", "temperature that the surface cannot exceed because it melts"
        ),
        light.DIRECT: Variable(sky, direct, "W m^-2", "direct normal irradiance"),
        light.AUREOLE: Variable(
            (light.FORCING_TIME,),
            aureole[0],  # at the lowest altitude: it differs with altitude by the light of clouds alone
            "1",
            "share of the diffuse sunlight that comes from around the Sun, and goes with the direct light",
        ),
        light.DIFFUSE: Variable(sky, diffuse, "W m^-2", "diffuse sunlight on a level surface"),
        light.LONGWAVE: Variable(sky, longwave, "W m^-2", "longwave of the whole sky on a level surface"),
        light.AIR: Variable(sky, air, "K", "air temperature, and that of ground and of walls that have none"),
        light.SUN_ELEVATION: Variable((light.FORCING_TIME,), elevation, "degree", "elevation of the Sun"),
        light.SUN_AZIMUTH: Variable(
            (light.FORCING_TIME,), azimuth, "degree", "azimuth of the Sun, from north eastward"
        ),
    }
    if table.film is not None:
        variables |= _film_fields(table.film, column)
    return axes, with_names(variables)


def _film_fields(film: FilmTable, column: tuple[str, ...]) -> dict[str, Variable]:
    """Arrays with which a runtime keeps surfaces wet."""
    table = (*column, response.OFFSET)
    variables = {
        wet.LOSS: Variable(
            table,
            film.heat_loss,
            "W m^-2",
            "heat loss of a surface wholly under a film of water above that of the dry one, without sunlight",
        ),
        wet.EVAPORATION: Variable(
            table,
            film.evaporation,
            "kg m^-2 s^-1",
            "water that a surface wholly under a film loses, negative where dew falls",
        ),
        wet.SUNLIGHT: Variable(
            column, film.sunlight, "W m^-2", "sunlight that a surface wholly under a film absorbs above the dry one"
        ),
        wet.DRY_SUNLIGHT: Variable(column, film.dry_sunlight, "W m^-2", "sunlight that the dry surface absorbs"),
        wet.CAPACITY: Variable(("material",), film.capacity, "kg m^-2", "water that stays on the surface, 0 for none"),
        wet.RAIN: Variable((light.FORCING_TIME,), film.rain, "kg m^-2 s^-1", "rain on level ground"),
    }
    if film.before is not None:
        variables[wet.BEFORE] = Variable(
            column[:3], film.before, "kg m^-2", "water on the surface at midnight before the day"
        )
    return variables


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
            Altitude of the surface; by default the lowest of the table.
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
            A value is missing or outside its axis, or there is a change and the file has no response to it.
        """
        coordinates = self._place(slope, altitude=altitude, azimuth=azimuth, time=time)
        sunlit = self.value("temperature", material=material, **coordinates)
        if absorbed_change is None:
            return sunlit
        return self._heated(material, coordinates, np.asarray(absorbed_change, float))

    def _heated(self, material: Any, coordinates: Mapping[str, npt.ArrayLike], absorbed: Floats) -> Floats:
        """Temperatures at places under a change of absorbed heat (..., n); a column is computed once."""
        response.need_response(self.root)
        if absorbed.ndim == 0 or absorbed.shape[-1] == 0:
            raise InputError(
                "absorbed_change: found no steps or a value that is not finite; allowed: finite W m^-2 by time"
            )
        columns = [self.material_codes(material), *(np.asarray(coordinates[name], float) for name in _PLACE)]
        hours, changes = np.asarray(coordinates["time"], float), absorbed[..., 0]
        shape = np.broadcast_shapes(*(values.shape for values in (*columns, hours, changes)))
        once = all(values.ndim == 0 or values.shape[-1] == 1 for values in (*columns, changes))
        rows = (*shape[:-1], 1) if once and shape else shape
        faces = [np.broadcast_to(values, rows).ravel() for values in columns]
        heat = np.broadcast_to(absorbed, (*rows, absorbed.shape[-1])).reshape(-1, absorbed.shape[-1])
        times = np.broadcast_to(hours, shape).reshape(len(heat), -1)
        with messages(self.path):
            kelvin = kernel_tables(self).heated(faces, heat, times)
        return kelvin.reshape(shape)

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
        surroundings = Surroundings(tuple((float(a), float(b)) for a, b in shade), sky_view, facing, facing_emissivity)
        shaded = Exposure.of(surroundings, response.forcing_hours(), response.DAY_H / response.FORCING_STEPS)
        return self.exposed_change(shaded, material=material, altitude=altitude, azimuth=azimuth, slope=slope)

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
            Exposure of the P surfaces, in 288 steps of the day, each centred on its time, the first on midnight.
        material, altitude, azimuth, slope
            As in `temperature`; together of the shape (P,).
        """
        coordinates = self._place(slope, altitude=altitude, azimuth=azimuth)
        response.need_response(self.root)
        response.need_parts(self.root, light.LIGHT)
        columns = np.broadcast_arrays(
            self.material_codes(material), *(np.asarray(coordinates[name]) for name in _PLACE)
        )
        faces, view = [values.ravel() for values in columns], np.asarray(exposure.sky_view, float)
        facing = None if isinstance(exposure.facing, np.ndarray) else exposure.facing
        with messages(self.path):
            change = kernel_tables(self).absorbed(faces, exposure.shaded, view, facing, exposure.facing_emissivity)
        if isinstance(exposure.facing, np.ndarray) or np.any(exposure.wall_light):
            absorptance, emissivity = (
                self.value(name, material=faces[0]) for name in (light.ABSORPTANCE, light.EMISSIVITY)
            )
            walls = exposure if facing is None else replace(exposure, facing=None)
            change = change + OpenAir.of(self.root).heat_of_walls(walls, faces[1], faces[3], absorptance, emissivity)
        return change.reshape(*columns[0].shape, response.FORCING_STEPS)

    def _place(self, slope: npt.ArrayLike | None, **arguments: npt.ArrayLike | None) -> dict[str, npt.ArrayLike]:
        """Values by axis: those given; else slope 0, the lowest altitude, of level faces any azimuth, the only hour."""
        nodes = {name: np.asarray(axis.values) for name, axis in self.root.axes.items()}
        if slope is None:
            slope = 0.0 if nodes["slope"].size > 1 else nodes["slope"][0]
        level = not np.any(np.asarray(slope))
        coordinates: dict[str, npt.ArrayLike] = {"slope": slope}
        for name, value in arguments.items():
            optional = name == "altitude" or (name == "azimuth" and level) or nodes[name].size == 1
            if value is None and not optional:
                units = CLOCK_UNIT if name == "time" else self.root.axes[name].units
                span = f"{nodes[name][0]:g} to {nodes[name][-1]:g} {units}"
                raise InputError(f"a temperature needs '{name}'; give {name}, {span}", file=self.path)
            coordinates[name] = nodes[name][0] if value is None else value
        return coordinates

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
        """Directions of the Sun or the Moon on the file's date and in the night after it.

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
