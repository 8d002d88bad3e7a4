"""Choice of a few spectral points whose weighted sum approximates a mean over many."""

from __future__ import annotations

import numpy as np
import scipy

from skyshine.schemas.arrays import Floats, Integers

SHORT_LIST = 12  # candidates whose non-negative fit is tried in full at each step, unless a caller wants fewer


def select_points(
    candidates: Floats,
    reference: Floats,
    *,
    tolerance: float,
    max_points: int,
    total_weight: float,
    row_scale: Floats | None = None,
    sum_weight: float = 30.0,
    exchanges: int = 0,
    more_exchanges: int = 0,
    short_list: int = SHORT_LIST,
    seed: int = 0,
) -> tuple[Integers, Floats, Floats]:
    """Greedy forward selection with non-negative least squares.

    At each step the candidates are ranked by how much an unconstrained fit would gain with them (orthogonal least
    squares); the best few are tried with the non-negative fit and the best is kept. A heavily weighted row contains the
    sum of the weights. The sets are nested: the first n of the result are the choice of n points.

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
        Weight of the row that contains the sum, in units of all other rows together.
    exchanges : int
        Passes over the chosen points afterwards in which each is exchanged for a better one, if there is one. The sets
        are then no longer nested; the last entry of the ladder is the error after the exchanges.
    more_exchanges : int
        Further such passes, as long as the error is above the tolerance.
    short_list : int
        Best ranked candidates whose non-negative fit is tried at each step.
    seed : int
        Seed of the few candidates that are tried beside the best ranked.

    Returns
    -------
    index : (k,) int array
        Chosen candidates, in the order of their choice; points whose weight became 0 are omitted.
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
    # For weights that sum to 1 the error is the weighted sum of the candidates' distances from the reference.
    distance = (candidates - reference) * (scale / np.sqrt(rows))
    y = reference * scale / np.sqrt(rows)
    products = distance @ distance.T
    along, level = distance @ y, y @ y + sum_weight**2 * max(y @ y, 1e-24)
    gram = products + along[:, None] + along + level
    moment = along + level
    rng = np.random.default_rng(seed)

    chosen: list[int] = []
    weight: Floats = np.zeros(0)
    ladder: list[float] = []
    for _ in range(min(max_points, len(candidates))):
        chosen, weight, error = _with_one_more(products, gram, moment, chosen, short_list, rng)
        ladder.append(float(np.sqrt(error)))
        if ladder[-1] <= tolerance:
            break
    for number in range(exchanges + more_exchanges if len(chosen) > 1 else 0):
        if number >= exchanges and ladder[-1] <= tolerance:
            break
        before = ladder[-1]
        for old in list(chosen):
            others = [j for j in chosen if j != old]
            trial, fit, error = _with_one_more(products, gram, moment, others, short_list, rng)
            if np.sqrt(error) < ladder[-1]:
                chosen, weight, ladder[-1] = trial, fit, float(np.sqrt(error))
        if ladder[-1] > 0.99 * before:
            break
    positive = weight > 0
    index, weight = np.array(chosen)[positive], weight[positive]
    return index, weight * (total_weight / weight.sum()), np.array(ladder)


def _with_one_more(
    products: Floats, gram: Floats, moment: Floats, chosen: list[int], short_list: int, rng: np.random.Generator
) -> tuple[list[int], Floats, float]:
    """The chosen candidates with the best further one, the weights of all, the squared scaled rms error.

    Parameters
    ----------
    products, gram : (P, P) arrays
        Scalar products of the candidates' distances from the reference, and of the rows of the fit.
    moment : (P,) array
        Scalar products of the rows of the fit with the reference.
    """
    # Cholesky factor of the chosen, and the rows below it that each further candidate and the reference would have.
    factor = _factor(gram[np.ix_(chosen, chosen)])
    rows = np.column_stack([gram[chosen], moment[chosen]])
    if chosen:
        rows = scipy.linalg.solve_triangular(factor, rows, lower=True, check_finite=False)
    rows, goal = rows[:, :-1], rows[:, -1]
    diagonal = np.diagonal(gram)
    pivot = np.maximum(diagonal - np.sum(rows**2, axis=0), 1e-10 * diagonal + 1e-300)
    missing = moment - goal @ rows
    gain = missing**2 / pivot
    gain[chosen] = -1.0
    trials = _short_list(gain, short_list, rng)
    root = np.sqrt(pivot[trials])
    fits = _fits(factor, rows[:, trials], root, goal, missing[trials] / root)
    errors = [_square_error(products, [*chosen, int(j)], w) for j, w in zip(trials, fits, strict=True)]
    best = int(np.argmin(errors))
    return [*chosen, int(trials[best])], fits[best], errors[best]


def _short_list(gain: Floats, count: int, rng: np.random.Generator) -> Integers:
    """The candidates with the `count` largest gains (P,), and a few at random; none with a negative gain."""
    ranked = np.argsort(-gain, kind="stable")
    favourable = ranked[gain[ranked] >= 0]
    best, others = favourable[:count], favourable[count:]
    return np.concatenate([best, rng.choice(others, min(4, others.size), replace=False)])


def _fits(factor: Floats, rows: Floats, root: Floats, goal: Floats, constants: Floats) -> Floats:
    """Non-negative weights (T, k+1) of k chosen candidates and each of T further ones.

    factor (k, k), lower; rows (k, T), root (T,): the row that each further candidate adds below it; goal (k,),
    last (T,): the right-hand side in these terms.
    """
    from scipy.optimize import nnls

    weights = np.empty((root.size, goal.size + 1))
    weights[:, -1] = constants / root
    if goal.size:
        others = goal[:, None] - rows * weights[:, -1]
        weights[:, :-1] = scipy.linalg.solve_triangular(factor, others, lower=True, trans="T", check_finite=False).T
    triangle = np.zeros((goal.size + 1, goal.size + 1))
    triangle[:-1, :-1] = factor.T
    for trial in np.flatnonzero(weights.min(axis=1) < 0):
        triangle[:-1, -1], triangle[-1, -1] = rows[:, trial], root[trial]
        # The default limit of 3 n steps stops it on sets of nearly equal points.
        weights[trial] = nnls(triangle, np.append(goal, constants[trial]), maxiter=100 * goal.size + 100)[0]
    return weights


def _factor(block: Floats) -> Floats:
    """Cholesky factor (k, k) of a block of the Gram matrix; small diagonal terms keep it positive definite for nearly
    equal points.
    """
    unit = np.trace(block) * np.eye(len(block))
    try:
        return np.linalg.cholesky(block + 1e-13 * unit)
    except np.linalg.LinAlgError:
        return np.linalg.cholesky(block + 1e-10 * unit)


def _square_error(products: Floats, chosen: list[int], weight: Floats) -> float:
    """Squared scaled rms error of weights (k,) on the chosen candidates."""
    share = weight / weight.sum()
    return max(float(share @ products[np.ix_(chosen, chosen)] @ share), 0.0)
