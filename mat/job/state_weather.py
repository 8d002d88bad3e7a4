"""Weather files in the states of a job: their hours in the place of their names, and what is to be said of them."""

from __future__ import annotations

from pathlib import Path

from skyshine.mat.job.ground import GroundYear, ground_of_latitude
from skyshine.mat.job.ground_files import ground_of_file, ground_of_header, is_whole_year
from skyshine.mat.job.model import Job
from skyshine.mat.job.plausibility import doubts, has_wrong_light, zone_doubt
from skyshine.mat.job.site import Site, great_circle
from skyshine.mat.job.surface import HOURLY_QUANTITIES
from skyshine.mat.job.typical_years import Station
from skyshine.mat.job.warnings import merged
from skyshine.mat.job.weather_files import FileWeather, read_weather
from skyshine.schemas.documents import Document
from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import job_path

Location = tuple[str | int, ...]

# `mat check` warns of a weather file of a station further away than this.
FARTHEST_STATION_KM, HIGHEST_STATION_KM = 50.0, 0.2


def with_weather_files(job: Job, document: Document) -> tuple[Job, list[str]]:
    """The job with the hours of its weather files in their places, so that nothing later depends on a file; warnings
    of files of another place.
    """
    states, warnings = list(job.states), []
    for i, state in enumerate(states):
        if state.weather.file is not None:
            file = _weather_file(document, i, state.weather.file)
            stated = [name for name in HOURLY_QUANTITIES if name in state.weather.model_fields_set]
            day = state.date or job.site.date
            readings = read_weather(
                file,
                day,
                job.site.utc_offset_h,
                radiation=state.weather.radiation == "measured",
                stated=stated,
                days_before=state.weather.history_days,
                rain=state.weather.rain,
                place=(job.site.latitude_deg, job.site.longitude_deg),
            )
            *before, hourly = (
                table.model_copy(update=dict.fromkeys(stated)) for table in (*readings.before, readings.hourly)
            )
            read = {"file": None, "hourly": hourly, "days_before": before, "rain": None}
            weather = state.weather.model_copy(update=read)
            site = job.site.model_copy(update={"date": day})
            notes = [*readings.notes, *_doubts_of_file(site, readings), *doubts(site, weather)]
            if weather.radiation is None and has_wrong_light(site, weather):
                notes.append(
                    "has light at night, so that light is computed; radiation: measured refuses the job instead"
                )
                weather = weather.model_copy(update={"radiation": "computed"})
            warnings += [(i + 1, f"weather file {state.weather.file} {text}") for text in notes]
            if weather.radiation == "computed":
                weather = weather.without_light()
            states[i] = state.model_copy(update={"weather": weather})
    return job.model_copy(update={"states": states}), merged(warnings)


def with_ground(job: Job, stated_job: Job, document: Document) -> tuple[Job, list[str]]:
    """The job, whose weather files are read, with the annual wave of the ground in the place of each word for it.

    Parameters
    ----------
    stated_job : Job
        The same before its weather files were read.
    """
    if all(state.weather.ground in (None, "air") and state.weather.file is None for state in stated_job.states):
        return job, []
    states, remarks, site = list(job.states), [], job.site
    for i, state in enumerate(states):
        ground, file = state.weather.ground, stated_job.states[i].weather.file
        if isinstance(ground, GroundYear):
            year: GroundYear | None = ground.at_latitude(site.latitude_deg)
        elif ground == "latitude":
            table = state.weather.hourly
            high = site.altitude_km if table is None or table.altitude_km is None else table.altitude_km
            year = ground_of_latitude(site.latitude_deg, high)
        elif file is not None and ground != "air":
            year, remark = _ground_of_file(_weather_file(document, i, file), ground, site)
            remarks += [(i + 1, f"weather file {file} {remark}")] if remark else []
        else:
            continue
        if isinstance(ground, str) and year is not None:
            remarks.append((i + 1, f"ground by {ground}: {year.text}"))
        states[i] = state.model_copy(update={"weather": state.weather.model_copy(update={"ground": year})})
    return job.model_copy(update={"states": states}), merged(remarks)


def _ground_of_file(file: Path, choice: str | None, site: Site) -> tuple[GroundYear | None, str]:
    """The annual wave by a weather file: as it is asked for, or of itself by a typical year, of which a part or a wrong
    reading on another day stops no job; and what is to be said of that.
    """
    if choice == "epw":
        return ground_of_header(file), ""
    if choice == "file":
        return ground_of_file(file, site.utc_offset_h), ""
    try:
        return (ground_of_file(file, site.utc_offset_h) if is_whole_year(file) else None), ""
    except InputError as error:
        line = "" if error.line is None else f"in line {error.line}: "
        return (
            None,
            f"contains no year of the ground; the mean air temperature of the days replaces it ({line}{error.message})",
        )


def _weather_file(document: Document, state: int, name: str) -> Path:
    try:
        file = job_path(document.file.resolve().parent, name)
    except ValueError as error:
        raise document.error(_place(document, state), f"states.{state}.weather.file: {error}") from None
    if not file.is_file():
        raise document.error(
            _place(document, state),
            f"states.{state}.weather.file: found '{name}', which is no file; give its path from the job's folder",
        )
    return file


def _doubts_of_file(site: Site, readings: FileWeather) -> list[str]:
    """A line each where a file is of a place far from the site, or its clock far from its place's Sun."""
    lines = [_other_place(site, readings.station)]
    if readings.station is not None and readings.utc_offset_h is not None:
        lines.append(zone_doubt(readings.utc_offset_h, readings.station.longitude, "in its header"))
    return [line for line in lines if line]


def _other_place(site: Site, station: Station | None) -> str:
    """How far a station is from the site, where that is too far; empty where it is not."""
    if station is None:
        return ""
    distance = great_circle(site.latitude_deg, site.longitude_deg, station.latitude, station.longitude)
    higher = 0.0 if station.altitude is None else station.altitude / 1e3 - site.altitude_km
    if distance <= FARTHEST_STATION_KM and abs(higher) <= HIGHEST_STATION_KM:
        return ""
    return (
        f"was measured at latitude {station.latitude:g}, longitude {station.longitude:g},"
        f" {1e3 * (site.altitude_km + higher):g} m:"
        f" {distance:.0f} km from the site and {abs(1e3 * higher):.0f} m {'above' if higher > 0 else 'below'} it"
        f" (warned beyond {FARTHEST_STATION_KM:g} km and {1e3 * HIGHEST_STATION_KM:g} m); its temperatures are carried"
        " to the site's altitude by 6.5 K/km"
    )


def _place(document: Document, state: int) -> Location:
    """Where the weather of a state is written; series make more states than are written."""
    location: Location = ("states", state, "weather", "file")
    return location if location in document.places else ("states",)


def weather_doubts(job: Job) -> list[str]:
    """What of weather that is written by hours in the job can hardly be; that of files is said where they are read."""
    return merged(
        (number, f"weather {text}")
        for number, state in enumerate(job.states, 1)
        for text in doubts(job.site.model_copy(update={"date": state.date or job.site.date}), state.weather)
    )
