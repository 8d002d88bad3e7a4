"""Trained classifiers: what they are, and how they are applied to a texture. Applying one needs numpy alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.classify.box import POSTERIOR_ONE, averaged, means, pairs_of, strongest
from skyshine.tmm.classify.calibration import IDENTITY, Calibration
from skyshine.tmm.classify.gaussian import GaussianModel
from skyshine.tmm.classify.mapper import Classified, ColourMapper, Mapper, with_margin, without_data
from skyshine.tmm.classify.typicality import Typicality
from skyshine.tmm.features.colour import DistinctColours
from skyshine.tmm.features.textured import MARGIN, LightPlanes, features
from skyshine.tmm.features.token_basis import TokenBasis
from skyshine.tmm.features.tokens import TokenFeatures
from skyshine.tmm.images.texture import Windowed

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
    """A classifier for any texture.

    Attributes
    ----------
    names : tuple of str
        K materials.
    colour : GaussianModel
        Classifies by itself where there is no network; beside one, it gives the typicality.
    network : Network or None
    calibration : Calibration
    tokens : TokenBasis or None
        Of an image encoder whose features the network takes after its own.
    """

    names: tuple[str, ...]
    colour: GaussianModel
    network: Network | None
    calibration: Calibration = IDENTITY
    tokens: TokenBasis | None = None

    def only(self, kept: Sequence[int]) -> TrainedModel:
        """The classifier among some of its materials alone: the others have no posterior."""
        network = self.network
        if network is not None:
            part = list(kept)
            network = replace(
                network, outer_weight=network.outer_weight[:, part], outer_offset=network.outer_offset[part]
            )
        colour = self.colour.only(kept)
        return TrainedModel(colour.names, colour, network, self.calibration, self.tokens)

    def posterior(self, stack: npt.NDArray[np.float32], coordinates: npt.NDArray[np.float64]) -> npt.NDArray[Any]:
        """Posterior (K, N) float32 of texels with the features `stack` (F, N) and the colours `coordinates` (N, D)."""
        if self.network is not None:
            return self.network.posterior(stack)
        posterior: npt.NDArray[np.float32] = np.exp(
            self.colour.log_posterior(self.colour.squared_distance(coordinates))
        ).astype(np.float32)
        return posterior

    def mapper(
        self,
        texture: Windowed,
        colours: DistinctColours,
        radius: int,
        tabulate: bool = True,
        tokens: TokenFeatures | None = None,
        typicality: Typicality | None = None,
    ) -> Mapper:
        """The classifier applied to a texture, with posteriors averaged over a box of `radius`; `tokens` are the
        features of an image encoder that it was trained with, and `typicality` is that of seeds, where there are any.

        Raises
        ------
        InputError
            The model was trained with near infrared and the texture has none, or the reverse.
        """
        self.require_channels(texture)
        if self.network is not None:
            return TexturedMapper(texture, colours, self.names, self.colour, self.network, radius, tokens, typicality)
        return ColourMapper(texture, colours, self.colour, radius, tabulate, typicality)

    def require_channels(self, texture: Windowed) -> None:
        """Refuse a texture with near infrared where the model knows none, or the reverse.

        Raises
        ------
        InputError
        """
        if self.network is None and self.colour.means.shape[1] != texture.channels:
            raise InputError(
                f"the model was trained on {self.colour.means.shape[1]} channels and the texture has"
                f" {texture.channels}; name 'near_infrared' for both or for neither"
            )


def require_no_encoder(model: TrainedModel, why: str) -> None:
    """Refuse a model that takes features of an image encoder, where these are not to be had.

    Raises
    ------
    InputError
    """
    if model.tokens is not None:
        raise InputError(
            f"the model takes features of an image encoder; allowed {why}: a model without; name another, or let the"
            " model stand alone with its encoder in classifier.features"
        )


class TexturedMapper:
    """A network on colour and texture, applied to a texture window by window."""

    def __init__(
        self,
        texture: Windowed,
        colours: DistinctColours,
        names: tuple[str, ...],
        colour: GaussianModel,
        network: Network,
        radius: int,
        tokens: TokenFeatures | None = None,
        typicality: Typicality | None = None,
    ) -> None:
        self._tokens, self._typicality = tokens, typicality
        self.names, self._texture, self._radius = names, texture, radius
        self._colour, self._network, self._light = colour, network, LightPlanes(texture, colours)

    def window(self, top: int, bottom: int, left: int, right: int) -> Classified:
        """Classify a window; see `Mapper`."""
        from scipy.special import chdtrc

        stack, planes, valid, inner = self._planes(top, bottom, left, right)
        if self._radius:
            pairs = pairs_of(planes)
            material, confidence = strongest(pairs, len(pairs), valid, self._radius, inner)
        else:
            material = planes[(slice(None), *inner)].argmax(axis=0).astype(np.int16)
            confidence = planes[(slice(None), *inner)].max(axis=0) / np.float32(POSTERIOR_ONE)
        if self._typicality is None:
            distance = self._colour.squared_distance(stack[TYPICAL].reshape(3, -1).T.astype(np.float64)).min(axis=0)
            typicality = chdtrc(3, distance).astype(np.float32).reshape(valid.shape)
            typical = averaged(typicality, valid, self._radius, inner)
        else:
            typical = self._typicality.window(top, bottom, left, right)
        return without_data(Classified(material, confidence, typical), valid[inner])

    def posterior(self, top: int, bottom: int, left: int, right: int) -> npt.NDArray[np.float32]:
        """Posterior of each material; see `Mapper`."""
        _, planes, valid, inner = self._planes(top, bottom, left, right)
        if self._radius:
            return means(pairs_of(planes), len(planes), valid, self._radius, inner)
        own: npt.NDArray[np.float32] = planes[(slice(None), *inner)].astype(np.float32) / np.float32(POSTERIOR_ONE)
        return own

    def _planes(self, top: int, bottom: int, left: int, right: int) -> tuple[Any, ...]:
        """Features and posteriors, in units of 1 / POSTERIOR_ONE, of a window with its margin, validity, and where the
        window lies in it.
        """
        margin = self._radius + MARGIN
        rows, columns, inner = with_margin(self._texture, top, bottom, left, right, margin)
        lab, linear, valid = self._light.window(rows, columns)
        stack = features(lab, linear, valid)
        if self._tokens is not None:
            stack = np.concatenate([stack, self._tokens.window(rows, columns)])
        posterior = self._network.posterior(stack.reshape(len(stack), -1))
        planes = np.rint(posterior * np.float32(POSTERIOR_ONE)).astype(np.uint16).reshape(-1, *valid.shape)
        return stack, planes, valid, inner
