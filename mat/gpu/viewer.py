"""A folder that shows a plan of materials in the infrared, in any browser with WebGL2, without a server.

The page evaluates equation (1) with the include of the export, from the export's own textures.
"""

from __future__ import annotations

import base64
import json
import shutil
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.mat.gpu.air import relative
from skyshine.mat.gpu.band import export_band
from skyshine.mat.gpu.codes import export_codes
from skyshine.mat.gpu.container import GpuFile, header_of
from skyshine.mat.gpu.coordinates import AirCoordinates
from skyshine.mat.gpu.export import AirSet, air_sets, databases, exported_air
from skyshine.mat.gpu.shader import shader
from skyshine.mat.gpu.surface import export_surface
from skyshine.mat.runtime.shade import SHADED_SKY
from skyshine.schemas.errors import InputError
from skyshine.schemas.whole_files import write_whole
from skyshine.tmm.database.reader import TmmFile, find_image, open_tmm

PAGE = "viewer.html.j2"
SCRIPTS = ("tables.js", "surfaces.js", "viewer.js")  # in the order in which the page loads them
TEXELS = 14_000  # texels of the air at one altitude, for differences from the library below 0.05 K
LARGEST = 2048  # columns or rows of a plan; larger textures are shown by a mip level
PALETTE_STEPS = 64  # colours, between which a palette is linear: Inferno within 2 of 255
FARTHEST_KM, _ABOVE_KM, _HOUR = 30.0, 1.0, 14.0


@dataclass(frozen=True, eq=False)
class Plan:
    """What the page shows.

    Attributes
    ----------
    files : list of Path
        Databases.
    texture : Path
        Texture of the plan view.
    surface_km, altitude_km : float
        Altitudes of surface and observer.
    metres_per_texel : float
        Size of a texel of level 0 [m].
    image : Path or None
        Photograph of the plan.
    """

    files: list[Path]
    texture: Path
    surface_km: float
    altitude_km: float
    metres_per_texel: float
    image: Path | None


def plan_of_folder(
    folder: Path, *, texture: str | None = None, altitude: float | None = None, metres_per_texel: float
) -> Plan:
    """The plan of a texture among built databases.

    Parameters
    ----------
    texture : str, optional
        Name of the texture; the first one by default.
    altitude : float, optional
        Altitude of the observer [km]; by default 1 km above the surface.

    Raises
    ------
    InputError
        The folder has no finished build, no texture, or no atmosphere.
    """
    if not folder.is_dir():
        raise InputError("is not a folder of databases; name one that 'mat build' wrote", file=folder)
    files = databases([folder])
    textures = {file.name.removesuffix(".tmm.h5"): file for file in files if file.name.endswith(".tmm.h5")}
    if not textures:
        raise InputError("has no texture (.tmm.h5); add one to the job and build it", file=folder)
    if texture is not None and texture not in textures:
        raise InputError(f"found the texture '{texture}'; allowed: {', '.join(textures)}", file=folder)
    path = textures[texture or next(iter(textures))]
    sets = air_sets(files)
    if not sets:
        raise InputError("has no atmosphere; build one with 'mat build'", file=folder)
    surface = float(np.asarray(sets[0].surface.root.axes["altitude"].values, float)[0])
    low, high = AirCoordinates.of(sets[0].air).altitude_km
    if altitude is None:
        altitude = float(np.clip(surface + _ABOVE_KM, low, high))
    if not (low <= altitude <= high and altitude > surface):
        raise InputError(f"altitude: found {altitude:g}; allowed: {max(low, surface):g} to {high:g} km", file=folder)
    with open_tmm(path) as file:
        try:
            image = find_image(file, path, None)
        except InputError:  # a viewer without the photograph is of use
            image = None
    return Plan(files, path, surface, altitude, metres_per_texel, image)


def write_viewer(plan: Plan, folder: Path) -> Path:
    """Write the page with its data; nothing of it is asked for elsewhere.

    Returns
    -------
    Path
        Of the page.

    Raises
    ------
    InputError
        A material of the texture is missing in a band or a table of temperatures, a table lacks the response to the
        texture's shade, or the folder cannot be written.
    """
    sets = air_sets(plan.files)
    exported: dict[str, GpuFile] = {}
    with open_tmm(plan.texture) as file:
        name = plan.texture.name.removesuffix(".h5")
        level = next(n for n in range(file.levels) if max(file.size(n)) <= LARGEST)
        exported[name] = _level(export_codes(file, plan.texture.name), level)
        shaded_sky = SHADED_SKY if file.has_shade else None
        rows, columns = file.size(level)
        scale = plan.metres_per_texel * file.width / columns
        _refuse_missing(file, sets, plan.texture)
    for air_set in sets:
        exported[air_set.name] = exported_air(
            air_set, None, altitude=plan.altitude_km, range_km=FARTHEST_KM, texels=TEXELS
        )
        exported.setdefault(table_name(air_set.band.path), export_band(air_set.band))
        surface = table_name(air_set.surface.path)
        if surface not in exported:
            exported[surface] = export_surface(
                air_set.surface, level=True, altitudes_km=[plan.surface_km], shaded_sky=shaded_sky
            )
    nearest = plan.altitude_km - plan.surface_km
    aside = 1e-3 * scale * float(np.hypot(rows, columns))  # corners are farther from the observer than the centre
    farthest = min(FARTHEST_KM, *(float(AirCoordinates.of(air_set.air).range_km[1]) - aside for air_set in sets))
    settings = {
        "texture": name,
        "columns": columns,
        "rows": rows,
        "metres_per_texel": scale,
        "surface_km": plan.surface_km,
        "altitude_km": plan.altitude_km,
        "range_km": [nearest, max(farthest, nearest)],
        "bands": bands_of(sets),
    }
    return write_page(name.removesuffix(".tmm"), settings, exported, folder, plan.image)


def write_page(
    title: str,
    settings: dict[str, Any],
    exported: dict[str, GpuFile],
    folder: Path,
    image: Path | None,
    hour: float = _HOUR,
) -> Path:
    """Write a page with its data and its scripts.

    Parameters
    ----------
    settings : dict
        What the script reads beside the data.
    image : Path, optional
        The photograph that the page shows in place of the picture.
    hour : float
        Local clock [h] that the page begins with.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    try:
        (folder / "data").mkdir(parents=True, exist_ok=True)
        for data, content in exported.items():
            write_whole(folder / "data" / f"{data}.js", _script(data, content))
        photo = _copied(image, folder)
        for script in SCRIPTS:
            text = resources.files(__package__).joinpath(script).read_text(encoding="utf-8")
            write_whole(folder / script, text)
        page = _page(title, settings, [*(f"data/{data}.js" for data in exported), *SCRIPTS], photo, hour)
        write_whole(folder / "index.html", page)
    except OSError as error:
        words = error.strerror or error
        raise InputError(f"cannot be written: {words}; check free space and permissions", file=folder) from None
    return folder / "index.html"


def table_name(path: Path) -> str:
    """Name of a database among the data of a page."""
    return path.name.removesuffix(".h5")


def _level(content: GpuFile, level: int) -> GpuFile:
    """One mip level of a texture, as its first."""
    textures = {"level0": content.textures[f"level{level}"], "mixtures": content.textures["mixtures"]}
    if f"shade{level}" in content.textures:
        textures["shade0"] = content.textures[f"shade{level}"]
    return GpuFile(content.kind, content.source, textures, content.numbers | {"levels": 1}, content.stated_error)


def _refuse_missing(file: TmmFile, sets: list[AirSet], path: Path) -> None:
    for air_set in sets:
        band, surface = air_set.band.materials, air_set.surface.materials
        for code, material in file.materials.items():
            for table, material_codes in ((air_set.band, band), (air_set.surface, surface)):
                if code not in material_codes.values():
                    raise InputError(
                        f"lacks '{material}' of the texture {path.name}; build it with that material", file=table.path
                    )
        if list(band.values()) != list(surface.values()):
            raise InputError(
                f"has other materials than {air_set.surface.path.name}; build both from one job", file=air_set.band.path
            )


def bands_of(sets: list[AirSet]) -> list[dict[str, Any]]:
    """States and bands with the atmospheres of their sources."""
    bands: dict[str, dict[str, Any]] = {}
    airs: dict[str, dict[str, str]] = {}
    states = {air_set.surface.path.name for air_set in sets}
    for air_set in sets:
        name = air_set.name.split(".")[0]
        low, high = np.asarray(air_set.air.attributes["wavelength_um"], float)
        title = f"{low:g} to {high:g} µm"
        if len(states) > 1:
            title = f"{air_set.surface.path.name.split('.')[0]}, {title}"
        entry = {
            "name": name,
            "title": title,
            "band": table_name(air_set.band.path),
            "surface": table_name(air_set.surface.path),
            "relative": relative(air_set.air),
        }
        bands.setdefault(name, entry)
        airs.setdefault(name, {})[str(air_set.air.attributes.get("source", "sun"))] = air_set.name
    # The Sun first: it is taken where no source is chosen.
    return [
        entry | {"air": dict(sorted(airs[name].items(), key=lambda item: item[0] != "sun"))}
        for name, entry in bands.items()
    ]


def _script(name: str, content: GpuFile) -> str:
    header, pieces = header_of(content, f"{name}.js")
    data = base64.b64encode(b"".join(pieces)).decode("ascii")
    return f"skyshineData({_json(name)}, {_json(header)}, {_json(data)});\n"


def _json(value: Any) -> str:
    """JSON that a script of a page may contain."""
    return json.dumps(value, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def _copied(image: Path | None, folder: Path) -> str | None:
    if image is None:
        return None
    name = f"photo{image.suffix.lower()}"
    shutil.copyfile(image, folder / name)
    return name


def _page(title: str, settings: dict[str, Any], scripts: list[str], photo: str | None, hour: float) -> str:
    import jinja2
    import markupsafe

    settings = settings | {"palettes": _palettes()}
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    source = resources.files(__package__).joinpath(PAGE).read_text(encoding="utf-8")
    return environment.from_string(source).render(
        title=title,
        settings=markupsafe.Markup(_json(settings)),
        include=markupsafe.Markup(shader("GLSL")),
        scripts=scripts,
        photo=photo,
        hour=hour,
        aspect=f"{settings['columns'] / settings['rows']:.4f}",
    )


def _palettes() -> list[dict[str, Any]]:
    """Names of palettes, and their colours from cold to hot at equal steps."""
    from matplotlib import colormaps

    steps = np.linspace(0.0, 1.0, PALETTE_STEPS)
    maps = {"White hot": "gray", "Black hot": "gray_r", "Inferno": "inferno"}
    return [
        {"name": name, "colours": np.rint(255 * colormaps[entry](steps)[:, :3]).astype(int).tolist()}
        for name, entry in maps.items()
    ]
