"""Weather tables as their publishers write them: which columns they have, in which units, at which times.

References
----------
Iowa Environmental Mesonet, ASOS/METAR download; NREL, NSRDB PSM in SAM CSV; European Commission JRC, PVGIS hourly and
TMY CSV; Meteostat, hourly data; Driemel et al. (2018), Earth Syst. Sci. Data 10, 1491: BSRN, as PANGAEA writes it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta, timezone, tzinfo
from pathlib import Path
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np

from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.mat.surface.weather_readings import RADIATION_COLUMNS, WEATHER_COLUMNS, Column, Readings
from skyshine.schemas.arrays import Floats
from skyshine.schemas.column_names import folded
from skyshine.schemas.csv_table import cells, delimiter_of
from skyshine.schemas.errors import InputError

MOST_ROWS = 1_200_000  # two years of minutes
_FARTHEST_ZONE = 14.0  # h
_MISSING = re.compile(r"|m|null|none|nan|-?999+(\.0*)?|-99\.9+", re.IGNORECASE)
_DEW = {"dew_point": Column(WEATHER_COLUMNS["air_temperature"].units, 100.0, 350.0)}
# METAR sky cover in oktas (WMO-No. 306, FM 15): the middle of few (1 to 2), scattered (3 to 4), broken (5 to 7).
SKY_COVER = {
    **dict.fromkeys(("CLR", "SKC", "NSC", "NCD", "CAVOK"), 0.0),
    "FEW": 1.5 / 8,
    "SCT": 3.5 / 8,
    "BKN": 6.0 / 8,
    **dict.fromkeys(("OVC", "VV"), 1.0),
}


@dataclass(frozen=True)
class Form:
    """How a publisher writes weather.

    Attributes
    ----------
    mark : str
        Regular expression that its text begins with, at the latest in the line of column names.
    columns : dict of str to (str, str)
        Columns by folded name: the quantity of `WEATHER_COLUMNS`, dew_point or sky_cover, and its unit.
    centred : bool
        Whether light is of the time about a row; otherwise it is of the time that ends there.
    typical : bool
        Whether its months are of several years.
    """

    title: str
    mark: str
    columns: Mapping[str, tuple[str, str]]
    centred: bool = False
    typical: bool = False


_PVGIS = {
    "t2m": ("air_temperature", "C"),
    "rh": ("relative_humidity", "%"),
    "ws10m": ("wind_speed", "m/s"),
    "sp": ("pressure", "Pa"),
    "g(h)": ("sw_down", "W/m2"),
    "g(i)": ("sw_down", "W/m2"),
    "gb(n)": ("direct_normal", "W/m2"),
    "gd(h)": ("diffuse", "W/m2"),
    "ir(h)": ("lw_down", "W/m2"),
}
FORMS = (
    Form(
        "ASOS/METAR of the Iowa Environmental Mesonet",
        r"(#[^\n]*\n)*station,valid[,\[(]",
        {
            "tmpf": ("air_temperature", "F"),
            "tmpc": ("air_temperature", "C"),
            "dwpf": ("dew_point", "F"),
            "dwpc": ("dew_point", "C"),
            "relh": ("relative_humidity", "%"),
            "sknt": ("wind_speed", "kt"),
            **dict.fromkeys(("skyc1", "skyc2", "skyc3", "skyc4"), ("sky_cover", "")),
        },
    ),
    Form(
        "NSRDB PSM",
        r"Source,Location ID,",
        {
            "temperature": ("air_temperature", "C"),
            "dew_point": ("dew_point", "C"),
            "relative_humidity": ("relative_humidity", "%"),
            "wind_speed": ("wind_speed", "m/s"),
            "pressure": ("pressure", "hPa"),
            "ghi": ("sw_down", "W/m2"),
            "dni": ("direct_normal", "W/m2"),
            "dhi": ("diffuse", "W/m2"),
        },
        centred=True,
    ),
    Form("PVGIS typical year", r"Latitude \(decimal degrees\):[\s\S]{0,4000}?\ntime\(UTC\)", _PVGIS, True, True),
    Form("PVGIS hourly", r"Latitude \(decimal degrees\):", _PVGIS, centred=True),
    Form(
        "BSRN of PANGAEA",
        r"/\* DATA DESCRIPTION",
        {
            "t2": ("air_temperature", "C"),
            "rh": ("relative_humidity", "%"),
            "popopopo": ("pressure", "hPa"),
            "swd": ("sw_down", "W/m2"),
            "dir": ("direct_normal", "W/m2"),
            "dif": ("diffuse", "W/m2"),
            "lwd": ("lw_down", "W/m2"),
        },
    ),
    Form(
        "Meteostat hourly",
        r"(time|date,hour),temp,(dwpt|rhum),",
        {
            "temp": ("air_temperature", "C"),
            "dwpt": ("dew_point", "C"),
            "rhum": ("relative_humidity", "%"),
            "wspd": ("wind_speed", "km/h"),
            "prcp": ("rain", "mm/h"),
        },
    ),
)
# Columns that are left alone although they bear a quantity's name, with why.
_LEFT = {
    "alti": "pressure reduced to sea level",
    "mslp": "pressure reduced to sea level",
    "pres": "pressure reduced to sea level",
}


@dataclass(frozen=True, eq=False)
class FormTable:
    """A table of one of the forms.

    Attributes
    ----------
    readings : Readings
        Time in seconds since 1970, UTC; cells that are missing are NaN.
    location : (3,) tuple of float or None
        Latitude, longitude [degree] and altitude [m] that the file states.
    """

    form: Form
    readings: Readings
    location: tuple[float, float, float] | None
    notes: tuple[str, ...]


def form_of(text: str) -> Form | None:
    """The form of a text; None for a table of our own."""
    return next((form for form in FORMS if re.match(form.mark, text)), None)


def read_form(text: str, file: Path, form: Form) -> FormTable:
    """The table of a text in a form.

    Raises
    ------
    InputError
        With file:line:column of a time or number that is none, or beyond what is found on Earth.
    """
    lines = text.splitlines()
    header = _header_line(lines, file)
    delimiter = delimiter_of(lines[header])
    heads = [head for head, _ in cells(lines[header], delimiter)]
    keys = [folded(head) if folded(head) in form.columns else folded(head.partition("[")[0]) for head in heads]
    stated = _stated(lines[:header])
    clock = _clock(keys, stated, file)
    chosen = {n: form.columns[key] for n, key in enumerate(keys) if key in form.columns and not _tilted(key, stated)}
    notes = [f"is read as {form.title}, by {clock.words}", *_unread(heads, keys, chosen)]
    numbers: list[int] = []
    times: list[float] = []
    rows: list[list[float]] = []
    for number, line in enumerate(lines[header + 1 :], header + 2):
        if not line.strip() and numbers:
            break  # PVGIS writes a legend below
        if not line.strip() or line.startswith("#"):
            continue
        parts = cells(line, delimiter)
        if len(parts) < len(heads):
            raise InputError(f"found {len(parts)} cells; allowed: {len(heads)}", file=file, line=number, column=1)
        if len(numbers) >= MOST_ROWS:
            raise InputError(f"found more than {MOST_ROWS} rows; allowed: {MOST_ROWS}; cut the file", file=file)
        times.append(_time(clock, parts, file, number))
        rows.append([_cell(file, number, heads[n], *parts[n], *what) for n, what in chosen.items()])
        numbers.append(number)
    values = _values(np.array(rows, float).reshape(len(rows), len(chosen)), list(chosen.values()), form)
    return FormTable(form, _sorted(file, numbers, np.array(times), values), _place(stated), tuple(notes))


def _header_line(lines: Sequence[str], file: Path) -> int:
    """Number of the line of column names: the first that names a time among several columns."""
    for number, line in enumerate(lines[:1000]):
        names = {folded(head) for head, _ in cells(line, delimiter_of(line))} if line[:1] not in ("", "#") else set()
        if len(names) > 2 and names & {"valid", "valid(utc)", "time", "time(utc)", "date/time", "date", "minute"}:
            return number
    raise InputError("has no line of column names; download it again", file=file)


def _stated(lines: Sequence[str]) -> dict[str, str]:
    """What the lines above the table state, by folded name: ``name: value``, or a line of names over one of values."""
    stated = {}
    for line in lines:
        name, colon, value = line.lstrip("#").partition("->" if "->" in line else ":")
        if colon:
            stated[folded(re.sub(r"\(.*?\)|^DEBUG:", "", name))] = value.strip()
    if len(lines) == 2:
        names, values = (line.split(",") for line in lines)
        stated |= {folded(name): value.strip() for name, value in zip(names, values, strict=False)}
    for name, pattern in (("latitude", r"LATITUDE:\s*([-\d.]+)"), ("longitude", r"LONGITUDE:\s*([-\d.]+)")):
        for text in re.findall(pattern, "\n".join(lines))[:1]:
            stated.setdefault(name, text)
    return stated


@dataclass(frozen=True)
class _Clock:
    """How the times of a table are read: its cells, their format, its zone, and words for it."""

    columns: tuple[int, ...]
    read: Callable[[list[str]], datetime]
    zone: tzinfo
    words: str


def _clock(keys: Sequence[str], stated: Mapping[str, str], file: Path) -> _Clock:
    zone: tzinfo = UTC
    words = "UTC"
    if re.fullmatch(r"[-+]?\d+(\.\d+)?", stated.get("time_zone", "")):
        hours = float(stated["time_zone"])
        if abs(hours) > _FARTHEST_ZONE:
            raise InputError(f"states the time zone {hours:g} h; allowed: -12 to 14; mend its header", file=file)
        zone, words = timezone(timedelta(hours=hours)), f"the clock of its header, UTC{hours:+g} h"
    elif stated.get("time_zone"):
        try:
            zone, words = ZoneInfo(stated["time_zone"]), f"the clock of {stated['time_zone']}"
        except (ZoneInfoNotFoundError, ValueError):
            words = "UTC"
    parts = ("year", "month", "day", "hour", "minute")
    if set(parts) <= {*keys}:
        numbers = tuple(keys.index(part) for part in parts)
        return _Clock(numbers, lambda cell: datetime(*(int(float(each)) for each in cell)), zone, words)  # type: ignore[arg-type]
    if {"date", "hour"} <= {*keys}:
        return _Clock(
            (keys.index("date"), keys.index("hour")),
            lambda cell: datetime.fromisoformat(cell[0]) + timedelta(hours=float(cell[1])),
            zone,
            words,
        )
    names = ("valid", "valid(utc)", "time", "time(utc)", "date/time")
    number = next((n for n, key in enumerate(keys) if key in names), None)
    if number is None:
        raise InputError("has no column of times; download it again", file=file)
    return _Clock((number,), lambda cell: _moment(cell[0]), zone, words)


def _moment(cell: str) -> datetime:
    if re.fullmatch(r"\d{8}:\d{4}", cell):  # PVGIS
        return datetime.strptime(cell, "%Y%m%d:%H%M")
    return datetime.fromisoformat(cell)


def _time(clock: _Clock, parts: Sequence[tuple[str, int]], file: Path, line: int) -> float:
    """Seconds since 1970 of a row."""
    try:
        moment = clock.read([parts[n][0] for n in clock.columns])
        return (moment if moment.tzinfo else moment.replace(tzinfo=clock.zone)).timestamp()
    except (ValueError, OverflowError):
        text = " ".join(parts[n][0] for n in clock.columns)
        raise InputError(
            f"found '{text[:40]}'; allowed: a date and time", file=file, line=line, column=parts[clock.columns[0]][1]
        ) from None


def _cell(file: Path, line: int, head: str, cell: str, column: int, quantity: str, unit: str) -> float:
    """A value in SI; NaN where it is missing."""
    if _MISSING.fullmatch(cell):
        return float("nan")
    if quantity == "sky_cover":
        return SKY_COVER.get(cell.upper(), float("nan"))
    try:
        return (WEATHER_COLUMNS | _DEW)[quantity].to_si(cell, unit)
    except ValueError as error:
        raise InputError(f"{head}: {error}", file=file, line=line, column=column) from None


def _tilted(key: str, stated: Mapping[str, str]) -> bool:
    """Whether a column is light on a plane that PVGIS tilts."""
    return key == "g(i)" and not re.match(r"0(\.0*)?\s*deg", stated.get("slope", ""))


def _unread(heads: Sequence[str], keys: Sequence[str], chosen: Mapping[int, object]) -> list[str]:
    """A line for the columns that are left alone."""
    times = {"valid", "valid(utc)", "time", "time(utc)", "date/time", "date", "year", "month", "day", "hour", "minute"}
    unread = [n for n, key in enumerate(keys) if n not in chosen and key not in times]
    if not unread:
        return []
    words = [f"{heads[n]} ({_LEFT[keys[n]]})" if keys[n] in _LEFT else heads[n] for n in unread]
    return [f"has columns that are not read: {', '.join(words)[:200]}"]


def _values(table: Floats, kinds: Sequence[tuple[str, str]], form: Form) -> dict[str, Floats]:
    """Quantities (n,) by their names."""
    values: dict[str, Floats] = {}
    for number, (quantity, _) in enumerate(kinds):
        column = table[:, number]
        values[quantity] = np.fmax(values[quantity], column) if quantity in values else column
    if "sky_cover" in values:
        values["cloud_fraction"] = values.pop("sky_cover")
    if "dew_point" in values:
        dew = values.pop("dew_point")
        if "relative_humidity" not in values and "air_temperature" in values:
            ratio = saturation_pressure(dew) / saturation_pressure(values["air_temperature"])
            values["relative_humidity"] = np.minimum(100.0 * ratio, 100.0)
    if form.centred:  # the mean over the time since the row before, from means about this row and that
        for name in RADIATION_COLUMNS:
            if name in values:
                values[name] = np.append(values[name][:1], 0.5 * (values[name][1:] + values[name][:-1]))
    return values


def _sorted(file: Path, lines: list[int], time: Floats, values: dict[str, Floats]) -> Readings:
    """Rows in order of time that have an air temperature, the last of those of the same time."""
    if "air_temperature" not in values:
        raise InputError("has no air temperature; download it with temperatures", file=file)
    rows = np.flatnonzero(np.isfinite(values["air_temperature"]))
    order = rows[np.argsort(time[rows], kind="stable")]
    order = order[np.append(np.diff(time[order]) > 0, True)] if order.size else order
    if not order.size:
        raise InputError("has no row with an air temperature; download it again", file=file)
    return Readings(
        file, [lines[n] for n in order], time[order], {name: column[order] for name, column in values.items()}
    )


def is_station_archive(file: Path) -> bool:
    """Whether a file begins as the station-to-archive files of BSRN do."""
    with file.open("rb") as stream:
        return stream.read(6) in (b"*U0001", b"*C0001")


def read_station_archive(file: Path) -> tuple[Readings, tuple[float, float, float]]:
    """Readings of a station-to-archive file of BSRN in seconds since 1970 [UTC], by the reader of pvlib; place.

    Raises
    ------
    InputError
        pvlib cannot read it.
    """
    import pvlib

    names = {"ghi": "sw_down", "dni": "direct_normal", "dhi": "diffuse", "lwd": "lw_down"}
    try:
        data, stated = pvlib.iotools.read_bsrn(file)
        location = float(stated["latitude"]), float(stated["longitude"]), float(stated["altitude"])
        values = {ours: data[theirs].to_numpy(float) for theirs, ours in names.items()}
        values["air_temperature"] = data["temp_air"].to_numpy(float) + ZERO_CELSIUS
        values["relative_humidity"] = data["relative_humidity"].to_numpy(float)
        values["pressure"] = 100.0 * data["pressure"].to_numpy(float)
        time = data.index.as_unit("s").asi8.astype(float)
    except Exception as error:  # a reader of another project: whatever it raises, the file is at fault
        raise InputError(f"is no BSRN station file that can be read: {error}; download it again", file=file) from None
    return _sorted(file, [0] * len(time), time, values), location


def _place(stated: Mapping[str, str]) -> tuple[float, float, float] | None:
    try:
        return float(stated["latitude"]), float(stated["longitude"]), float(stated["elevation"])
    except (KeyError, ValueError):
        return None
