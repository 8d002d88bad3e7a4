"""Heat signatures for the thermal camera of Gazebo: grey textures of apparent temperature.

The system plugin ``gz::sim::systems::Thermal`` of a visual takes either a uniform ``<temperature>`` or a
``<heat_signature>``, a texture whose red channel r (0 to 1) means min_temp + r (max_temp - min_temp) kelvin (gz-sim,
``src/systems/thermal/Thermal.cc``; gz-rendering, ``heat_signature_fs.glsl``). The camera knows no air, so that the
temperatures are apparent ones, from one line of sight.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import numpy as np

from skyshine.mat.render.contrast import Face, Sight, seen_radiance
from skyshine.mat.render.databases import BandTables, SceneTables, held_hours
from skyshine.mat.runtime.equivalent_temperature import equivalent_temperature
from skyshine.schemas.arrays import Floats, Reals
from skyshine.schemas.errors import InputError
from skyshine.tmm.database.levels import WEIGHT_TOTAL
from skyshine.tmm.exchange.files import write_bytes, write_json
from skyshine.tmm.exchange.image import MaterialImage, read_levels

WHITE = 255  # white of 8 bit grey
ROWS = 256  # rows of a texture that are computed together: bounds memory
PLUGIN = """<!-- Inside the <visual> whose surface has this texture. -->
<plugin filename="gz-sim-thermal-system" name="gz::sim::systems::Thermal">
  <heat_signature>{image}</heat_signature>
  <min_temp>{low:.3f}</min_temp>
  <max_temp>{high:.3f}</max_temp>
</plugin>
"""


@dataclass(frozen=True)
class Moment:
    """When, and from where, surfaces are seen.

    Attributes
    ----------
    hour : float
        Local clock [h].
    band : str or None
        Name of the band; None if there is only one.
    state : int
        Counted from 1.
    source : {'sun', 'moon'}
    """

    hour: float
    sight: Sight
    band: str | None = None
    state: int = 1
    source: str = "sun"


def write_heat_signatures(folder: Path, out: Path, moment: Moment, unknown_material: str | None = None) -> list[Path]:
    """Write ``NAME.heat.png`` and ``NAME.thermal.sdf`` for each texture of a folder, and ``temperatures.json``.

    Parameters
    ----------
    folder : Path
        Folder of a finished build.
    out : Path
        Folder to write into.
    unknown_material : str, optional
        Material of texels without material; without it a texture that has such texels is refused.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        A database, a material or a place is missing, the band is not named among several, or a texture has texels
        without material.
    """
    bands = None if moment.band is None else [moment.band]
    tables = SceneTables.of(folder, state=moment.state, bands=bands, source=moment.source)
    if len(tables.bands) > 1:
        names = ", ".join(read.name for read in tables.bands)
        raise InputError(f"contains the bands {names}; a heat signature is of one; name it with --band", file=folder)
    if not held_hours(tables.surface, np.array([moment.hour]))[0]:
        raise InputError(f"contains no temperatures at {moment.hour:g} h; name an hour of the tables", file=folder)
    read, paths = tables.bands[0], []
    radiance = _radiance_by_code(tables, read, moment)
    kelvin = {
        name: float(equivalent_temperature(read.band, np.array([radiance[code]]))[0])
        for name, code in tables.surface.materials.items()
    }
    textures: dict[str, Any] = {}
    for database in sorted(folder.glob("*.tmm.h5")):
        image = read_levels(database)[0]
        _refuse_strangers(database, image, tables, unknown_material)
        stranger = 0 if unknown_material is None else tables.surface.materials[unknown_material]
        grey, low, high = grey_of(_texel_temperature(image, read, radiance, stranger))
        picture, snippet = out / f"{image.name}.heat.png", out / f"{image.name}.thermal.sdf"
        write_bytes(picture, _png(grey))
        write_bytes(snippet, PLUGIN.format(image=escape(picture.name), low=low, high=high).encode())
        paths += [picture, snippet]
        textures[image.name] = {"image": picture.name, "min_temp": low, "max_temp": high, "step": (high - low) / WHITE}
    about = {"band": read.name, "state": moment.state, "source": moment.source, "hour": moment.hour}
    line = {"range_km": moment.sight.range, "elevation_deg": moment.sight.elevation}
    line["heading_deg"] = moment.sight.heading
    write_json(
        out / "temperatures.json",
        {**about, "line_of_sight": line, "units": "K", "materials": kelvin, "textures": textures},
    )
    return [*paths, out / "temperatures.json"]


def grey_of(kelvin: Reals) -> tuple[Any, float, float]:
    """8 bit grey of temperatures, with the least and the highest, in whole hundredths [K].

    One temperature alone gets a range of 1 K around it, for the plugin divides by the range.
    """
    low, high = np.floor(100 * float(kelvin.min())) / 100, np.ceil(100 * float(kelvin.max())) / 100
    if high - low < 1.0:
        low, high = low - 0.5, high + 0.5
    return np.rint((kelvin - low) / (high - low) * WHITE).astype(np.uint8), float(low), float(high)


def _radiance_by_code(tables: SceneTables, read: BandTables, moment: Moment) -> Floats:
    """Radiance of level faces by material code; NaN where the tables have no such material."""
    materials = tables.surface.materials
    codes = tables.codes(dict.fromkeys(materials, ()))
    radiance = np.full(1 << 16, np.nan)
    hours = np.array([moment.hour])
    for name, code in zip(materials, codes, strict=True):
        face = Face(name)
        radiance[code] = seen_radiance(tables, read, face, int(code), moment.sight, hours, source=moment.source)[0]
    return radiance


def _texel_temperature(image: MaterialImage, read: BandTables, radiance: Floats, stranger: int) -> Reals:
    """Apparent temperature (H, W) of texels, float32: of their materials by their shares, `stranger` for none."""
    kelvin = np.empty(image.level.code.shape, np.float32)
    for top in range(0, image.height, ROWS):
        rows = slice(top, top + ROWS)
        shares, codes = image.level.mix_weight[rows] / WEIGHT_TOTAL, image.level.mix_code[rows]
        of_codes = radiance[np.where(codes == 0, stranger, codes)]
        mixed = np.where(shares > 0, shares * of_codes, 0.0).sum(axis=-1)
        kelvin[rows] = equivalent_temperature(read.band, mixed.ravel()).reshape(mixed.shape)
    return kelvin


def _refuse_strangers(database: Path, image: MaterialImage, tables: SceneTables, unknown: str | None) -> None:
    """Refuse materials that the tables lack, and texels without material where no substitute is named."""
    present = [int(code) for code in np.unique(image.level.mix_code[image.level.mix_weight > 0])]
    names = [image.materials[code] for code in present if code] + ([] if unknown is None else [unknown])
    tables.codes(dict.fromkeys(names, ()))
    if 0 in present and unknown is None:
        empty = int(((image.level.mix_code == 0) & (image.level.mix_weight > 0)).any(axis=-1).sum())
        raise InputError(
            f"has {empty} texels without material; name a substitute with --unknown-material", file=database
        )


def _png(grey: Any) -> bytes:
    from PIL import Image

    content = io.BytesIO()
    Image.fromarray(grey).save(content, format="PNG", optimize=False)
    return content.getvalue()
