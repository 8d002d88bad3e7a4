"""Reading a job: the YAML document, its series and weather files, the query limits that trim it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pydantic

from skyshine.mat.atmosphere.state.climate import profile_weights
from skyshine.mat.job.accuracy import names_a_pixel
from skyshine.mat.job.atmosphere import AUTO, TYPICAL, State
from skyshine.mat.job.default_ground import with_default_ground
from skyshine.mat.job.leaf_area import open_stands, refuse_no_soil
from skyshine.mat.job.model import Job
from skyshine.mat.job.moisture import check_moisture
from skyshine.mat.job.own_materials import library_with, own_names
from skyshine.mat.job.plausibility import zone_doubt
from skyshine.mat.job.series import MEMBER_LIMIT, Series, changed, members
from skyshine.mat.job.sites import SiteDocument, has_sites, site_documents
from skyshine.mat.job.snow import check_snow
from skyshine.mat.job.state_weather import weather_doubts, with_ground, with_weather_files
from skyshine.mat.job.surface import named_operation
from skyshine.mat.job.trim import limited_axes, trimmed
from skyshine.mat.job.warnings import merged
from skyshine.mat.radiometry.response_table import response_notes
from skyshine.materials.library import MaterialLibrary, load_library, unknown_material
from skyshine.schemas.documents import Document, parse_model, problem_text, read_document
from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.paths import job_path


@dataclass(frozen=True)
class LoadedJob:
    """A job with the file it came from.

    Attributes
    ----------
    requested : Job
        Job as stated, with all nodes and sources.
    trimmed : Job
        Job with the nodes and sources that its query limits read; the tables are built from it.
    warnings : tuple of str
        What is allowed but hardly meant: weather files of another place.
    site_name : str
        Name of the site, of a job that has several; empty of a job of one.
    """

    requested: Job
    trimmed: Job
    document: Document
    warnings: tuple[str, ...] = ()
    site_name: str = ""

    @property
    def file(self) -> Path:
        return self.document.file

    @property
    def folder(self) -> Path:
        """Folder against which the job's paths are read."""
        return self.document.file.resolve().parent

    def on_date_of_state(self, index: int) -> LoadedJob:
        """The same with its site on the date of a state, counted from 1."""
        return replace(
            self,
            requested=self.requested.on_date_of_state(index),
            trimmed=self.trimmed.on_date_of_state(index),
        )

    def with_state_alone(self, index: int) -> LoadedJob:
        """The same for a process that computes one state, counted from 1: the others are as that, where none of its
        files depends on them. So a process is sent a state and not a year.
        """
        states = self.requested.states
        clouds = states[index - 1].clouds
        if not all(state.is_one_of_many and state.clouds == clouds for state in states):
            return self
        requested, trimmed = (
            job.model_copy(update={"states": [job.states[index - 1]] * len(states)})
            for job in (self.requested, self.trimmed)
        )
        return replace(self, requested=requested, trimmed=trimmed)

    def insists(self, grid: str) -> bool:
        """Whether the job itself asks for the tolerance of a grid: where it cannot be held the build ends. The default
        is held as far as the size of a table allows, and the file states its error.
        """
        data = self.document.data
        settings = data.get(grid) if isinstance(data, dict) else None
        return names_a_pixel(data) or (isinstance(settings, dict) and "tolerance" in settings)

    def refuse_without_bands(self) -> None:
        """Raise InputError where the job has no band, of whose pixels something is to be said."""
        if not self.trimmed.bands:
            raise InputError("found no band; allowed here: one or more; add one to bands", file=self.file)

    @property
    def output_folder(self) -> Path:
        """Where the job's files go.

        Raises
        ------
        InputError
            It lies outside the job's folder, and the user has not allowed that.
        """
        try:
            return job_path(self.folder, self.requested.output.folder, for_output=True)
        except ValueError as error:
            raise self.document.error(("output", "folder"), f"output.folder: {error}") from None


@dataclass(frozen=True)
class JobSites:
    """The sites of a job, each read when it is asked for: those of a year's weather take tenths of a second each.

    Attributes
    ----------
    sites : tuple of SiteDocument
        One without a name of a job of one site.
    only : LoadedJob, optional
        Job that is read already.
    """

    document: Document
    sites: tuple[SiteDocument, ...]
    library: MaterialLibrary
    only: LoadedJob | None = None

    @classmethod
    def of(cls, loaded: LoadedJob) -> JobSites:
        """A job of one site that is read already."""
        return cls(loaded.document, (SiteDocument("", loaded.document),), load_library(), loaded)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(site.name for site in self.sites)

    def load(self, number: int) -> LoadedJob:
        """The job of a site, counted from 0; `load_job` says what is raised."""
        if self.only is not None:
            return self.only
        site = self.sites[number]
        return _loaded(site.document, self.library, site.name)


def job_sites(
    source: str | os.PathLike[str] | Mapping[str, Any],
    library: MaterialLibrary | None = None,
    *,
    folder: Path | None = None,
) -> JobSites:
    """The sites of a job, or its only one; parameters as `load_job`.

    Raises
    ------
    InputError
        The document or its sites do not fit.
    """
    document = read_document(source, folder)
    several = has_sites(document)
    sites = site_documents(document) if several else (SiteDocument("", document),)
    return JobSites(document, sites, library or load_library())


def load_job(
    source: str | os.PathLike[str] | Mapping[str, Any],
    library: MaterialLibrary | None = None,
    *,
    folder: Path | None = None,
) -> LoadedJob:
    """Read, check and type a job.

    Parameters
    ----------
    source : path or mapping
        A YAML file, or its content as plain data.
    library : MaterialLibrary, optional
        Library whose materials the job may name; by default the packaged one with the user's.
    folder : Path, optional
        Folder to which the paths in a mapping are relative; by default the working directory.

    Raises
    ------
    InputError
        With file:line:column of the first thing that does not fit.
    """
    sites = job_sites(source, library, folder=folder)
    if sites.names != ("",):
        raise sites.document.error(
            ("sites",),
            f"sites: found {len(sites.names)} sites; allowed here: a job of one; mat check and mat build take several;"
            " write site in the place of sites",
        )
    return sites.load(0)


def _loaded(document: Document, library: MaterialLibrary, site_name: str) -> LoadedJob:
    names = (*library.names, *own_names(document.data))
    context = {"materials": names, "folder": document.file.resolve().parent}
    document = _with_operations(document, library)
    stated = parse_model(document, Job, context)
    stated, library = _with_own_materials(stated, document, library)
    _refuse_shared_names(stated, document)
    job = _with_air_times(_with_series(stated, document, context, bool(site_name)), document)
    _check_query_limits(job, document)
    _check_soil_moisture(job, document, library)
    _check_leaf_area(job, document, library)
    _check_snow(job, document, library)
    job = with_default_ground(job, library)
    job, remarks = _with_soundings(_with_typical_aerosol(_with_profiles(job)))
    requested, warnings = with_weather_files(job, document)
    requested, seasons = with_ground(requested, job, document)
    site = job.site
    zone = [text for text in [zone_doubt(site.utc_offset_h, site.longitude_deg, "site:")] if text]
    notes = (*zone, *_response_notes(job), *remarks, *weather_doubts(job), *warnings, *seasons)
    return LoadedJob(requested, trimmed(requested), document, notes, site_name)


def _with_own_materials(stated: Job, document: Document, library: MaterialLibrary) -> tuple[Job, MaterialLibrary]:
    """The job with a list of its materials, and the library with those of its own."""
    job = stated.with_own_materials()
    if job is stated:
        return job, library
    for name, definition in stated.materials.items() if isinstance(stated.materials, dict) else ():
        if definition is None and name not in library:
            raise document.error(("materials", name), f"materials.{name}: {unknown_material(name, library.names)}")
        if definition is not None:
            try:
                library_with(library, ((name, definition),))
            except InputError as error:
                raise document.error(("materials", name), f"materials.{error.message}") from None
    return job, library_with(library, job.own_materials) if job.own_materials else library


def _with_operations(document: Document, library: MaterialLibrary) -> Document:
    """The document with the backs that materials have by name, where `operated` names one of them."""
    operations = document.data.get("operated") if isinstance(document.data, dict) else None
    if not isinstance(operations, dict):
        return document
    operated = dict(operations)
    for name, operation in operations.items():
        if isinstance(operation, str) and name in library:
            try:
                operated[name] = named_operation(library[name], operation)
            except ValueError as error:
                raise document.error(("operated", name), f"operated.{name}: {error}") from None
    return replace(document, data={**document.data, "operated": operated})


def _check_query_limits(job: Job, document: Document) -> None:
    """Refuse needs that none of the job's tables could serve."""
    limits = job.query_limits
    if limits is None:
        return
    for key, allowed in (("bands", job.band_names), ("sources", job.sources), ("materials", job.materials)):
        for i, name in enumerate(getattr(limits, key) or []):
            if isinstance(allowed, list) and name not in allowed:
                raise document.error(("needs", key, i), f"needs.{key}.{i}: found '{name}'; {nearest(name, allowed)}")
    for key, grid, name, nodes, (low, high) in limited_axes(job, limits):
        # A source below all elevations of the tables is dark.
        if low > nodes[-1] or (high < nodes[0] and key != "source_elevation_deg"):
            raise document.error(
                ("needs", key),
                f"needs.{key}: found [{low:g}, {high:g}]; allowed: part of the range of {grid}.{name}, {nodes[0]:g} to"
                f" {nodes[-1]:g}; change one of them",
            )


def _refuse_shared_names(job: Job, document: Document) -> None:
    """Refuse two written states of one name."""
    names: set[str] = set()
    for i, state in enumerate(job.states):
        if state.name in names:
            raise document.error(
                ("states", i, "name"), f"found the state '{state.name}' twice; allowed: names once each; rename it"
            )
        names |= {state.name} if state.name else set()


def _materials_of(job: Job, library: MaterialLibrary) -> list[str]:
    """Names of what a job has temperatures of, or has around it."""
    surrounding = [name for state in job.states for name in state.surrounding_materials]
    return [*job.materials, *surrounding] if isinstance(job.materials, list) else list(library.names)


def _check_soil_moisture(job: Job, document: Document, library: MaterialLibrary) -> None:
    """Refuse moisture of what has no pores, and more of it than they can take."""
    moisture = job.soil_moisture
    if moisture is None:
        return
    named = _materials_of(job, library)
    named += [stand.soil for name in named if (stand := library[name].stand) is not None and stand.soil in library]
    soils = {name: soil for name in named if (soil := library[name].soil) is not None}
    try:
        if not check_moisture(moisture, soils):
            raise ValueError("found it for materials of which none has soil; allowed: with soil, sand or gravel")
    except ValueError as error:
        raise document.error(("soil_moisture",), f"soil_moisture: {error}") from None


def _check_leaf_area(job: Job, document: Document, library: MaterialLibrary) -> None:
    """Refuse gaps in what has no stand of leaves, or a back that a job operates, and soils that cannot lie below."""
    leaf_area = job.leaf_area_index
    if leaf_area is None:
        return
    try:
        for name in open_stands(
            leaf_area, [name for name in _materials_of(job, library) if library[name].stand is not None]
        ):
            refuse_no_soil(library[name], library)
            if name in job.operated:
                raise ValueError(f"found {name} in operated too; allowed: in one of them; remove it from one")
    except ValueError as error:
        raise document.error(("leaf_area_index",), f"leaf_area_index: {error}") from None


def _check_snow(job: Job, document: Document, library: MaterialLibrary) -> None:
    """Refuse snow on what carries none or is not in the job."""
    try:
        check_snow(job.snow_on, _materials_of(job, library), library)
    except ValueError as error:
        raise document.error(("snow_on",), f"snow_on: {error}") from None


def _with_series(job: Job, document: Document, context: dict[str, Any], several_sites: bool) -> Job:
    """The job with a state for each member of its series."""
    if all(state.series is None for state in job.states) and not several_sites:
        return job
    states: list[State] = []
    for i, state in enumerate(job.states):
        if state.series is None:
            states.append(state.as_one_of_many() if several_sites else state)
            continue
        stated_state = document.data["states"][i]
        series = _inside(state.series, document, i, context)
        for number, member in enumerate(members(series, context["folder"], job.site.utc_offset_h), 1):
            try:
                expanded = State.model_validate(changed(stated_state, member.changes), context=context)
                differs = several_sites or series.table is not None or expanded.weather.file is not None
                states.append(expanded.as_one_of_many() if differs else expanded)
            except pydantic.ValidationError as error:
                problem = error.errors(include_url=False)[0]
                message = f"{'.'.join(map(str, problem['loc']))}: {problem_text(problem)}"
                if member.file is None:
                    raise document.error(
                        ("states", i), f"states.{i}: in member {number} of its series, {message}"
                    ) from None
                raise InputError(message, file=member.file, line=member.line) from None
    _refuse_many(states, document, "series")
    return job.model_copy(update={"states": states})


def _with_air_times(job: Job, document: Document) -> Job:
    """The job with a state for each time whose air a state asks for."""
    if all(state.air_times is None for state in job.states):
        return job
    states: list[State] = []
    for state in job.states:
        times = state.air_times
        states += [state] if times is None else [state.model_copy(update={"air_times": [time]}) for time in times]
    _refuse_many(states, document, "series and air_times")
    return job.model_copy(update={"states": states})


def _refuse_many(states: list[State], document: Document, what: str) -> None:
    if len(states) > MEMBER_LIMIT:
        raise document.error(
            ("states",), f"states: found {len(states)} with all {what}; allowed: at most {MEMBER_LIMIT}"
        )


def _inside(series: Series, document: Document, state: int, context: dict[str, Any]) -> Series:
    for key in ("table", "soundings"):
        if getattr(series, key) is not None:
            try:
                job_path(context["folder"], getattr(series, key))
            except ValueError as error:
                raise document.error(
                    ("states", state, "series", key), f"states.{state}.series.{key}: {error}"
                ) from None
    return series


def _with_profiles(job: Job) -> Job:
    """The job with the blend in the place of each profile that follows from place and date: it identifies the air."""
    if all(state.profile != AUTO for state in job.states):
        return job
    states = []
    for state in job.states:
        if state.profile == AUTO:
            weights = profile_weights(job.site.latitude_deg, state.date or job.site.date)
            profile = next(iter(weights)) if len(weights) == 1 else weights
            state = state.model_copy(update={"profile": profile})
        states.append(state)
    return job.model_copy(update={"states": states})


def _response_notes(job: Job) -> list[str]:
    """What is done with response tables beyond reading them, a line each."""
    return [
        f"band {name}: the response {band.response.name} {note}"
        for name, band in zip(job.band_names, job.bands, strict=True)
        if band.response is not None
        for note in response_notes(band.response.text, band.response.path)
    ]


def _with_soundings(job: Job) -> tuple[Job, list[str]]:
    """The job with the levels of its soundings, so that nothing later depends on a file; what was replaced in them."""
    states, remarks = list(job.states), []
    for i, state in enumerate(states):
        if state.sounding is not None:
            day = state.date or job.site.date
            sounding = state.sounding.read(job.site, day)
            remarks += [(i + 1, text) for text in sounding.remarks(job.site, day)]
            states[i] = state.model_copy(update={"sounding": sounding})
    return job.model_copy(update={"states": states}), merged(remarks)


def _with_typical_aerosol(job: Job) -> Job:
    """The job with the optical depth of place and month in the place of each that is typical."""
    if all(state.aerosol_optical_depth != TYPICAL for state in job.states):
        return job
    from skyshine.mat.atmosphere.state.turbidity import typical_aerosol

    site, states = job.site, []
    for state in job.states:
        if state.aerosol_optical_depth == TYPICAL:
            date = state.date or site.date
            typical = typical_aerosol(site.latitude_deg, site.longitude_deg, 1e3 * site.altitude_km, date)
            words = f"Linke turbidity {typical.linke_turbidity:.3g} in {date:%B}, climatology, error about 0.1"
            state = state.with_optical_depth(typical.optical_depth, words)
        states.append(state)
    return job.model_copy(update={"states": states})
