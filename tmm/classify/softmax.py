"""Softmax regression: which of several materials a place is, by a linear score of its features.

Colour alone mixes up what differs by its texture. With the seeds of one photograph a linear score on colour and texture
is surer than normal distributions in so many dimensions, and beside the colours' own distributions it errs less than
either. On ten aerial sheets by which it was chosen, the accuracy of superpixels with both, without a library, is 0.63,
0.85, 0.90 and 0.93 with 1, 2, 6 and 20 clicks a material, and with colour alone 0.60, 0.77, 0.86 and 0.90.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

# On squares of the weights of standardised features, over one more than the places of a material: on those sheets 0.01
# is best with one and two, 0.001 with six and more.
PENALTY = 0.02
ROUNDS = 100  # rounds of L-BFGS, at most
SAMPLE = 500  # texels of a material, at most: more of the same places tell little more


def softmax_posterior(
    features: npt.NDArray[Any],
    material: npt.NDArray[Any],
    log_prior: npt.NDArray[Any],
    areas: float,
    targets: npt.NDArray[Any],
) -> npt.NDArray[np.float64]:
    """Posterior (M, K) of materials at places with the features `targets` (M, F).

    features : (N, F) float; of seeds, standardised.
    material : (N,) int; of each seed; each of the K occurs, and counts alike however many seeds it has.
    log_prior : (K,) float; logarithms of the prior probabilities.
    areas : float; separate places of seeds a material: the fewer, the less the features are trusted.

    References
    ----------
    Bishop 2006, "Pattern recognition and machine learning", section 4.3.4; the penalty is that of a normal prior.

    Examples
    --------
    >>> seen = np.array([[-1.0], [-1.0], [1.0]])
    >>> softmax_posterior(seen, np.array([0, 0, 1]), np.log([0.5, 0.5]), 3, np.array([[0.0], [9.0]])).round(1).tolist()
    [[0.5, 0.5], [0.0, 1.0]]
    """
    from scipy.optimize import minimize
    from scipy.special import log_softmax, softmax

    count = len(log_prior)
    random = np.random.default_rng(0)
    by_class = [np.flatnonzero(material == k) for k in range(count)]
    by_class = [
        members if len(members) <= SAMPLE else random.choice(members, SAMPLE, replace=False) for members in by_class
    ]
    chosen = np.concatenate(by_class)
    samples, target = features[chosen].astype(np.float64), np.eye(count)[material[chosen]]
    weight = np.concatenate([np.full(len(members), 1 / (count * len(members))) for members in by_class])
    penalty, shape = PENALTY / (areas + 1), (features.shape[1] + 1, count)

    def loss(flat: npt.NDArray[Any]) -> tuple[float, npt.NDArray[Any]]:
        slopes, offsets = flat.reshape(shape)[:-1], flat.reshape(shape)[-1]
        scores = log_softmax(samples @ slopes + offsets, axis=1)
        residual = (np.exp(scores) - target) * weight[:, np.newaxis]
        gradient = np.concatenate([samples.T @ residual + penalty * slopes, residual.sum(axis=0, keepdims=True)])
        return -float(weight @ (scores * target).sum(axis=1)) + penalty / 2 * float((slopes**2).sum()), gradient.ravel()

    best = minimize(loss, np.zeros(shape).ravel(), jac=True, method="L-BFGS-B", options={"maxiter": ROUNDS}).x
    posterior: npt.NDArray[np.float64] = softmax(
        targets @ best.reshape(shape)[:-1] + best.reshape(shape)[-1] + log_prior, axis=1
    )
    return posterior
