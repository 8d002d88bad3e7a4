"""Seeds: the texels whose material is known, from polygons, GeoJSON and label images."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.images.labels import NONE, Labels
from skyshine.tmm.images.texture import Windowed
from skyshine.tmm.inputs.polygons import Ring, polygon_mask, seed_polygons
from skyshine.tmm.job.materials import UNKNOWN
from skyshine.tmm.job.model import Seeds, TextureJob

BLOCK = 32  # texels; of a material with many labels, blocks of this size are drawn
BLOCKS = 4096  # seeds of one material in a label image: four million texels show its colours well enough
POLYGON_TEXELS = 1 << 22  # texels of one polygon that are seeds; a larger one is thinned to a regular grid
MOST_LOST = 0.1  # share of a material's drawn seeds without data: edges of cut-outs lose some
PIECE_TEXELS = 1 << 21  # read at a time
MERGED_CLAIMS = 1 << 22  # claims of texels that wait before those of one texel are merged: 128 MiB


@dataclass(frozen=True)
class SeedTexels:
    """Texels of known material, each once.

    names : tuple of str; materials in the order of their codes.
    rows, columns : (N,) int
    material : (N,) int; index into `names`.
    region : (N,) int; number of the separate place, see `places`: its texels are alike and are held out together.
    colours : (N, C); as the texture stores them.
    conflicting : int; texels that more than one material claimed; they are omitted.
    answered : (N,) bool
        Whether the texel comes from an answer to `tmm suggest`, so from an uncertain part of the map; it says little of
        other places.
    """

    names: tuple[str, ...]
    rows: npt.NDArray[Any]
    columns: npt.NDArray[Any]
    material: npt.NDArray[Any]
    region: npt.NDArray[Any]
    colours: npt.NDArray[Any]
    conflicting: int
    answered: npt.NDArray[np.bool_]

    @property
    def separate_places(self) -> npt.NDArray[Any]:
        """Number (K,) of separate places of each material."""
        pairs = np.unique(np.stack([self.material, self.region]), axis=1)
        return np.bincount(pairs[0], minlength=len(self.names))

    def of_materials(self) -> SeedTexels:
        """The seeds without those of the class `unknown`, which one photograph has and another does not."""
        if UNKNOWN not in self.names:
            return self
        keep = self.material != self.names.index(UNKNOWN)
        texels = {key: value[keep] for key, value in vars(self).items() if key not in ("names", "conflicting")}
        return SeedTexels(tuple(name for name in self.names if name != UNKNOWN), conflicting=self.conflicting, **texels)

    def drawn(
        self, names: tuple[str, ...], chosen: npt.NDArray[np.bool_] | None = None
    ) -> tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[np.bool_]]:
        """Rows, columns, material, counted among `names`, and whether it was asked for, of all seeds or of those chosen
        (N,).
        """
        keep = np.ones(len(self.rows), bool) if chosen is None else chosen
        number = np.array([names.index(name) if name in names else -1 for name in self.names])
        return self.rows[keep], self.columns[keep], number[self.material[keep]], self.answered[keep]


def seed_files(seeds: Seeds | None) -> tuple[str, ...]:
    """Files that seeds come from, relative to the job's folder."""
    files = (*seeds.files().values(), seeds.labels.image if seeds.labels else None) if seeds else ()
    return tuple(name for name in files if name is not None)


def unlabelled(job: TextureJob, seeds: SeedTexels | None) -> tuple[str, ...]:
    """Materials of a job's label palette that have no seed in this texture."""
    if seeds is None or job.seeds is None or job.seeds.labels is None:
        return ()
    return tuple(sorted({*job.seeds.labels.palette.values()} - {UNKNOWN, *seeds.names}))


def seed_texels(
    job: TextureJob, seeds: Seeds, names: tuple[str, ...], texture: Windowed, path: Path, base_folder: Path
) -> SeedTexels:
    """Find the seed texels of a texture.

    Raises InputError: a polygon reaches beyond the image, the label image does not fit, or a material that has polygons
    has no texel left once texels without data and texels claimed by several materials are taken away. A material of the
    label palette or of map coordinates may be absent, for textures share them; but not all may.

    names : tuple of str; materials that the seeds name, in the order of their codes.
    path : Path; of the texture, for messages.
    """
    claims = Claims()
    polygons = seed_polygons(seeds, base_folder, texture, path)
    if names == (UNKNOWN,):
        raise InputError(f"'{job.name}' has seeds of {UNKNOWN} alone; name a material at one place at least", file=path)
    if not polygons and seeds.labels is None and seeds.file is None:
        raise InputError(
            f"no place of {seeds.suggested} has a material yet; fill in the names of its numbered patches", file=path
        )
    if not polygons and seeds.labels is None:
        raise InputError(f"no polygon of {seeds.file} lies on this image; compare their coordinates", file=path)
    for shape, (name, rings, answered) in enumerate(polygons):
        texels = _inside(rings, texture)
        claims.add(texels, np.full_like(texels, names.index(name)), np.full_like(texels, shape), answered)
    if seeds.labels is not None:
        labels = Labels(seeds.labels, base_folder, names).fits(texture.height, texture.width)
        for texels, material, areas in _label_claims(labels, len(names), job.held_out.random_seed):
            claims.add(texels, material, np.where(areas < 0, areas, areas + len(polygons)))
    drawn = {*seeds.polygons} if seeds.coordinates == "map" else {name for name, *_ in polygons}
    return _settle(job.name, names, drawn, texture, path, claims.merged())


class Claims:
    """Texels that materials claim.

    Claims of one texel are merged as they come in: memory grows with the texels that are claimed, not with the polygons
    that lie on top of each other.
    """

    def __init__(self) -> None:
        self._parts = [np.empty((5, 0), np.int64)]
        self._waiting, self._limit = 0, MERGED_CLAIMS

    def add(
        self,
        texel: npt.NDArray[np.int64],
        material: npt.NDArray[np.int64],
        shape: npt.NDArray[np.int64],
        answered: bool = False,
    ) -> None:
        """Claim texels (N,), by number, for a material (N,), as parts of one shape (N,); -1 where it is of none."""
        self._parts.append(np.stack([texel, material, material, shape, np.full_like(texel, answered)]))
        self._waiting += len(texel)
        if self._waiting > self._limit:
            self._merge()

    def merged(self) -> npt.NDArray[np.int64]:
        """Each claimed texel once, ascending, (5, N): its number, the lowest and highest material, the first shape,
        and whether all claims of it were asked for.
        """
        self._merge()
        return self._parts[0]

    def _merge(self) -> None:
        claims = np.concatenate(self._parts, axis=1)
        claims = claims[:, np.argsort(claims[0], kind="stable")]
        texel, lowest, highest, shape, answered = claims
        texel, index = np.unique(texel, return_index=True)
        lowest, highest = np.minimum.reduceat(lowest, index), np.maximum.reduceat(highest, index)
        self._parts = [np.stack([texel, lowest, highest, shape[index], np.minimum.reduceat(answered, index)])]
        self._waiting, self._limit = 0, max(len(texel), MERGED_CLAIMS)


def _settle(
    title: str,
    names: tuple[str, ...],
    drawn: set[str],
    texture: Windowed,
    path: Path,
    claims: npt.NDArray[np.int64],
) -> SeedTexels:
    """Keep the texels that one material alone claims and that have data; the claims are those of `Claims.merged`.

    Materials `drawn` by polygons for this texture alone must keep some; others are omitted where they have none.
    """
    texel, lowest, highest, shape, answered = claims
    agreed = lowest == highest
    rows, columns = np.divmod(texel, texture.width)
    colours, valid = gather(texture, rows, columns)
    _require_data(names, drawn, lowest[agreed], valid[agreed], path)
    keep = agreed & valid
    material = lowest[keep]
    here = np.bincount(material, minlength=len(names)) > 0
    for index in np.flatnonzero(~here):
        if names[index] in drawn or not here.any():
            raise InputError(
                f"material '{names[index]}' of '{title}' has no seed texel left (outside the data, or claimed by other "
                "materials too); draw a polygon that it has alone",
                file=path,
            )
    names, material = tuple(np.array(names, object)[here]), (np.cumsum(here) - 1)[material]
    rows, columns = rows[keep], columns[keep]
    region = places(rows, columns, material, shape[keep])
    return SeedTexels(names, rows, columns, material, region, colours[keep], int(np.sum(~agreed)), answered[keep] > 0)


def _require_data(
    names: tuple[str, ...], drawn: set[str], material: npt.NDArray[Any], valid: npt.NDArray[np.bool_], path: Path
) -> None:
    """Refuse polygons of a material of which much lies where the image has no data."""
    labelled, lost = (np.bincount(texels, minlength=len(names)) for texels in (material, material[~valid]))
    for name, count, without in zip(names, labelled, lost, strict=True):
        if name in drawn and without > MOST_LOST * count:
            raise InputError(
                f"has no data at {100 * without / count:.0f} % of the seeds of '{name}'; draw them where it has, or "
                "see what 'tmm check' says of alpha and of no data",
                file=path,
            )


def gather(
    texture: Windowed, rows: npt.NDArray[Any], columns: npt.NDArray[Any]
) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Colours (N, C) and validity (N,) of texels in the order of their rows, read from the top to the bottom."""
    colours, valid = np.empty((len(rows), texture.channels), texture.dtype), np.empty(len(rows), bool)
    step = max(PIECE_TEXELS // texture.width, 1)
    for start in range(0, texture.height, step):
        part = slice(*np.searchsorted(rows, (start, start + step)))
        if part.start < part.stop:
            band = slice(start, min(start + step, texture.height))
            pixels, has_data = texture.window(band, slice(0, texture.width))
            at = rows[part] - start, columns[part]
            colours[part], valid[part] = pixels[at], has_data[at]
    return colours, valid


def places(
    rows: npt.NDArray[Any], columns: npt.NDArray[Any], material: npt.NDArray[Any], shape: npt.NDArray[Any]
) -> npt.NDArray[Any]:
    """Number (N,) of the separate place that each texel belongs to: texels of a material that touch, at a corner too,
    or that are of one shape, are one place.

    rows, columns, material, shape : (N,) int
        In the order of the rows and, within one, of the columns; `shape` is -1 where a texel is of none.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if not len(rows):
        return np.empty(0, int)
    # Runs of texels that follow one another in a row are the nodes of a graph.
    starts = np.append(True, (np.diff(rows) != 0) | (np.diff(columns) != 1) | (np.diff(material) != 0))
    starts[1:] |= np.diff(shape) != 0
    starts_at = np.flatnonzero(starts)
    ends_at = np.append(starts_at[1:], len(rows)) - 1
    row, left, right, kind, of = (
        rows[starts_at],
        columns[starts_at],
        columns[ends_at],
        material[starts_at],
        shape[starts_at],
    )
    # In order of their left ends, and of their right ends, runs of a row above that meet a run are a range.
    width = int(columns.max()) + 3
    begins, ends = row * width + left, row * width + right
    edges = []
    for above, low, high in ((1, left - 1, right + 1), (0, left - 1, right)):
        at = (row - above) * width
        start, stop = np.searchsorted(ends, at + low), np.searchsorted(begins, at + high, side="right")
        count = np.maximum(stop - start, 0)
        run = np.repeat(np.arange(len(starts_at)), count)
        neighbour = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + np.repeat(start, count)
        edges.append(np.stack([run, neighbour])[:, kind[run] == kind[neighbour]])
    shaped = np.flatnonzero(of >= 0)
    _, representative, number = np.unique(
        np.stack([kind, of])[:, shaped], axis=1, return_index=True, return_inverse=True
    )
    edges.append(np.stack([shaped, shaped[representative][number.ravel()]]))
    both = np.concatenate(edges, axis=1)
    graph = coo_array((np.ones(both.shape[1], bool), (both[0], both[1])), (len(starts_at), len(starts_at)))
    label = connected_components(graph, directed=False)[1]
    return np.repeat(label, ends_at - starts_at + 1)


def _inside(rings: tuple[Ring, ...], texture: Windowed) -> npt.NDArray[Any]:
    """Numbers of the texels in a polygon; of a very large one, those of a regular grid."""
    outline = np.array([position[:2] for position in rings[0]])
    # A vertex on the far edge of the image is in its last texel.
    low, high = (
        np.clip(edge, 0, (texture.width - 1, texture.height - 1)).astype(int)
        for edge in (outline.min(0), outline.max(0))
    )
    width, height = high - low + 1
    step = int(np.ceil(np.sqrt(width * height / POLYGON_TEXELS)))
    rows, columns = np.nonzero(polygon_mask(rings, texture, low[1], low[0], (height, width), step))
    texels: npt.NDArray[np.int64] = (rows * step + low[1]) * texture.width + columns * step + low[0]
    return texels


def _label_claims(labels: Labels, count: int, random_seed: int) -> Iterator[npt.NDArray[Any]]:
    """Claims of a label image: texels, material and area, (3, N) each.

    Of each material all texels, or those of BLOCKS blocks drawn at random. These do not touch where the labels do: they
    are of the area of blocks that touch. The area is -1 where all texels are claimed.
    """
    from scipy.ndimage import label

    random, across = np.random.default_rng(random_seed), -(-labels.width // BLOCK)
    bands = [slice(top, min(top + BLOCK, labels.height)) for top in range(0, labels.height, BLOCK)]
    present = np.zeros((count, len(bands), across), bool)
    for number, band in enumerate(bands):
        labelled = labels.rows(band.start, band.stop)
        for k in range(count):
            texels = np.add.reduceat((labelled == k).any(axis=0), np.arange(0, labels.width, BLOCK))
            present[k, number] = texels > 0
    area, numbered = np.full(present.shape, -1), 0
    for mine, numbers in zip(present, area, strict=True):
        blocks = np.flatnonzero(mine)
        if len(blocks) > BLOCKS:
            numbers[...], areas = label(mine, np.ones((3, 3), int))
            numbers += numbered
            numbered += areas + 1
            mine.flat[np.setdiff1d(blocks, random.choice(blocks, BLOCKS, replace=False))] = False
    for number, band in enumerate(bands):
        if present[:, number].any():
            rows, columns = np.nonzero((labelled := labels.rows(band.start, band.stop)) != NONE)
            material = labelled[rows, columns].astype(np.int64)
            keep = present[material, number, columns // BLOCK]
            rows, columns, material = rows[keep], columns[keep], material[keep]
            texels = (rows + band.start) * labels.width + columns
            yield np.stack([texels, material, area[material, number, columns // BLOCK]])
