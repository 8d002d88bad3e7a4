"""Choice of a few spectral points whose weighted sum stands for a mean over many."""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_triangular

SHORT_LIST = 12  # candidates whose non-negative fit is tried in full at each step


def select_points(
    candidates, reference, *, tolerance, max_points, total_weight, row_scale=None, sum_weight=30.0, exchanges=0, seed=0
):
    """Greedy forward selection with non-negative least squares.

    At each step the candidates are ranked by how much an unconstrained fit would gain with them (orthogonal least
    squares); the best few are tried with the non-negative fit and the best is kept. A heavily weighted row holds the sum of
    the weights. The sets are nested: the first n of the result are the choice of n points.

    Parameters
    ----------
    candidates : (P, M) array
        Value of each of M targets at each of P candidate points.
    reference : (M,) array
        Mean that weighted sums of the candidates' values, divided by `total_weight`, are to meet.
    tolerance : float
        Stop when the scaled rms error is at most this.
    max_points : int
        Largest number of points.
    total_weight : float
        Sum of the weights, e.g. the width of an interval in cm^-1.
    row_scale : (M,) array, optional
        Importance of each target; the rms is over ``row_scale * error``.
    sum_weight : float
        Weight of the row that holds the sum, in units of all other rows together.
    exchanges : int
        Passes over the chosen points afterwards in which each is exchanged for a better one, if there is one. The sets are
        then no longer nested; the last entry of the ladder is the error after the exchanges.
    seed : int
        Seed of the few candidates that are tried beside the best ranked.

    Returns
    -------
    index : (k,) int array
        Chosen candidates, in the order of their choice; points whose weight became 0 are left out.
    weight : (k,) array
        Positive, summing to `total_weight`.
    ladder : (n,) array
        Scaled rms error with 1, 2, ... points.
    """
    candidates, reference = np.asarray(candidates, float), np.asarray(reference, float)
    if candidates.ndim != 2 or candidates.shape[1] != reference.shape[0] or not reference.size:
        raise ValueError(f"candidates {candidates.shape} and reference {reference.shape} do not fit together")
    if not (np.all(np.isfinite(candidates)) and np.all(np.isfinite(reference))):
        raise ValueError("candidates and reference must be finite")
    scale = np.ones(reference.size) if row_scale is None else np.asarray(row_scale, float)
    rows = reference.size
    # Weights that sum to 1 make the error their sum over the candidates' own distances from the reference.
    apart = (candidates - reference) * (scale / np.sqrt(rows))
    y = reference * scale / np.sqrt(rows)
    products = apart @ apart.T
    along, level = apart @ y, y @ y + sum_weight**2 * max(y @ y, 1e-24)
    gram = products + along[:, None] + along + level
    moment = along + level
    rng = np.random.default_rng(seed)

    chosen, weight, ladder = [], np.zeros(0), []
    for _ in range(min(max_points, len(candidates))):
        chosen, weight, error = _with_one_more(products, gram, moment, chosen, rng)
        ladder.append(np.sqrt(error))
        if ladder[-1] <= tolerance:
            break
    for _ in range(exchanges if len(chosen) > 1 else 0):
        before = ladder[-1]
        for old in list(chosen):
            others = [j for j in chosen if j != old]
            trial, fit, error = _with_one_more(products, gram, moment, others, rng)
            if np.sqrt(error) < ladder[-1]:
                chosen, weight, ladder[-1] = trial, fit, np.sqrt(error)
        if ladder[-1] > 0.99 * before:
            break
    positive = weight > 0
    index, weight = np.array(chosen)[positive], weight[positive]
    return index, weight * (total_weight / weight.sum()), np.array(ladder)


def _with_one_more(products, gram, moment, chosen, rng):
    """The chosen candidates and the best further one, the weights of all, the squared scaled rms error."""
    trials = _short_list(gram, moment, chosen, rng)
    fits = [_fit(gram, moment, chosen + [int(j)]) for j in trials]
    errors = [_square_error(products, chosen + [int(j)], w) for j, w in zip(trials, fits, strict=True)]
    best = int(np.argmin(errors))
    return chosen + [int(trials[best])], fits[best], errors[best]


def _short_list(gram, moment, chosen, rng):
    """The candidates that promise most, and a few at random."""
    diagonal = np.diagonal(gram)
    if chosen:
        block = gram[np.ix_(chosen, chosen)]
        cross = gram[chosen]
        half = solve_triangular(_factor(block), np.column_stack([cross, moment[chosen]]), lower=True, check_finite=False)
        spread = diagonal - np.sum(half[:, :-1] ** 2, axis=0)
        gain = (moment - half[:, :-1].T @ half[:, -1]) ** 2 / np.maximum(spread, 1e-10 * diagonal)
        gain[chosen] = -1.0
    else:
        gain = moment**2 / np.maximum(diagonal, 1e-300)
    ranked = np.argsort(-gain, kind="stable")
    free = ranked[gain[ranked] >= 0]
    best, rest = free[:SHORT_LIST], free[SHORT_LIST:]
    return np.concatenate([best, rng.choice(rest, min(4, rest.size), replace=False)])


def _fit(gram, moment, chosen):
    """Non-negative least squares from the normal equations."""
    block, right = gram[np.ix_(chosen, chosen)], moment[chosen]
    factor = _factor(block)
    half = solve_triangular(factor, right, lower=True, check_finite=False)
    weight = solve_triangular(factor, half, lower=True, trans="T", check_finite=False)
    if weight.min() >= 0:
        return weight
    from scipy.optimize import nnls

    # The default limit of 3 n steps stops it on sets of nearly equal points.
    return nnls(factor.T, half, maxiter=100 * len(chosen))[0]


def _factor(block):
    """Cholesky factor, of nearly equal points too."""
    unit = np.trace(block) * np.eye(len(block))
    try:
        return np.linalg.cholesky(block + 1e-13 * unit)
    except np.linalg.LinAlgError:
        return np.linalg.cholesky(block + 1e-10 * unit)


def _square_error(products, chosen, weight):
    share = weight / weight.sum()
    return max(share @ products[np.ix_(chosen, chosen)] @ share, 0.0)
