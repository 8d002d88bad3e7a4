"""Ways to assign materials that need no training: a whole texture, a palette, rules, clusters; and overrides."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.classify.box import POSTERIOR_ONE
from skyshine.tmm.classify.gaussian import GaussianModel, fit
from skyshine.tmm.classify.mapper import Classified, Mapper, without_data
from skyshine.tmm.features.colour import ndvi, to_coordinates, to_lab
from skyshine.tmm.images.labels import NONE, Labels
from skyshine.tmm.images.raster import Raster
from skyshine.tmm.images.texture import Windowed
from skyshine.tmm.inputs.palette import palette_colour
from skyshine.tmm.inputs.polygons import polygon_mask, seed_polygons
from skyshine.tmm.job.model import Clusters, Palette, Rules, Seeds

CLUSTER_SAMPLE = 1 << 16  # texels that clusters are found from
CLUSTER_ROUNDS = 50  # cluster rounds of k-means: far beyond where it settles on a photograph


class WholeTexture:
    """One material for all texels with data."""

    def __init__(self, texture: Windowed, name: str) -> None:
        self._texture, self.names = texture, (name,)

    def window(self, top: int, bottom: int, left: int, right: int) -> Classified:
        """Classify a window; see `Mapper`."""
        valid = self._texture.window(slice(top, bottom), slice(left, right))[1]
        ones = np.ones(valid.shape, np.float32)
        return without_data(Classified(np.zeros(valid.shape, np.int16), ones, ones.copy()), valid)


class ExactPalette:
    """A colour model that knows its own colours and no others."""

    def __init__(self, palette: Palette, names: tuple[str, ...], dtype: np.dtype[Any], path: Path) -> None:
        self.names = names
        self._colours = {palette_colour(key, dtype, path): names.index(name) for key, name in palette.colours.items()}

    def tables(self, colours: npt.NDArray[Any], encoding: str) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Posterior and typicality, 1 for a colour of the palette; see `ColourModel`."""
        posterior = np.zeros((len(self.names), len(colours)), np.uint16)
        for colour, material in self._colours.items():
            posterior[material, (colours[:, :3] == colour).all(axis=1)] = POSTERIOR_ONE
        return posterior, np.minimum(posterior.max(axis=0, initial=0), 1).astype(np.float32)


def nearest_palette(
    palette: Palette, names: tuple[str, ...], texture: Windowed, path: Path
) -> tuple[GaussianModel, npt.NDArray[Any]]:
    """A model whose most probable colour is the nearest one in CIELAB, and the material (P,) of each of its colours."""
    colours = np.array([palette_colour(key, texture.dtype, path) for key in palette.colours], texture.dtype)
    if texture.channels > 3:
        raise InputError("has near infrared, which a palette does not name; leave 'near_infrared' out", file=path)
    covariances = np.broadcast_to(palette.spread**2 * np.eye(3), (len(colours), 3, 3))
    equal = np.full(len(colours), -np.log(len(colours)))
    model = GaussianModel(tuple(palette.colours), to_lab(colours, texture.encoding), covariances, equal)
    return model, np.array([names.index(name) for name in palette.colours.values()])


class Renamed:
    """A mapper whose classes are renamed: several may share a material, and some may have none (-1)."""

    def __init__(self, mapper: Mapper, names: tuple[str, ...], material: npt.NDArray[Any]) -> None:
        self._mapper, self.names, self._material = mapper, names, np.append(material, -1).astype(np.int16)

    def window(self, top: int, bottom: int, left: int, right: int) -> Classified:
        """Classify a window; see `Mapper`."""
        classified = self._mapper.window(top, bottom, left, right)
        return Classified(self._material[classified.material], classified.confidence, classified.typicality)


class RuleMapper:
    """Rules on colours and further layers; the first that is true gives the material."""

    def __init__(self, texture: Windowed, rules: Rules, names: tuple[str, ...], base_folder: Path, path: Path) -> None:
        """Open the layers; raises InputError where one cannot be read, has another size, or near infrared is
        missing.
        """
        self._texture, self._rules, self.names = texture, rules.rules, names
        self._layers = {name: Raster(base_folder / file) for name, file in rules.layers.items()}
        for layer in self._layers.values():
            if (layer.height, layer.width) != (texture.height, texture.width):
                raise InputError(
                    f"the layer is {layer.width} x {layer.height}; allowed: the texture's {texture.width} x "
                    f"{texture.height}",
                    file=layer.path,
                )
        required = {name for rule in rules.rules for name in rule.when} & {"ndvi", "near_infrared"}
        if required and texture.channels < 4:
            raise InputError(f"rules ask for {min(required)}; say which channel it is with 'near_infrared'", file=path)

    def window(self, top: int, bottom: int, left: int, right: int) -> Classified:
        """Classify a window; see `Mapper`."""
        colours, valid = self._texture.window(slice(top, bottom), slice(left, right))
        flat = colours[valid]
        values = {name: layer.rows(top, bottom)[:, left:right, 0][valid] for name, layer in self._layers.items()}
        matched = np.full(len(flat), -1, np.int16)
        for rule in self._rules:
            holds = matched == -1
            for name, limits in rule.when.items():
                if name not in values:
                    values |= _quantities(name, flat, self._texture.encoding)
                # A comparison with NaN, as a layer has where it knows nothing, is false.
                if limits.at_least is not None:
                    holds &= values[name] >= limits.at_least
                if limits.below is not None:
                    holds &= values[name] < limits.below
            matched[holds] = self.names.index(rule.material)
        material = np.full(valid.shape, -1, np.int16)
        material[valid] = matched
        confidence = (material >= 0).astype(np.float32)
        return Classified(material, confidence, confidence.copy())


def _quantities(name: str, colours: npt.NDArray[Any], encoding: str) -> dict[str, npt.NDArray[Any]]:
    """The quantity of `job.QUANTITIES` that is asked for, and what comes with it, of colours (N, C)."""
    if name == "ndvi":
        return {"ndvi": ndvi(colours)}
    if name in ("lightness", "a", "b", "chroma", "hue"):
        lightness, a, b = to_lab(colours[:, :3], encoding).T
        hue = np.degrees(np.arctan2(b, a)) % 360
        return {"lightness": lightness, "a": a, "b": b, "chroma": np.hypot(a, b), "hue": hue}
    scale = np.iinfo(colours.dtype).max if colours.dtype.kind == "u" else 1.0
    values = colours / np.float64(scale)
    if name != "excess_green":
        return {
            channel: values[:, i]
            for i, channel in enumerate(("red", "green", "blue", "near_infrared")[: values.shape[1]])
        }
    total = values[:, :3].sum(axis=1)
    share = np.divide(values[:, 1], total, out=np.full_like(total, 1 / 3), where=total != 0)
    return {"excess_green": 3 * share - 1}  # the chromaticities sum to 1


def find_clusters(texture: Windowed, clusters: Clusters) -> GaussianModel:
    """Clusters of a texture's colours, by k-means in CIELAB on a random sample of recorded seed, the darkest first.

    Each becomes a class of the Gaussian model, named by its number. A flat texture has fewer clusters than are asked.
    """
    from scipy.cluster.vq import kmeans2

    random = np.random.default_rng(clusters.random_seed)
    share = CLUSTER_SAMPLE / (texture.height * texture.width)
    sample = []
    for top in range(0, texture.height, 256):
        colours, valid = texture.window(slice(top, min(top + 256, texture.height)), slice(0, texture.width))
        sample.append(colours[valid & (random.random(valid.shape) < share)])
    coordinates = to_coordinates(np.concatenate(sample), texture.encoding)
    distinct = np.unique(coordinates, axis=0)
    count = min(clusters.count, len(distinct))
    nearest = kmeans2(coordinates, count, iter=CLUSTER_ROUNDS, minit="++", rng=random)[1]
    present, label = np.unique(nearest, return_inverse=True)
    order = np.argsort([coordinates[label == k, 0].mean() for k in range(len(present))])
    rank = np.argsort(order)
    return fit(coordinates, rank[label], tuple(str(k + 1) for k in range(len(present))), "seeds")


class Overrides:
    """A mapper whose answer gives way to label images and polygons; polygons to later ones, GeoJSON last."""

    def __init__(self, mapper: Mapper, texture: Windowed, seeds: Seeds, base_folder: Path, path: Path) -> None:
        """Read the overrides; raises InputError where a polygon or a label image does not fit the texture."""
        self._mapper, self._texture = mapper, texture
        polygons = seed_polygons(seeds, base_folder, texture, path)
        labelled = seeds.labels.palette.values() if seeds.labels else ()
        mapped = list(mapper.names)
        self.names = tuple(mapped + sorted({*labelled, *(name for name, *_ in polygons)} - set(mapped)))
        self._labels = None
        if seeds.labels is not None:
            self._labels = Labels(seeds.labels, base_folder, self.names).fits(texture.height, texture.width)
        self._polygons = []
        for name, rings, _ in polygons:
            outline = np.array([position[:2] for position in rings[0]])
            self._polygons.append((self.names.index(name), rings, outline.min(axis=0), outline.max(axis=0)))

    def window(self, top: int, bottom: int, left: int, right: int) -> Classified:
        """Classify a window; see `Mapper`."""
        classified = self._mapper.window(top, bottom, left, right)
        override, overridden = self._given(top, bottom, left, right)
        for array, value in (
            (classified.material, override[overridden]),
            (classified.confidence, 1),
            (classified.typicality, 1),
        ):
            array[overridden] = value
        return classified

    def _given(
        self, top: int, bottom: int, left: int, right: int
    ) -> tuple[npt.NDArray[np.int16], npt.NDArray[np.bool_]]:
        """The material (h, w) that is given in a window, and the texels with data where one is."""
        override: npt.NDArray[np.int16] = np.full((bottom - top, right - left), NONE, np.int16)
        if self._labels is not None:
            override = self._labels.rows(top, bottom)[:, left:right].copy()
        for material, rings, low, high in self._polygons:
            if low[0] <= right and high[0] >= left and low[1] <= bottom and high[1] >= top:
                mask = polygon_mask(rings, self._texture, top, left, (bottom - top, right - left))
                override[mask] = material
        overridden = override != NONE
        if overridden.any():
            overridden &= self._texture.window(slice(top, bottom), slice(left, right))[1]
        return override, overridden
