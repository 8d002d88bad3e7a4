"""The error budget of a built database: each source of error switched on alone, and all together.

Each error is the change of radiance that one source makes alone: one table, or one of the averages of DSTO-TN-0193,
replaces its part of the whole truth (`truth.FacetTruth`).
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from skyshine.mat.budget.built_tables import Tables
from skyshine.mat.budget.circumstances import Circumstances
from skyshine.mat.budget.measurement import Measurement
from skyshine.mat.budget.pixel import Scenes
from skyshine.mat.budget.truth import Prepared
from skyshine.mat.budget.unmodelled import unmodelled_errors
from skyshine.mat.budget.views import Views
from skyshine.mat.measure.random_streams import Stream, random_stream
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.grids import path_grid
from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.arrays import Booleans, Floats
from skyshine.schemas.errors import InputError

_log = logging.getLogger("skyshine.mat.report")

# The error of a pixel is made of these.
PIXEL_SOURCES = {
    "reflectance": "reflectance for emitted light, from its table by temperature",
    "emitted_transmittance": "transmittance of emitted light by wavelength, with its interpolation beyond 100 m",
    "reflected_wavelengths": "wavelengths at which the tables have the light that surfaces reflect",
    "compiled_band": "few spectral points in place of all",
    "solver_steps": "the heat balance at the job's solver_steps in place of 288 a day",
    "temperature_table": "interpolation of T",
    "shade": "response to shadows in place of the heat balance in them",
    "surroundings": "response to walls, and their light, in place of the heat balance and the hemisphere beside them",
    "beta_star_table": "interpolation of beta* beyond 100 m",
    "path_radiance_table": "interpolation of L_path/(1 - tau) beyond 100 m",
    "near_range": "interpolation of the tables of paths within 100 m",
    "ambient_table": "interpolation of L_ambient",
    "tilted_sky": "sky of tilted faces: harmonics in place of the integral over a face's own hemisphere",
    "direct_table": "interpolation of L_direct",
    "normalisation": "N_s, a mean over angles of incidence, in place of that of the very angle",
}
FAR_SOURCES = "emitted_transmittance", "beta_star_table", "path_radiance_table"
SOURCES = PIXEL_SOURCES | {
    "tables": "interpolation of all tables",
    "pixel": "the pixel: all of these together, tables read at the pixel as the formats' pages say",
    "water_continuum": "another continuum of MT_CKD in place of the job's; no source of the pixel's",
    "weather_of_the_air": "the job's air in place of that of the weather at the hour; no source of the pixel's",
    "aureole": "one share of the sky's light around the Sun behind a building, and the band's own in its shade",
    "seen_faces": "the band's light of ground in the open before shaded slopes, in place of ground in their shade",
    "lobe": "one lobe in place of microfacets with Fresnel reflectance, which grows to grazing angles",
    "depth_buffer": "ranges of a depth buffer of 24 bits, hyperbolic between the ends of the tables",
    "aliasing": "one sample a pixel of 0.5 mrad in place of its mean, by edges of materials",
    "vertices_centre": "temperatures at the vertices of faces alone, of the material of the face's centre texel",
    "vertices_nearest": "temperatures at the vertices of faces alone, of the material of the texel at each vertex",
    "face": "radiance of the vertices interpolated across the face",
    "transmittance_extrapolation": "transmittance from beta* of the centre pixel",
    "radiance_extrapolation": "path, ambient and direct radiance from the centre pixel",
    "misclassification": "material codes of the textures",
    "all": "all together, as a runtime has them that reads the tables once a frame",
}


@dataclass(eq=False)
class Budget:
    """Errors of one state, band and source.

    Attributes
    ----------
    state, band : int
        Counted from 1.
    circumstances : Circumstances
        Surroundings of the views' faces.
    radiance : (n, M) array
        The truth, W m^-2 sr^-1.
    errors : dict of str to (n, M) array
        Error of each source (`SOURCES`), W m^-2 sr^-1; that of misclassification (n, M, M), by the material
        assigned.
    counted : dict of str to (n,) bool array
        Views on which an error is counted; all where it has none.
    assigned_share : (M, M) array or None
        Share of the texels of each material that the classifier assigns to each material.
    extrapolation : dict of str to (F, n, M) array
        The two errors of extrapolation for each of `FIELDS_OF_VIEW`.
    frames : dict of str to (F, n, M) array
        Errors of the stored tables off the centre of a frame, for each of `frames.READINGS` and `FIELDS_OF_VIEW`.
    notes : list of str
        What was not measured, and why.
    """

    state: int
    band: int
    source: str
    materials: tuple[str, ...]
    views: Views
    circumstances: Circumstances
    response: SpectralResponse
    radiance: Floats
    errors: dict[str, Floats] = field(default_factory=dict)
    counted: dict[str, Booleans] = field(default_factory=dict)
    assigned_share: Floats | None = None
    extrapolation: dict[str, Floats] = field(default_factory=dict)
    frames: dict[str, Floats] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


STEPS = 10  # steps of a budget, each reported when it is finished


def error_budget(
    prepared: Prepared,
    folder: Path,
    library: MaterialLibrary,
    *,
    source: str,
    scenes: int,
    seed: int,
    advance: Callable[[int], object] = lambda _: None,
) -> Budget | None:
    """Measure the errors of one set of tables.

    Parameters
    ----------
    folder : Path
        Folder of the built databases.
    source : {'sun', 'moon'}
    scenes, seed : int
        Number of random views, and what they are drawn with.
    advance : callable
        Called with 1 when one of `STEPS` parts is finished.

    Returns
    -------
    Budget or None
        None where the tables leave no room for a view, with the Moon above the horizon.

    Raises
    ------
    InputError
        A database is missing or does not belong to the job.
    """
    job = prepared.loaded.trimmed
    tables = Tables.open(folder, prepared.state, prepared.band, source, job)
    grid = path_grid(job)

    def say(what: str) -> None:
        _log.info("state %d, band %d, %s: %s", prepared.state, prepared.band, source, what)

    say("random views and their truth")
    drawn = Scenes.drawn(
        prepared,
        library,
        tables.materials,
        grid,
        tables.surface_axes,
        shades=tables.shades,
        source=source,
        scenes=scenes,
        seed=seed,
    )
    if drawn is None:
        advance(STEPS)
        return None
    truth, views, circumstances = drawn.truth, drawn.views, drawn.circumstances
    measured = Measurement(prepared, tables, truth, views, circumstances, grid)
    advance(1)
    notes = []
    if prepared.has_air_of_an_hour:
        notes.append(f"State {prepared.state}: its air is that of one time, so the weather of the air makes no error.")

    def of_weather() -> dict[str, Floats]:
        try:
            return measured.of_weather()
        except InputError as error:
            notes.append(f"State {prepared.state}: the weather of the air was not measured: {error}.")
            return {}

    say("tables read once a frame")
    extrapolation = measured.of_frames(random_stream(seed, Stream.BUDGET))
    errors = dict(extrapolation.errors)
    advance(1)
    parts: dict[str, Callable[[], dict[str, Floats]]] = {
        "light on faces": measured.of_light,
        "temperatures": measured.of_temperatures,
        "atmospheric tables": measured.of_atmosphere,
        "weather of the air": of_weather,
        "continua": measured.of_continua,
        "omitted physics": lambda: unmodelled_errors(measured, random_stream(seed, Stream.UNMODELLED)),
        "vertices": lambda: measured.of_vertices(random_stream(seed, Stream.VERTICES)),
        "the pixel": lambda: (
            {"pixel": measured.pixel(), "normalisation": measured.of_normalisation()} | measured.of_materials()
        ),
    }
    for words, part in parts.items():
        say(words)
        errors |= part()
        advance(1)
    counted = dict.fromkeys(FAR_SOURCES, ~views.near) | {"near_range": views.near}
    return Budget(
        prepared.state,
        prepared.band,
        source,
        tables.materials,
        views,
        circumstances,
        prepared.response,
        measured.radiance,
        {name: errors[name] for name in SOURCES if name in errors and counted.get(name, np.ones(1, bool)).any()},
        {name: rows for name, rows in counted.items() if rows.any()},
        tables.assigned_share,
        extrapolation.by_field,
        extrapolation.frames,
        notes,
    )
