"""Every reader of what a user may hand us, as a function of bytes that may raise nothing but `InputError`."""

from __future__ import annotations

import base64
import datetime
import io
import json
import lzma
import os
import random
import re
import struct
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.soundings.files import read_levels, times_of
from skyshine.mat.atmosphere.state.profiles import load_profile
from skyshine.mat.atmosphere.state.sounding import continued
from skyshine.mat.job.load import load_job
from skyshine.mat.job.series import Series, members
from skyshine.mat.job.weather_files import read_weather
from skyshine.mat.radiometry.response_table import parse_response
from skyshine.mat.render.gltf_triangles import gltf_parts
from skyshine.mat.render.obj_triangles import obj_parts
from skyshine.mat.spectroscopy.lines import read_lines
from skyshine.mat.surface.weather_readings import read_record
from skyshine.mat.tables.loader import open_table
from skyshine.mat.tables.verify import problems
from skyshine.materials.files import SpecularFile, ThermalFile, load_spectrum
from skyshine.materials.library import load_library
from skyshine.materials.spectrum_files import Said, read_spectrum
from skyshine.schemas.csv_table import read_text
from skyshine.schemas.documents import load_model
from skyshine.tmm.classify.model_file import read_model
from skyshine.tmm.database.reader import open_tmm
from skyshine.tmm.exchange.cdb_materials import load_map
from skyshine.tmm.exchange.cdb_table import read_table
from skyshine.tmm.exchange.rasters import read_plane
from skyshine.tmm.images.georeference import read_georeference
from skyshine.tmm.images.texture import TextureFile
from skyshine.tmm.job.load import load_job as load_textures

sys.path.insert(0, str(Path(__file__).parent))
import good_databases
import hostile_random
import text_changes

ROOT = Path(__file__).parents[2]
JOB = """\
skyshine: 1
name: small
site: {latitude_deg: 29.7, longitude_deg: -82.0, date: 2026-06-28, utc_offset_h: -5}
states:
  - profile: midlatitude_summer
    gases: {O3: {column_du: 300}}
    weather: {air_temperature_c: [22, 33]}
    series: {first: 2026-01-01, last: 2026-01-03}
bands: [{wavelength_um: [8, 12]}, {wavenumber_cm: [2000, 3000]}]
materials: [asphalt_road]
output: {folder: built}
surface_grid: {time: ["00:00", "12:00"]}
"""
SOUNDING = "altitude[km],pressure[hPa],temperature[C],relative_humidity[%],O3[ppmv]\n0,1013,15,50,.03\n5,540,-18,30,.05\n12,193,-57,10,.2\n"  # noqa: E501
SONDE = "time [s];Height (m);P (hPa);Temp (degC);RH (%);wind\n0;10;1010;20;60;\n9;800;920.6;14.2;;3\n"
SONDE += "20;1500;846.4;10;43;///\n"
WYOMING = """\
94672 YPAD Adelaide Airport Observations at 06Z 15 Jan 2026

   PRES   HGHT   TEMP   DWPT   RELH   MIXR
    hPa     m      C      C      %    g/kg
------------------------------------------
 1025.0   -120
 1010.0     10   20.0   12.0     60   8.77
  920.6    800   14.2    9.0     71   7.85
  846.4   1500   10.0   -2.0     43   3.89
Station information and sounding indices
"""
IGRA = "#ASM00094672 2026 01 15 06 0517    3 ncdc6310 ncdc6310 -349500  1385300\n"
IGRA += "21     0 101000B   10B  200B-9999    80   220    30 \n30    20  -9999    50 -9999 -9999 -9999   220    31 \n"
IGRA += "20   240  84640B-9999B  100B-9999   120   220    30 \n"
RESPONSE = "# a filter\nwavelength[um],response\n8,0\n9,.9\n11,1\n12,0\n"
DAY = "time,air_temperature[C],relative_humidity[%],wind_speed[m/s]\n" + "".join(
    f"{h:02d}:00,{10 + h % 12},50,2\n" for h in range(24)
)
ENSEMBLE = 'date,visibility_km,weather.air_temperature_c\n2026-01-03,5,"[-4, 2]"\n2026-07-30,40,31\n'


EPW = "LOCATION,Test,CO,USA,TMY3,724666,39.74,-105.18,-7.0,1829.0\n" + "HEADER\n" * 7
EPW += "".join(f"1999,6,28,{h},0,?,{h}.0,1.0,40,82000,0,0,330{',0' * 8},{h / 2},5,4{',0' * 11}\n" for h in range(1, 25))
# Weather as its publishers write it.
METAR = "station,valid,tmpf,relh,sknt,skyc1,p01i\n"
METAR += "".join(f"KXX,2026-06-28 {h:02d}:53,{60 + h}.0,50,5,{'FEW' if h % 2 else 'M'},T\n" for h in range(24))
PSM = "Source,Location ID,Latitude,Longitude,Time Zone,Elevation\nNSRDB,1,45,9,-5,100\n"
PSM += "Year,Month,Day,Hour,Minute,DHI,DNI,Dew Point,Temperature,Pressure,Wind Speed\n"
PSM += "".join(f"2026,6,28,{h},30,{9 * h},{40 * h},10,{15 + h},990,2\n" for h in range(24))
PVGIS = "Latitude (decimal degrees):\t45.0\nLongitude (decimal degrees):\t9.0\nElevation (m):\t120.0\nSlope: 0 deg.\n\n"
PVGIS += "time,G(i),H_sun,T2m,WS10m,Int\n"
PVGIS += "".join(f"202606{d}:{h:02d}10,{20 * h},30,20.5,3,0\n" for d in (28, 29) for h in range(24)) + "\nG(i): light\n"
METEOSTAT = "date,hour,temp,rhum,prcp,wspd,pres\n"
METEOSTAT += "".join(f"2026-06-{d},{h},{h},80,0.1,9,1013\n" for d in (28, 29) for h in range(24))
PANGAEA = (
    "/* DATA DESCRIPTION:\nEvent\tX * LATITUDE: 46.8 * LONGITUDE: 6.9\n*/\nDate/Time\tSWD [W/m**2]\tT2 [C]\tRH [%]\n"
)
PANGAEA += "".join(f"2026-06-{d}T{h:02d}:00\t{20 * h}\t20.0\t50\n" for d in (28, 29) for h in range(24))
HISTORY = "193 0.250000\n" + "".join(
    f"{n / 4:.2f}-15.00 1000.00  0.65-20.00   5.00    98.02     5.17 1.00  0  0   0.00  0.00\n" for n in range(193)
)
TIRS = "A filter in nm\nWavelength  RSR  STDEV\n\n10300 -0.0005 .001\n10600 .4 .001\n10900 1 .001\n11400 0 .001\n"
MEASURED = "wavelength (um);reflectance\n" + "".join(f"{0.4 + n / 10:.1f};0,{10 + n}\n" for n in range(20))
OBJ = "mtllib in.mtl\nv 0 0 0\nv 4 0 0\nv 4 0 -4\nv 0 0 -4\nvt 0 0\nvt 1 0\nvt 1 1\nusemtl ground\n"
OBJ += "f 1/1 2/2 3/3\nf -4 -2 -1\n"
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]], np.float32)
GLTF = json.dumps(
    {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"children": [1], "rotation": [0, 0, 0, 1]}, {"mesh": 0, "scale": [2, 2, 2]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 5, "indices": 1, "material": 0}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "byteOffset": 0},
            {"bufferView": 1, "componentType": 5121, "count": 4, "type": "SCALAR", "normalized": False},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48, "byteStride": 12},
            {"buffer": 0, "byteOffset": 48, "byteLength": 4},
        ],
        "buffers": [
            {
                "byteLength": 52,
                "uri": "data:;base64," + base64.b64encode(CORNERS.tobytes() + bytes([0, 1, 2, 3])).decode(),
            }
        ],
        "materials": [{"name": "ground"}],
    }
)
ENVI = "ENVI\nsamples = 16\nlines = 1\nbands = 1\nheader offset = 0\nfile type = ENVI Spectral Library\ndata type = 4\n"
ENVI += "byte order = 0\ninterleave = bsq\nwavelength units = Micrometers\nreflectance scale factor = 1\n"
ENVI += "data ignore value = -9999\nspectra names = {slate}\n"
ENVI += f"wavelength = {{{', '.join(str(n / 4) for n in range(2, 18))}}}\n"
FORCING = "time,sw_down,lw_down,air_temperature,relative_humidity,wind_speed,pressure\n"
FORCING += "".join(f"2026-06-28T{h:02d}:00:00Z,{40 * h},350,{280 + h},50,2,100000\n" for h in range(24))
LINES = " 21 2349.143300 3.500E-18 2.000E+00.07450.099   16.38970.71-.002800".ljust(160) + "\n"
SPECTRUM = (
    "# a paint\n# range: 0.4 14 measured; by a spectrometer\nwavelength_um,reflectance\n0.4,0.1\n2.5,0.2\n14,0.05\n"
)
TEXTURES = """\
output: {folder: built}
textures:
  - name: road
    image: road.png
    classifier: {radius: 2, prior: {conifer: 5, asphalt_road: 1}}
    seeds: {polygons: {asphalt_road: [[[6, 60], [30, 60], [44, 112]]], conifer: [[[206, 66], [228, 62], [232, 100]]]}}
"""
MATERIAL = "<Material><Name>BM_SAND</Name><Weight>60</Weight></Material><Material><Name>BM_SOIL</Name><Weight>40</Weight></Material>"  # noqa: E501
CDB = f"<T><Composite_Material index='7'><Name>a</Name><Primary_Substrate>{MATERIAL}</Primary_Substrate>"
CDB += f"<Surface_Substrate>{MATERIAL}<Thickness>0.1</Thickness></Surface_Substrate></Composite_Material></T>"
LIBRARY = load_library()


def _job(path: Path) -> None:
    load_job(path).output_folder


def _sounding(path: Path) -> None:
    times_of(path)
    continued(read_levels(path), load_profile("us_standard"))


def _downloaded(path: Path) -> None:
    read_weather(path, datetime.date(2026, 6, 28), -5)


def _envi(path: Path) -> None:
    path.with_suffix(".sli").write_bytes(np.linspace(0.1, 0.6, 16, dtype=np.float32).tobytes())
    read_spectrum(path, Said())


def _series(path: Path) -> None:
    list(members(Series(table=path.name), path.parent))


def _table(path: Path) -> None:
    problems(path)
    table = open_table(path)
    for name in table.quantities:
        where = {rule.name: rule.nodes[0] for rule in table.rules(name)}
        table.value(name, **where)
        table.error(name)


@cache
def _good_databases() -> list[bytes]:
    with tempfile.TemporaryDirectory() as folder:
        written = good_databases.write_all(Path(folder))
        return [written[kind].read_bytes() for kind in good_databases.READ_BY_RUNTIMES]


def _structure(path: Path) -> None:
    """Read a good database whose structure is changed; the input is the seed of the draw."""
    draw = random.Random(path.read_bytes())
    path.write_bytes(draw.choice(_good_databases()))
    hostile_random.mutate_apart(path, draw)
    _table(path)


def _texture(path: Path) -> None:
    read_georeference(path)
    image = TextureFile(path)
    image.window(slice(0, min(4, image.height)), slice(0, image.width))


def _flat(path: Path) -> None:
    table = open_table(path)
    for name in table.quantities:
        table.rules(name)


def _database(path: Path) -> None:
    problems(path)
    with open_tmm(path) as file:
        file.attributes


def _lines(path: Path) -> None:
    read_lines(path).between(2000, 3000)


# By target: ending of its file, what reads it.
READERS: dict[str, tuple[str, Callable[[Path], object]]] = {
    "job": (".yaml", _job),
    "material": (".yaml", lambda path: load_model(path, ThermalFile)),
    "specular": (".yaml", lambda path: load_model(path, SpecularFile)),
    "sounding": (".csv", _sounding),
    "sonde": (".csv", _sounding),
    "wyoming": (".txt", _sounding),
    "igra": (".txt", _sounding),
    "netcdf": (".nc", _sounding),
    "response": (".csv", lambda path: parse_response(read_text(path), path)),
    "weather": (".csv", lambda path: read_weather(path, datetime.date(2026, 6, 28), -5)),
    "series": (".csv", _series),
    "response_text": (".txt", lambda path: parse_response(read_text(path), path)),
    "measured": (".csv", lambda path: read_spectrum(path, Said())),
    "envi": (".hdr", _envi),
    "gltf": (".gltf", gltf_parts),
    "glb": (".glb", gltf_parts),
    "obj": (".obj", obj_parts),
    **dict.fromkeys(("metar", "psm", "pvgis", "meteostat"), (".csv", _downloaded)),
    "pangaea": (".tab", _downloaded),
    "history": (".wth", _downloaded),
    "weather_netcdf": (".nc", _downloaded),
    "epw": (".epw", lambda path: read_weather(path, datetime.date(2026, 6, 28), -6, radiation=True)),
    "tmy3": (".csv", lambda path: read_weather(path, datetime.date(2026, 6, 28), -5, radiation=True)),
    "forcing": (".csv", read_record),
    "spectrum": (".csv", load_spectrum),
    "lines": (".par", _lines),
    "lines_xz": (".par.xz", _lines),
    "texture_job": (".yaml", lambda path: load_textures(path, LIBRARY)),
    "texture": (".png", _texture),
    "tiff": (".tif", _texture),
    "indices": (".png", read_plane),
    "cdb_table": (".xml", read_table),
    "cdb_map": (".yaml", lambda path: load_map(LIBRARY, path)),
    "classifier": (".tmm-model.h5", read_model),
    "database": (".tmm.h5", _database),
    "table": (".h5", _table),
    "structure": (".h5", _structure),
    "flat": (".raw.json", _flat),
}
TEXTS = {
    "job": JOB,
    "sounding": SOUNDING,
    "sonde": SONDE,
    "wyoming": WYOMING,
    "igra": IGRA,
    "response": RESPONSE,
    "weather": DAY,
    "series": ENSEMBLE,
    "epw": EPW,
    "forcing": FORCING,
    "spectrum": SPECTRUM,
    "lines": LINES,
    "texture_job": TEXTURES,
    "cdb_table": CDB,
    "response_text": TIRS,
    "measured": MEASURED,
    "envi": ENVI,
    "gltf": GLTF,
    "obj": OBJ,
    "metar": METAR,
    "psm": PSM,
    "pvgis": PVGIS,
    "meteostat": METEOSTAT,
    "pangaea": PANGAEA,
    "history": HISTORY,
}
FOLDERS = {
    "material": (ROOT / "materials" / "ht", "*.yaml"),
    "specular": (ROOT / "materials" / "spec", "*.yaml"),
    "cdb_map": (ROOT / "materials" / "exchange", "cdb.yaml"),
}
# Files that a build makes, in the folder SKYSHINE_FUZZ_TABLES.
TABLES = {"table": "[sb]0*.h5", "flat": "*.raw.json", "classifier": "*.tmm-model.h5", "database": "*.tmm.h5"}


def seeds(target: str) -> list[bytes]:
    """Good inputs of a target, from which others are bred; of `TABLES` those in the folder SKYSHINE_FUZZ_TABLES, if
    any.
    """
    if target in TEXTS:
        return [TEXTS[target].encode()]
    if target == "lines_xz":
        return [lzma.compress(LINES.encode())]
    if target in ("texture", "tiff", "indices"):
        return [_picture(target)]
    if target == "tmy3":
        return _tmy3()
    if target == "netcdf":
        return [_netcdf()]
    if target == "weather_netcdf":
        return [_point()]
    if target == "glb":
        return [_binary(GLTF.encode())]
    if target == "structure":
        return [bytes([number]) for number in range(8)]
    folder, pattern = FOLDERS.get(target) or (os.environ.get("SKYSHINE_FUZZ_TABLES"), TABLES[target])
    found = [path.read_bytes() for path in sorted(Path(folder).glob(pattern))[:8]] if folder else []
    return [re.sub(rb'"data": "[^"]*"', b'"data": "in.raw.bin"', data) for data in found] if target == "flat" else found


def changed(target: str, seed: bytes, draw: random.Random) -> bytes | None:
    """A good input with its values or its form changed; nothing for targets that are no text."""
    if target in ("gltf", "legend"):
        return text_changes.changed_json(seed, draw)
    if target == "glb":
        return _binary(text_changes.changed_json(GLTF.encode(), draw))
    return text_changes.changed_text(seed, draw) if target in {*TEXTS, *FOLDERS} else None


def _binary(document: bytes) -> bytes:
    """A glTF document as one chunk of a binary file."""
    padded = document + b" " * (-len(document) % 4)
    return struct.pack("<4sIIII", b"glTF", 2, 20 + len(padded), len(padded), 0x4E4F534A) + padded


def _picture(target: str) -> bytes:
    """A small image: colours, georeferenced TIFF or grey."""
    from PIL import Image

    shape = (12, 16) if target == "indices" else (12, 16, 3)
    picture = Image.fromarray((np.arange(np.prod(shape)) % 5).astype(np.uint8).reshape(shape))
    content = io.BytesIO()
    if target == "tiff":
        tags = {
            33550: (0.5, 0.5, 0.0),
            33922: (0.0, 0.0, 0.0, 5e5, 4.1e6, 0.0),
        }  # GeoTIFF: size of a texel, place of the first
        picture.save(content, format="TIFF", compression="tiff_lzw", tiffinfo=tags)
    else:
        picture.save(content, format="PNG")
    return content.getvalue()


def _netcdf() -> bytes:
    """A column on three pressure levels."""
    from netCDF4 import Dataset

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "column.nc"
        with Dataset(path, "w") as data:
            for name, unit, values in (
                ("time", "hours since 2026-01-15", [6.0]),
                ("level", "hPa", [1010.0, 920.0, 846.0]),
            ):
                data.createDimension(name, len(values))
                data.createVariable(name, "f8", (name,))[:] = values
                data[name].units = unit
            for name, unit, values in (
                ("t", "K", [293.0, 287.0, 283.0]),
                ("q", "kg kg**-1", [0.008, 0.007, 0.003]),
                ("z", "m**2 s**-2", [100.0, 7850.0, 14700.0]),
            ):
                data.createVariable(name, "f4", ("time", "level"))[:] = values
                data[name].units = unit
        return path.read_bytes()


def _point() -> bytes:
    """Two days of temperature, dew point and light at a point."""
    from netCDF4 import Dataset

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "point.nc"
        with Dataset(path, "w") as data:
            data.createDimension("valid_time", 48)
            clock = data.createVariable("valid_time", "i8", ("valid_time",))
            clock.units, clock[:] = "hours since 2026-06-27", np.arange(48)
            for name, value in (("t2m", 290.0), ("d2m", 280.0), ("ssrd", 360000.0)):
                data.createVariable(name, "f4", ("valid_time",))[:] = value
        return path.read_bytes()


def _tmy3() -> list[bytes]:
    """Header and one day of pvlib's sample file, where pvlib comes with it."""
    import pvlib

    file = Path(pvlib.__file__).parent / "data" / "723170TYA.CSV"
    if not file.is_file():
        return []
    lines = file.read_bytes().splitlines(keepends=True)
    return [b"".join([*lines[:2], *(line for line in lines[2:] if line.startswith(b"06/28"))])]


def read(target: str, data: bytes, folder: Path) -> None:
    """Hand bytes to the reader of a target, as a file ``in``; with zeros beside it where it is the header of a flat
    export.
    """
    ending, reader = READERS[target]
    path = folder / f"in{ending}"
    path.write_bytes(data)
    if target == "flat":
        named = re.search(rb'"bytes": (\d{1,6})\b', data)
        (folder / "in.raw.bin").write_bytes(bytes(int(named[1]) if named else 0))
    reader(path)
