"""Trained classifiers: what they are, and how they are applied to a texture. Applying one needs numpy alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.tmm.classify.box import POSTERIOR_ONE, averaged, strongest
from skyshine.tmm.classify.calibration import IDENTITY, Calibration
from skyshine.tmm.classify.gaussian import GaussianModel
from skyshine.tmm.classify.mapper import Classified, with_margin, without_data
from skyshine.tmm.features.colour import DistinctColours
from skyshine.tmm.features.textured import MARGIN, LightPlanes, features
from skyshine.tmm.images.texture import Windowed

TYPICAL = slice(3, 6)  # the features that typicality is measured in: L*a*b* averaged over the smallest box


@dataclass(frozen=True)
class Network:
    """A perceptron with one hidden layer of rectified linear units.

    mean, scale : (F,) float32; the features are centred and divided by these.
    inner_weight, inner_offset : (F, H), (H,) float32
    outer_weight, outer_offset : (H, K), (K,) float32; the offsets include the logarithm of the prior.
    """

    mean: npt.NDArray[np.float32]
    scale: npt.NDArray[np.float32]
    inner_weight: npt.NDArray[np.float32]
    inner_offset: npt.NDArray[np.float32]
    outer_weight: npt.NDArray[np.float32]
    outer_offset: npt.NDArray[np.float32]

    def posterior(self, stack: npt.NDArray[np.float32]) -> npt.NDArray[Any]:
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
    """A classifier for any texture, on colour and texture.

    names : tuple of str; K materials.
    colour : GaussianModel; distribution of the colours of each material, which gives the typicality.
    network : Network
    calibration : Calibration
    """

    names: tuple[str, ...]
    colour: GaussianModel
    network: Network
    calibration: Calibration = IDENTITY

    def only(self, classes: Sequence[int]) -> TrainedModel:
        """The classifier among some of its materials alone: the others have no posterior."""
        part, network = list(classes), self.network
        network = replace(network, outer_weight=network.outer_weight[:, part], outer_offset=network.outer_offset[part])
        colour = self.colour.only(classes)
        return TrainedModel(colour.names, colour, network, self.calibration)


class ModelMapper:
    """A trained classifier applied to a texture window by window, with posteriors averaged over a box."""

    def __init__(self, texture: Windowed, colours: DistinctColours, model: TrainedModel, radius: int) -> None:
        self.names, self._texture, self._radius = model.names, texture, radius
        self._model, self._light = model, LightPlanes(texture, colours)

    def window(self, top: int, bottom: int, left: int, right: int) -> Classified:
        """Classify a window; see `Mapper`."""
        from scipy.special import chdtrc

        margin = self._radius + MARGIN
        rows, columns, inner = with_margin(self._texture, top, bottom, left, right, margin)
        lab, linear, valid = self._light.window(rows, columns)
        stack = features(lab, linear, valid)
        posterior = self._model.network.posterior(stack.reshape(len(stack), -1))
        planes = np.rint(posterior * np.float32(POSTERIOR_ONE)).astype(np.uint16).reshape(-1, *valid.shape)
        if self._radius:
            material, confidence = strongest(planes, valid, self._radius, inner)
        else:
            material = planes[(slice(None), *inner)].argmax(axis=0).astype(np.int16)
            confidence = planes[(slice(None), *inner)].max(axis=0) / np.float32(POSTERIOR_ONE)
        distance = self._model.colour.squared_distance(stack[TYPICAL].reshape(3, -1).T.astype(np.float64)).min(axis=0)
        typicality = chdtrc(3, distance).astype(np.float32).reshape(valid.shape)
        typical = averaged(typicality, valid, self._radius, inner)
        return without_data(Classified(material, confidence, typical), valid[inner])
