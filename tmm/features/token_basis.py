"""The principal components of an image encoder's tokens, of one texture or common to the textures of a library."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

COMPONENTS = 16  # of the tokens that become features: as many as there are texture features without them


@dataclass(frozen=True)
class EncoderIdentity:
    """What tells an encoder from others, and what it was given.

    Attributes
    ----------
    sha256 : str
        Of the bytes of its file.
    side : int
        Texels of a side of the images that it is given.
    rows, columns : int
        Tokens of such an image; its patches have side / rows texels.
    output : str
        Name of the output that the tokens are.
    mean, deviation : tuple of float
        Of red, green and blue, by which colours are standardised.
    """

    sha256: str
    side: int
    rows: int
    columns: int
    output: str
    mean: tuple[float, ...]
    deviation: tuple[float, ...]


@dataclass(frozen=True)
class TokenBasis:
    """What turns tokens into features: (token - mean) . components.

    Attributes
    ----------
    mean : (C,) float32
    components : (C, P) float32
        Each has spread 1 in the sample.
    encoder : EncoderIdentity
    """

    mean: npt.NDArray[np.float32]
    components: npt.NDArray[np.float32]
    encoder: EncoderIdentity

    @property
    def count(self) -> int:
        """Number of features, P."""
        return int(self.components.shape[1])

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the features, after those of `textured.names`."""
        return tuple(f"token_{k}" for k in range(self.count))

    def features(self, tokens: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Features (P, rows, columns) of a map of tokens (C, rows, columns)."""
        flat = tokens.reshape(len(tokens), -1) - self.mean[:, np.newaxis].astype(np.float64)
        found: npt.NDArray[np.float64] = self.components.T.astype(np.float64) @ flat
        return found.reshape(-1, *tokens.shape[1:]).astype(np.float32)


def common_basis(samples: Iterable[npt.NDArray[np.float64]], encoder: EncoderIdentity) -> TokenBasis:
    """The basis of samples (N, C) of tokens, one of each texture, which are held one at a time.

    Parameters
    ----------
    samples : iterable of (N, C) float64
        One at least. Rounding depends on their order.
    """
    count, mean, scatter = 0, np.zeros(0), np.zeros((0, 0))
    for sample in samples:
        # Chan, Golub and LeVeque 1983, "Algorithms for computing the sample variance", The American Statistician
        # 37:242-247: means and scatters of parts give those of the whole without the cancellation of raw moments.
        own = sample.mean(axis=0)
        within = (sample - own).T @ (sample - own)
        if not count:
            count, mean, scatter = len(sample), own, within
            continue
        total, apart = count + len(sample), own - mean
        scatter = scatter + within + np.outer(apart, apart) * (count * len(sample) / total)
        mean, count = mean + apart * (len(sample) / total), total
    if not count:
        raise ValueError("found no tokens; allowed: those of one texture or more")
    components = _components(scatter / count)
    return TokenBasis(mean.astype(np.float32), components.astype(np.float32), encoder)


def _components(covariance: npt.NDArray[np.float64]) -> npt.NDArray[Any]:
    """The principal components (C, P) of a covariance (C, C), those with the largest spread, each of spread 1."""
    spread, vectors = np.linalg.eigh(covariance)
    kept = [k for k in np.argsort(-spread)[:COMPONENTS] if spread[k] > 1e-9 * max(spread[-1], 1e-30)]
    if not kept:  # all tokens are alike: they say nothing, and one feature of 0 stands for them
        return np.zeros((len(covariance), 1))
    basis = vectors[:, kept] / np.sqrt(spread[kept])
    # An eigenvector's sign is free: the largest entry is positive, so that the same job gives the same bytes.
    signs: npt.NDArray[np.float64] = np.sign(basis[np.abs(basis).argmax(axis=0), np.arange(len(kept))])
    return basis * signs
