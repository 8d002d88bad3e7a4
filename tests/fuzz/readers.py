"""Every reader of what a user may hand us, as a function of bytes that may raise nothing but `InputError`."""

from __future__ import annotations

import datetime
import os
from collections.abc import Callable
from pathlib import Path

from skyshine.mat.atmosphere.profiles import load_profile
from skyshine.mat.atmosphere.sounding import read_sounding
from skyshine.mat.job import load_job
from skyshine.mat.jobs.series import Series, members
from skyshine.mat.jobs.weather_files import read_weather
from skyshine.mat.response import parse_response
from skyshine.mat.tables.loader import open_table
from skyshine.mat.tables.verify import problems
from skyshine.materials.files import SpecularFile, ThermalFile
from skyshine.schemas.csv_table import read_text
from skyshine.schemas.documents import load_model
from skyshine.tmm.texture import TextureFile

ROOT = Path(__file__).parents[2]
JOB = """\
skyshine: 1
name: small
site: {latitude_deg: 29.7, longitude_deg: -82.0, date: 2026-06-28, utc_offset_h: -5}
states:
  - profile: midlatitude_summer
    sounding: in.csv
    gases: {O3: {column_du: 300}}
    weather: {air_temperature_c: [22, 33]}
    series: {first: 2026-01-01, last: 2026-01-03}
bands: [{wavelength_um: [8, 12]}, {wavenumber_cm: [2000, 3000]}]
materials: [asphalt_road]
output: {folder: built}
surface_grid: {time: ["00:00", "12:00"]}
"""
SOUNDING = "altitude[km],pressure[hPa],temperature[C],relative_humidity[%],O3[ppmv]\n0,1013,15,50,.03\n5,540,-18,30,.05\n12,193,-57,10,.2\n"
RESPONSE = "# a filter\nwavelength[um],response\n8,0\n9,.9\n11,1\n12,0\n"
DAY = "time,air_temperature[C],relative_humidity[%],wind_speed[m/s]\n" + "".join(f"{h:02d}:00,{10 + h % 12},50,2\n" for h in range(24))
ENSEMBLE = "date,visibility_km,weather.air_temperature_c\n2026-01-03,5,\"[-4, 2]\"\n2026-07-30,40,31\n"


def _job(path: Path) -> None:
    load_job(path).output_folder


def _series(path: Path) -> None:
    list(members(Series(table=path.name), path.parent))


def _table(path: Path) -> None:
    problems(path)
    table = open_table(path)
    for name in table.quantities:
        where = {rule.name: rule.nodes[0] for rule in table.rules(name)}
        table.value(name, **where)
        table.error(name)


def _texture(path: Path) -> None:
    image = TextureFile(path)
    image.window(slice(0, min(4, image.height)), slice(0, image.width))


def _flat(path: Path) -> None:
    table = open_table(path)
    for name in table.quantities:
        table.rules(name)


# By target: ending of its file, what reads it.
READERS: dict[str, tuple[str, Callable[[Path], object]]] = {
    "job": (".yaml", _job),
    "material": (".yaml", lambda path: load_model(path, ThermalFile)),
    "specular": (".yaml", lambda path: load_model(path, SpecularFile)),
    "sounding": (".csv", lambda path: read_sounding(read_text(path), path, load_profile("us_standard"))),
    "response": (".csv", lambda path: parse_response(read_text(path), path)),
    "weather": (".csv", lambda path: read_weather(path, datetime.date(2026, 6, 28), -5)),
    "series": (".csv", _series),
    "texture": (".png", _texture),
    "table": (".h5", _table),
    "flat": (".raw.json", _flat),
}


def seeds(target: str) -> list[bytes]:
    """Good inputs of a target, from which others are bred; `table` and `flat` take those in the folder SKYSHINE_FUZZ_TABLES."""
    texts = {"job": JOB, "sounding": SOUNDING, "response": RESPONSE, "weather": DAY, "series": ENSEMBLE}
    if target in texts:
        return [texts[target].encode()]
    folders = {
        "material": (ROOT / "materials" / "ht", "*.yaml"),
        "specular": (ROOT / "materials" / "spec", "*.yaml"),
        "texture": (ROOT / "examples" / "textures", "*.png"),
    }
    if target in folders:
        folder, pattern = folders[target]
        return [path.read_bytes()[:20_000] for path in sorted(folder.glob(pattern))[:8]]
    tables = os.environ.get("SKYSHINE_FUZZ_TABLES")
    return [path.read_bytes() for path in sorted(Path(tables).glob(f"*{READERS[target][0]}"))] if tables else []


def read(target: str, data: bytes, folder: Path) -> None:
    """Hand bytes to the reader of a target, as the only file of a folder."""
    ending, reader = READERS[target]
    path = folder / f"in{ending}"
    path.write_bytes(data)
    reader(path)
