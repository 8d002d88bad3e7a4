"""The page of the input formats of users' files, generated from the tables of their readers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from skyshine.mat.atmosphere.soundings.netcdf import VARIABLES as COLUMN_VARIABLES
from skyshine.mat.atmosphere.soundings.units import UNITS as SOUNDING_UNITS
from skyshine.mat.job.typical_years import FIELDS
from skyshine.mat.job.weather_netcdf import VARIABLES
from skyshine.mat.radiometry.response_table import UNITS as RESPONSE_UNITS
from skyshine.mat.render.gltf_surface import READERS
from skyshine.mat.render.gltf_triangles import COMPONENTS, MODES
from skyshine.mat.render.obj_triangles import FREE_FORM, READ
from skyshine.mat.surface.weather_forms import FORMS, SKY_COVER
from skyshine.mat.surface.weather_history import COLUMNS
from skyshine.mat.surface.weather_readings import WEATHER_COLUMNS
from skyshine.materials.spectrum_files import ENVI_UNITS, QUANTITIES, SCALES, UNITS
from skyshine.schemas.gltf import DECODED, HARMLESS, REFUSED

PAGE = "reference/readers.md"


def page() -> str:
    """Text of the page, in Markdown."""
    return "\n".join(
        [
            "# What the readers understand",
            "",
            "Made from the tables by which the files are read. What is not listed is refused by its name, or left",
            "alone with a line that says so.",
            "",
            *_meshes(),
            *_spectra(),
            *_responses(),
            *_weather(),
            *_soundings(),
            *_images(),
            "",
        ]
    )


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    escaped = [[cell.replace("|", "\\|") for cell in row] for row in rows]
    return ["", *(f"| {' | '.join(row)} |" for row in [list(heads), ["---"] * len(heads), *escaped]), ""]


def _codes(names: Iterable[object]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _meshes() -> list[str]:
    rows = [(f"`{name}`", f"decoded: {words}") for name, words in DECODED.items()]
    rows += [(f"`{name}`", f"refused; {words}") for name, words in REFUSED.items()]
    rows += [(_codes(["KHR_materials_*", *HARMLESS]), "may be required: they change no triangle")]
    return [
        "## Meshes",
        "",
        f"Files that end in {_codes(READERS)}; of `mat render`, `mat check --scene` and, glTF alone,",
        "`tmm export --mesh`. Of glTF 2.0 the scene that is shown by default, or all root nodes where there is none;",
        "nodes by matrix or by",
        f"translation, rotation and scale; {', '.join(MODES.values())}; accessors of {_codes(COMPONENTS.values())},",
        "strided, sparse, normalised; morph targets by their weights; buffers in the file, in data URIs or in files",
        "beside it, whose names are percent-encoded. Points and lines have no area. Skins are refused.",
        *_table(("extension of glTF", "what is done"), rows),
        f"Of Wavefront OBJ: {_codes(READ)}, polygons of any number of corners that a fan of triangles fills; of its",
        f"MTL the options `-s` and `-o` of `map_Kd`. Refused: {_codes(FREE_FORM)}.",
        "",
    ]


def _spectra() -> list[str]:
    return [
        "## Spectra of materials",
        "",
        "Text with columns of wavelength and value, ECOSTRESS, ASTER and USGS text, and ENVI spectral libraries.",
        f"Units: {_codes(UNITS)}; scales: {_codes(SCALES)}; quantities: {_codes(QUANTITIES)}. Of the header of ENVI:",
        f"`wavelength units` ({_codes(ENVI_UNITS)}, in any encoding), `reflectance scale factor`, `data ignore value`,",
        "`bbl`, `header offset`, `byte order`, `spectra names`.",
        "",
    ]


def _responses() -> list[str]:
    return [
        "## Responses of sensors",
        "",
        "Columns between commas, semicolons (with decimal commas), tabs or blanks; lines of text above them; a column",
        "of scatter beside the response. Without a unit a wavelength is read in um or nm by its values, which is said.",
        *_table(("axis", "units"), ((name, _codes(units)) for name, units in RESPONSE_UNITS.items())),
    ]


def _weather() -> list[str]:
    rows = []
    for form in FORMS:
        columns = [f"`{head}` ({', '.join(filter(None, what))})" for head, what in form.columns.items()]
        rows.append((form.title, ", ".join(columns)))
    rows.append(("BSRN, station-to-archive", "logical record 0100, by pvlib"))
    rows.append(("DIRSIG and THERM, `.wth`, its second day", f"{_codes(COLUMNS)}; not sunlight, sky, clouds and rain"))
    rows.append(("ERA5 of a point, netCDF", _codes(VARIABLES)))
    rows.append(("EPW (any number of records an hour), TMY3", _codes(FIELDS)))
    limits = (
        (f"`{name}`", _codes(column.units), f"{column.low:g} to {column.high:g}")
        for name, column in WEATHER_COLUMNS.items()
    )
    return [
        "## Weather",
        "",
        *_table(("form", "columns that are read, with quantity and unit"), rows),
        f"Sky cover of METAR counts as {', '.join(f'{name} {share:g}' for name, share in SKY_COVER.items())}.",
        "Other CSV files have a column `time` and:",
        *_table(("column", "units", "allowed, in the first unit"), limits),
    ]


def _soundings() -> list[str]:
    units: Mapping[str, Iterable[str]] = SOUNDING_UNITS
    return [
        "## Soundings",
        "",
        "CSV of any columns, lists of the University of Wyoming (text and CSV), IGRA v2, and netCDF by pressure.",
        *_table(("quantity", "units"), ((f"`{name}`", _codes(codes)) for name, codes in units.items())),
        *_table(("variable of netCDF", "names"), ((name, _codes(names)) for name, names in COLUMN_VARIABLES.items())),
    ]


def _images() -> list[str]:
    import OpenImageIO

    formats = sorted(part.partition(":")[0] for part in OpenImageIO.get_string_attribute("extension_list").split(";"))
    return ["## Images", "", f"Of `tmm`, by OpenImageIO: {', '.join(formats)}; GeoTIFF places are read too.", ""]
