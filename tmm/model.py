"""Trained classifiers: what they are, how they are applied to a texture, and their files.

Layout of a ``.tmm-model.h5``: ``/materials`` (names), ``/colour`` (means, covariances, priors) and, for a textured one,
``/network`` (scaling of the features, weights). Applying one needs numpy alone.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, read_file, write_file
from skyshine.tmm.calibration import IDENTITY, Calibration
from skyshine.tmm.classify import (
    POSTERIOR_ONE,
    Classified,
    ColourMapper,
    GaussianModel,
    Mapper,
    pairs_of,
    strongest,
    with_margin,
    without_data,
)
from skyshine.tmm.features.colour import DistinctColours
from skyshine.tmm.features.textured import MARGIN, features, light_planes, names
from skyshine.tmm.texture import Windowed

FILETYPE = "tmm-model"
FORMAT_VERSION = "1.1.0"
TYPICAL = slice(3, 6)  # the features that typicality is measured in: L*a*b* averaged over the smallest box


@dataclass(frozen=True)
class Network:
    """A perceptron with one hidden layer of rectified linear units.

    Attributes
    ----------
    mean, scale : (F,) float32
        The features are centred and divided by these.
    inner_weight, inner_offset : (F, H), (H,) float32
    outer_weight, outer_offset : (H, K), (K,) float32
        The offsets include the logarithm of the prior.
    """

    mean: np.ndarray
    scale: np.ndarray
    inner_weight: np.ndarray
    inner_offset: np.ndarray
    outer_weight: np.ndarray
    outer_offset: np.ndarray

    def posterior(self, stack: np.ndarray) -> np.ndarray:
        """Posterior (K, N) float32 of features (F, N) float32."""
        # The scaling is put into the first layer, so that no scaled copy of the features is made.
        weight = self.inner_weight / self.scale[:, np.newaxis]
        hidden = weight.T @ stack
        hidden += (self.inner_offset - self.mean @ weight)[:, np.newaxis]
        np.maximum(hidden, 0, out=hidden)
        odds = self.outer_weight.T @ hidden + self.outer_offset[:, np.newaxis]
        odds -= odds.max(axis=0)
        np.exp(odds, out=odds)
        odds /= odds.sum(axis=0)
        return odds


@dataclass(frozen=True)
class TrainedModel:
    """A classifier for any texture.

    Attributes
    ----------
    names : tuple of str
        K materials.
    colour : GaussianModel
        Classifies by itself where there is no network; beside one, it gives the typicality.
    network : Network or None
    calibration : Calibration
    """

    names: tuple[str, ...]
    colour: GaussianModel
    network: Network | None
    calibration: Calibration = IDENTITY

    def mapper(self, texture: Windowed, colours: DistinctColours, radius: int, tabulate: bool = True) -> Mapper:
        """The classifier applied to a texture, with posteriors averaged over a box of `radius`.

        Raises
        ------
        InputError
            The model was trained with near infrared and the texture has none, or the reverse.
        """
        if self.network is not None:
            return TexturedMapper(texture, colours, self, radius)
        if self.colour.means.shape[1] != texture.channels:
            raise InputError(
                f"the model was trained on {self.colour.means.shape[1]} channels and the texture has"
                f" {texture.channels}; name 'near_infrared' for both or for neither"
            )
        return ColourMapper(texture, colours, self.colour, radius, tabulate)


class TexturedMapper:
    """A network on colour and texture, applied to a texture window by window."""

    def __init__(self, texture: Windowed, colours: DistinctColours, model: TrainedModel, radius: int):
        self.names, self._texture, self._model, self._radius = model.names, texture, model, radius
        self._colours, self._shared = colours, None
        if colours.colours is not None:
            self._shared = light_planes(colours.colours, texture.encoding)

    def window(self, top: int, bottom: int, left: int, right: int) -> Classified:
        """Classify a window; see `Mapper`."""
        margin = self._radius + MARGIN
        rows, columns, inner = with_margin(self._texture, top, bottom, left, right, margin)
        stack, valid = self.features(rows, columns)
        posterior = self._model.network.posterior(stack.reshape(len(stack), -1))
        planes = np.rint(posterior * np.float32(POSTERIOR_ONE)).astype(np.uint16).reshape(-1, *valid.shape)
        if self._radius:
            pairs = pairs_of(planes)
            material, confidence = strongest(pairs, len(pairs), valid, self._radius, inner)
        else:
            material = planes[(slice(None), *inner)].argmax(axis=0).astype(np.int16)
            confidence = planes[(slice(None), *inner)].max(axis=0) / np.float32(POSTERIOR_ONE)
        typical = self._typicality(stack[(TYPICAL, *inner)], material)
        return without_data(Classified(material, confidence, typical), valid[inner])

    def features(self, rows: slice, columns: slice) -> tuple[np.ndarray, np.ndarray]:
        """Features (F, h, w) float32 and validity (h, w) of a window, its margin included in the window."""
        pixels, valid = self._texture.window(rows, columns)
        colours, index = self._colours.of(pixels, valid)
        planes = self._shared if colours is None else light_planes(colours, self._texture.encoding)
        if planes is None:
            used, index = np.unique(index, return_inverse=True)
            planes = light_planes(self._colours.colours[used], self._texture.encoding)
        lab, linear = (np.take(part, index.ravel(), axis=1).reshape(3, *valid.shape) for part in planes)
        return features(lab, linear, valid), valid

    def _typicality(self, coordinates: np.ndarray, material: np.ndarray) -> np.ndarray:
        from scipy.special import chdtrc

        typicality = np.empty(material.shape, np.float32)
        for k in range(len(self.names)):
            mine = material == k
            distance = self._model.colour.only(k).squared_distance(coordinates[:, mine].T.astype(np.float64))
            typicality[mine] = chdtrc(len(coordinates), distance[0])
        return typicality


def write_model(model: TrainedModel, path: str | os.PathLike, job: str, data_version: str, quality: dict) -> str:
    """Write a trained classifier; returns the hash of its content.

    Parameters
    ----------
    job : str
        What it was trained on, for the attribute `job`.
    quality : dict
        Attributes of the group ``/quality``.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    count, size = model.colour.means.shape
    # The material axis repeats in each group, as netCDF readers want it.
    materials = {"material": Axis(np.arange(count, dtype=np.int32), "1", "number of the material")}
    text = Variable(("material",), np.array(model.names, dtype=object), "1", "material name")
    groups = {"materials": Group(materials, {"name": text}), "colour": _colour_group(model.colour, materials, size)}
    if model.network is not None:
        groups["network"] = _network_group(model.network, materials)
    attributes = {"slope": model.calibration.slope, "offset": model.calibration.offset}
    groups |= {"calibration": Group(attributes=attributes), "quality": Group(attributes=quality)}
    header = Header(FILETYPE, FORMAT_VERSION, data_version, job, "Classifier of textures")
    return write_file(path, Group(groups=groups), header)


def _colour_group(colour: GaussianModel, materials: dict[str, Axis], size: int) -> Group:
    axes = {
        name: Axis(np.arange(size, dtype=np.int32), "1", "coordinate: L*, a*, b*, 100 NDVI")
        for name in ("row", "column")
    }
    return Group(
        materials | axes,
        {
            "mean": Variable(("material", "row"), colour.means, "1", "mean colour"),
            "covariance": Variable(("material", "row", "column"), colour.covariances, "1", "covariance of the colour"),
            "log_prior": Variable(("material",), colour.log_prior, "1", "logarithm of the prior probability"),
        },
    )


def _network_group(network: Network, materials: dict[str, Axis]) -> Group:
    inputs = Axis(np.array(names(), dtype=object), "1", "feature")
    units = Axis(np.arange(len(network.inner_offset), dtype=np.int32), "1", "hidden unit")
    return Group(
        {"feature": inputs, "unit": units} | materials,
        {
            "mean": Variable(("feature",), network.mean, "1", "mean of the feature"),
            "scale": Variable(("feature",), network.scale, "1", "standard deviation of the feature"),
            "inner_weight": Variable(("feature", "unit"), network.inner_weight, "1", "weights of the hidden units"),
            "inner_offset": Variable(("unit",), network.inner_offset, "1", "offsets of the hidden units"),
            "outer_weight": Variable(("unit", "material"), network.outer_weight, "1", "weights of the materials"),
            "outer_offset": Variable(("material",), network.outer_offset, "1", "offsets of the materials"),
        },
    )


def read_model(path: str | os.PathLike) -> TrainedModel:
    """Read a trained classifier.

    Raises
    ------
    InputError
        The file is missing or damaged, is no classifier, or was trained on other features than this version computes.
    """
    root, _ = read_file(Path(path), FILETYPE, int(FORMAT_VERSION.split(".")[0]), verify=True)
    try:
        materials = tuple(root.groups["materials"].variables["name"].data.tolist())
        values = {name: variable.data for name, variable in root.groups["colour"].variables.items()}
        colour = GaussianModel(
            materials, *(values[name].astype(np.float64) for name in ("mean", "covariance", "log_prior"))
        )
        calibration = Calibration(*(float(root.groups["calibration"].attributes[name]) for name in ("slope", "offset")))
        network = None
        if "network" in root.groups:
            group = root.groups["network"]
            if tuple(group.axes["feature"].values.tolist()) != names():
                raise InputError(
                    "was trained on features of another version; train it again with 'tmm train'", file=path
                )
            network = Network(**{name: variable.data for name, variable in group.variables.items()})
    except (KeyError, TypeError):
        raise InputError("lacks a part of a classifier; train it again with 'tmm train'", file=path) from None
    return TrainedModel(materials, colour, network, calibration)
