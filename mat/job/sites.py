"""Many sites in one job: a list, a CSV table or a grid of tiles; each becomes a job of its own."""

from __future__ import annotations

import datetime
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
import pydantic
from pydantic import Field

from skyshine.mat.job.series import MEMBER_LIMIT, rows_of_table
from skyshine.schemas.documents import Document, StrictModel, parse_model, problem_text
from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import job_path

NAME_IN_TEXTS = "{site}"  # mark of a site's name in the texts of states
_ALTITUDE_STEP_KM = 0.05  # altitude step of tiles: those of one step share their air
_LOWEST_KM, _HIGHEST_KM = -0.5, 5.9  # altitude of ground [km], from the shore of the Dead Sea to high mountain stations
_OWN = ("latitude_deg", "longitude_deg", "date", "utc_offset_h", "altitude_km")
_NEEDED = ("latitude_deg", "longitude_deg", "date", "utc_offset_h")

Latitude = Annotated[float, Field(ge=-90, le=90)]
Longitude = Annotated[float, Field(ge=-180, le=180)]


class NamedSite(StrictModel):
    """One of several sites; what it does not state is that of `site`."""

    name: str = Field(
        pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,59}$",
        description=(
            "Folder of its files, and {site} in the texts of states: letters, digits, dots, dashes, underscores."
        ),
    )
    latitude_deg: Latitude = Field(description="North is positive.")
    longitude_deg: Longitude = Field(description="East is positive.")
    date: datetime.date | None = Field(None, description="Local day of the scene.")
    utc_offset_h: float | None = Field(None, ge=-12, le=14, description="Local clock time minus UTC.")
    altitude_km: float | None = Field(None, ge=_LOWEST_KM, le=_HIGHEST_KM, description="Altitude of the ground.")


class Tiles(StrictModel):
    """Tiles between parallels and meridians; the site of each is its middle."""

    latitude_deg: tuple[Latitude, Latitude] = Field(description="South and north edge.")
    longitude_deg: tuple[Longitude, Longitude] = Field(description="West and east edge.")
    step_deg: float = Field(gt=0, le=90, description="Height and width of a tile.")
    elevation: str | None = Field(
        None,
        min_length=1,
        description=(
            "Raster of heights in m with a georeference (GeoTIFF), relative to the job: a tile has their mean, to 0.05"
            " km; without it, all have the altitude_km of site."
        ),
    )

    @pydantic.model_validator(mode="after")
    def _upright(self) -> Self:
        for key in ("latitude_deg", "longitude_deg"):
            low, high = getattr(self, key)
            if not high > low:
                raise ValueError(f"found {key} [{low:g}, {high:g}]; allowed: [low, high]; swap them")
        if np.prod(self._counts) > MEMBER_LIMIT:
            raise ValueError(
                f"found more than {MEMBER_LIMIT} tiles; allowed: at most that many; take a larger step_deg"
            )
        return self

    @property
    def _counts(self) -> list[int]:
        edges = (self.latitude_deg, self.longitude_deg)
        return [max(1, int((high - low) / self.step_deg + 1e-9)) for low, high in edges]

    def middles(self) -> Iterator[tuple[float, float]]:
        """Latitude and longitude of each tile, from the southwest on."""
        rows, columns = self._counts
        for i in range(rows):
            for j in range(columns):
                south, west = (
                    low + k * self.step_deg for low, k in ((self.latitude_deg[0], i), (self.longitude_deg[0], j))
                )
                yield round(south + self.step_deg / 2, 6), round(west + self.step_deg / 2, 6)


class TiledSites(StrictModel):
    """Sites by a grid of tiles."""

    tiles: Tiles = Field(description="The grid.")


def _kind(value: Any) -> str:
    return "tiles" if isinstance(value, dict | TiledSites) else "list" if isinstance(value, list | tuple) else "table"


SitesChoice = Annotated[
    Annotated[tuple[NamedSite, ...], Field(min_length=1, max_length=MEMBER_LIMIT), pydantic.Tag("list")]
    | Annotated[str, Field(min_length=1), pydantic.Tag("table")]
    | Annotated[TiledSites, pydantic.Tag("tiles")],
    pydantic.Discriminator(_kind),
]


class _Sites(StrictModel):
    sites: SitesChoice


@dataclass(frozen=True)
class SiteDocument:
    """The job of one site.

    Attributes
    ----------
    document : Document
        The job with `site` in the place of `sites`, the name of the site in the texts of its states.
    """

    name: str
    document: Document


def has_sites(document: Document) -> bool:
    """Whether a job has several sites."""
    return isinstance(document.data, dict) and "sites" in document.data


def site_documents(document: Document) -> tuple[SiteDocument, ...]:
    """The jobs of all sites of a job that has several.

    Raises
    ------
    InputError
        A site does not fit, lacks what `site` does not have either, or has the name of another.
    """
    common = document.data.get("site", {})
    if not isinstance(common, dict):
        raise document.error(("site",), "site: found no mapping; allowed: keys that all sites have in common")
    sites = _named_sites(document, common)
    names: set[str] = set()
    for i, site in enumerate(sites):
        place = ("sites", i) if isinstance(document.data["sites"], list) else ("sites",)
        if site.name.lower() in names or site.name == "pictures":
            raise document.error(
                place, f"sites: found the name '{site.name}' twice or 'pictures'; allowed: names once each; rename it"
            )
        names.add(site.name.lower())
        for key in _NEEDED:
            if getattr(site, key) is None and key not in common:
                raise document.error(
                    place, f"sites: '{site.name}' has no {key}; allowed: one in each site, or one in site for all"
                )
    return tuple(SiteDocument(site.name, _document_of(document, common, site)) for site in sites)


def _document_of(document: Document, common: dict[str, Any], site: NamedSite) -> Document:
    own = {key: value for key in _OWN if (value := getattr(site, key)) is not None}
    if "date" in own:
        own["date"] = own["date"].isoformat()
    data = {key: value for key, value in document.data.items() if key != "sites"}
    data |= {"site": common | own}
    if "states" in data:
        data["states"] = _named_texts(data["states"], site.name)
    return replace(document, data=data)


def _named_texts(value: Any, name: str) -> Any:
    """The value with the name of a site in all its texts."""
    if isinstance(value, dict):
        return {key: _named_texts(item, name) for key, item in value.items()}
    if isinstance(value, list):
        return [_named_texts(item, name) for item in value]
    return value.replace(NAME_IN_TEXTS, name) if isinstance(value, str) else value


def _named_sites(document: Document, common: dict[str, Any]) -> Sequence[NamedSite]:
    part = replace(document, data={"sites": document.data["sites"]})
    sites = parse_model(part, _Sites).sites
    if isinstance(sites, TiledSites):
        return _tile_sites(document, sites.tiles)
    if not isinstance(sites, str):
        return sites
    try:
        file = job_path(document.file.resolve().parent, sites)
    except ValueError as error:
        raise document.error(("sites",), f"sites: {error}") from None
    if not file.is_file():
        raise document.error(
            ("sites",), f"sites: found '{sites}', which is no file; give the path of a CSV table from the job's folder"
        )
    return _table_sites(file)


def _table_sites(file: Path) -> list[NamedSite]:
    """A site for each row; columns are the keys of a site."""
    sites = []
    for values, line in rows_of_table(file):
        row = {key: value for key, value in values.items() if value is not None}
        if "name" in row:
            row["name"] = str(row["name"])
        try:
            sites.append(NamedSite.model_validate(row))
        except pydantic.ValidationError as error:
            problem = error.errors(include_url=False)[0]
            message = f"{'.'.join(map(str, problem['loc']))}: {problem_text(problem)}".removeprefix(": ")
            raise InputError(message, file=file, line=line) from None
    return sites


def _tile_sites(document: Document, tiles: Tiles) -> list[NamedSite]:
    middles = list(tiles.middles())
    altitudes: list[float | None] = [None] * len(middles)
    if tiles.elevation is not None:
        place = ("sites", "tiles", "elevation")
        try:
            file = job_path(document.file.resolve().parent, tiles.elevation)
        except ValueError as error:
            raise document.error(place, f"sites.tiles.elevation: {error}") from None
        if not file.is_file():
            raise document.error(
                place,
                f"sites.tiles.elevation: found '{tiles.elevation}', which is no file; give its path from the job's"
                " folder",
            )
        altitudes = list(_tile_altitudes(file, middles, tiles.step_deg))
    return [_tile(*middle, altitude) for middle, altitude in zip(middles, altitudes, strict=True)]


def _tile(latitude: float, longitude: float, altitude: float | None) -> NamedSite:
    """The site of a tile, by the name of its middle: n47.25e8.75."""
    name = f"{'s' if latitude < 0 else 'n'}{abs(latitude):g}{'w' if longitude < 0 else 'e'}{abs(longitude):g}"
    return NamedSite(name=name, latitude_deg=latitude, longitude_deg=longitude, altitude_km=altitude)


def _tile_altitudes(file: Path, middles: Sequence[tuple[float, float]], step: float) -> Iterator[float]:
    """Mean altitude [km] of each tile, in steps in which tiles share their air.

    Raises
    ------
    InputError
        The file is no raster with a georeference, covers no part of a tile, or has heights that are not the Earth's.
    """
    import rasterio
    from rasterio.errors import RasterioError
    from rasterio.warp import transform_bounds
    from rasterio.windows import Window, from_bounds

    try:
        with rasterio.open(file) as raster:
            if raster.crs is None:
                raise InputError("has no georeference; allowed: a GeoTIFF of heights in m with one", file=file)
            whole = Window(0, 0, raster.width, raster.height)
            for latitude, longitude in middles:
                half = step / 2
                edges = (longitude - half, latitude - half, longitude + half, latitude + half)
                bounds = transform_bounds("EPSG:4326", raster.crs, *edges)
                window = from_bounds(*bounds, transform=raster.transform).round()
                heights = np.ma.empty(0)
                if rasterio.windows.intersect(whole, window):
                    heights = raster.read(1, window=window.intersection(whole), masked=True).astype(float)
                    heights = np.ma.masked_invalid(heights)
                if not heights.count():
                    raise InputError(
                        f"has no height in the tile at latitude {latitude:g}, longitude {longitude:g}; allowed: a"
                        " height in each tile; take a raster that covers them, or fewer tiles",
                        file=file,
                    )
                altitude = _ALTITUDE_STEP_KM * round(float(heights.mean()) / 1e3 / _ALTITUDE_STEP_KM)
                if not _LOWEST_KM <= altitude <= _HIGHEST_KM:
                    raise InputError(
                        f"has {1e3 * altitude:g} m in the tile at latitude {latitude:g}, longitude {longitude:g};"
                        f" allowed: {1e3 * _LOWEST_KM:g} to {1e3 * _HIGHEST_KM:g} m; check its unit",
                        file=file,
                    )
                yield round(altitude, 6)
    except RasterioError as error:
        raise InputError(f"is no raster that can be read: {' '.join(str(error).split())[:120]}", file=file) from None
