"""The sounding of a state: a file, and which of its columns of air is meant."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass, replace
from datetime import UTC, date, datetime, timedelta
from pathlib import Path
from typing import Annotated, Any, Literal

import pydantic
from pydantic import Field

from skyshine.mat.atmosphere.soundings.choice import Choice, shown
from skyshine.mat.atmosphere.soundings.files import read_levels, times_of
from skyshine.mat.atmosphere.soundings.levels import Levels
from skyshine.mat.job.fields import TimeOfDay, clock_text
from skyshine.mat.job.site import Site
from skyshine.schemas.documents import StrictModel, problem_text
from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import job_path

FARTHEST_DAYS = 7.0  # from the state's day to a sounding that is taken without a warning


class SoundingChoice(StrictModel):
    """A sounding out of a file that contains several."""

    file: str = Field(
        min_length=1,
        description=(
            "CSV of altitude, pressure, temperature, humidity and other gases; a list of the University of Wyoming"
            " (text or CSV); IGRA v2; netCDF on pressure levels, such as ERA5; or an input of MODTRAN (tape5,"
            " .ltn, JSON)."
        ),
    )
    time: TimeOfDay | None = Field(
        None,
        description=(
            "Local clock, on the state's date; by default the only sounding of the file or of that day. The nearest"
            " within 12 h is taken."
        ),
    )
    column: Literal["interpolated", "nearest"] = Field(
        "interpolated",
        description="Column of a grid at the site and time: interpolated between its columns and times, or "
        "the nearest.",
    )


@dataclass(frozen=True, eq=False)
class JobSounding:
    """A sounding that a job names.

    Attributes
    ----------
    levels : Levels or None
        None until the job's place and date are known.
    """

    choice: SoundingChoice
    path: Path
    levels: Levels | None = None

    @property
    def name(self) -> str:
        """The file as the job writes it."""
        return self.choice.file

    def read(self, site: Site, day: date) -> JobSounding:
        """The same with its levels at a place on a day.

        Raises
        ------
        InputError
            As `read_levels`.
        """
        midnight = datetime(day.year, day.month, day.day, tzinfo=UTC) - timedelta(hours=site.utc_offset_h)
        time = None if self.choice.time is None else midnight + timedelta(hours=self.choice.time)
        choice = Choice(
            (site.latitude_deg, site.longitude_deg),
            time,
            (midnight, midnight + timedelta(days=1)),
            self.choice.column == "interpolated",
        )
        return replace(self, levels=read_levels(self.path, choice))

    def remarks(self, site: Site, day: date) -> list[str]:
        """Defaults used for what the file lacks, and a sounding of another season."""
        assert self.levels is not None
        lines = [f"sounding {self.name} {note}" for note in self.levels.notes]
        if self.levels.time is not None:
            noon = datetime(day.year, day.month, day.day, 12, tzinfo=UTC) - timedelta(hours=site.utc_offset_h)
            apart = abs(noon - self.levels.time) / timedelta(days=1)
            if apart > FARTHEST_DAYS:
                lines.append(
                    f"sounding {self.name} is of {shown(self.levels.time)}, {apart:.0f} days from the state's date"
                    f" (warned beyond {FARTHEST_DAYS:g})"
                )
        return lines


def _named(value: object, info: pydantic.ValidationInfo) -> JobSounding:
    if isinstance(value, JobSounding):
        return value
    try:
        choice = SoundingChoice.model_validate({"file": value} if isinstance(value, str) else value)
    except pydantic.ValidationError as error:
        problem = error.errors(include_url=False)[0]
        location = "".join(f"{part}: " for part in problem["loc"])
        raise ValueError(location + problem_text(problem)) from None
    path = job_path((info.context or {}).get("folder", "."), choice.file)
    if not path.is_file():
        raise ValueError(
            f"found '{choice.file}', which is no file at {path}; allowed: a path relative to the job; fix it"
        )
    return JobSounding(choice, path)


def _identity(sounding: JobSounding) -> dict[str, Any]:
    """Name and content: a table is kept only as long as the levels that it was built from are the same."""
    identity: dict[str, Any] = {"file": sounding.name}
    if sounding.levels is not None:
        digest = hashlib.sha256()
        levels = sounding.levels
        arrays = {"altitude": levels.altitude, "pressure": levels.pressure, "temperature": levels.temperature}
        for name, values in (arrays | levels.mole_fraction).items():
            digest.update(name.encode())
            digest.update(values.astype("<f8").tobytes())
        identity["sha256"] = digest.hexdigest()
    return identity


StateSounding = Annotated[
    pydantic.InstanceOf[JobSounding],
    pydantic.BeforeValidator(_named, json_schema_input_type=str | SoundingChoice),
    pydantic.PlainSerializer(_identity, return_type=dict),
]


def soundings_of_folder(folder: Path, name: str, utc_offset_h: float) -> list[dict[str, Any]]:
    """Keys of a state for each sounding in the files of a folder, in order of time.

    Parameters
    ----------
    folder : Path
        Folder of the job.
    name : str
        Name of the folder of soundings, as the job states it.
    utc_offset_h : float
        Offset of the local clock from UTC [h].

    Raises
    ------
    InputError
        There is no such folder, or a file in it contains no sounding.
    """
    directory = folder / name
    if not directory.is_dir():
        raise InputError("is no folder; allowed: the folder of the soundings of a series", file=directory)
    entries: list[tuple[str, str, dict[str, Any]]] = []
    for file in sorted(path for path in directory.iterdir() if path.is_file() and not path.name.startswith(".")):
        relative = f"{name.rstrip('/')}/{file.name}"
        for time in times_of(file):
            if time is None:
                day = _day_in(file.stem)
                entries.append((day or "", relative, {"sounding": relative} | ({"date": day} if day else {})))
                continue
            local = time + timedelta(hours=utc_offset_h)
            clock = clock_text(local.hour + local.minute / 60)
            keys = {"sounding": {"file": relative, "time": clock}, "date": local.date().isoformat()}
            entries.append((f"{local:%Y-%m-%dT%H:%M}", relative, keys))
    return [keys for _, _, keys in sorted(entries, key=lambda item: item[:2])]


def _day_in(name: str) -> str | None:
    """The first date in the name of a file, such as 2026-01-15 or 20260115."""
    for match in re.finditer(r"(?<!\d)(\d{4})[-_]?(\d\d)[-_]?(\d\d)(?!\d{3})", name):
        try:
            return date(*map(int, match.groups())).isoformat()
        except ValueError:
            continue
    return None
