"""Energy levels and transition moments of an asymmetric rotor of symmetry C2v with two like outer atoms of spin zero.

Watson's A-reduced Hamiltonian in the representation Ir (J. K. G. Watson 1977, Vibrational Spectra and Structure 6, 1;
x = b, y = c, z = a), diagonalised in symmetric-top functions. Two vibrational states may be coupled by the Coriolis
operator i Jy. Of the functions |J, K> +- |J, -K> only those that nuclear spin statistics allow are kept: even under the
rotation about b where the vibrational state is symmetric (A1), odd where it is not (B2).
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from skyshine.schemas.arrays import Floats, Integers


@dataclass(frozen=True)
class VibrationalState:
    """Constants of one vibrational state, cm^-1.

    Attributes
    ----------
    name : str
        Quantum numbers v1 v2 v3.
    origin : float
        Energy of the vibration above that of the ground state.
    rotation : (3,) tuple
        A, B, C.
    quartic : (5,) tuple
        Delta_K, Delta_JK, Delta_J, delta_K, delta_J.
    sextic : (4,) tuple
        H_K, H_KJ, H_JK, H_J.
    odd : bool
        Whether the vibration changes sign under the rotation about b.
    """

    name: str
    origin: float
    rotation: tuple[float, float, float]
    quartic: tuple[float, float, float, float, float]
    sextic: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    odd: bool = False


@dataclass(frozen=True)
class Levels:
    """Levels (L,) of one J and one set of coupled states, and their functions.

    Attributes
    ----------
    energy : (L,) array, cm^-1
    state : (L,) int array
        Number of the vibrational state that prevails.
    ka, kc : (L,) int arrays
    vectors : (S, 2 J + 1, L) array
        Coefficients of |J, K>, K from -J to J, in each of the S vibrational states.
    """

    j: int
    energy: Floats
    state: Integers
    ka: Integers
    kc: Integers
    vectors: Floats


def levels(states: tuple[VibrationalState, ...], j: int, coriolis: float = 0.0) -> Levels:
    """Levels of one J.

    Parameters
    ----------
    states : tuple of one or two VibrationalState
    coriolis : float
        Coefficient of i Jy between the two states, cm^-1.
    """
    bases = [_basis(j, odd=state.odd) for state in states]
    blocks = [basis.T @ _hamiltonian(state, j) @ basis for state, basis in zip(states, bases, strict=True)]
    sizes = [block.shape[0] for block in blocks]
    matrix = np.zeros((sum(sizes), sum(sizes)))
    matrix[: sizes[0], : sizes[0]] = blocks[0]
    if len(states) == 2:
        matrix[sizes[0] :, sizes[0] :] = blocks[1]
        coupling = coriolis * bases[0].T @ angular_momentum(j)[1] @ bases[1]
        matrix[: sizes[0], sizes[0] :], matrix[sizes[0] :, : sizes[0]] = coupling, coupling.T
    energy, vectors = np.linalg.eigh(matrix)
    full = np.zeros((len(states), 2 * j + 1, energy.size))
    share = np.zeros((len(states), 2, energy.size))  # by state and parity of K
    offset = 0
    for number, (basis, size) in enumerate(zip(bases, sizes, strict=True)):
        full[number] = basis @ vectors[offset : offset + size]
        parity = np.abs(np.arange(-j, j + 1)) % 2
        for odd in (0, 1):
            share[number, odd] = np.sum(full[number][parity == odd] ** 2, axis=0)
        offset += size
    state, ka = _assigned(share, states, j)
    even_sum = np.array([not states[s].odd for s in state], dtype=bool)
    kc = j - ka
    kc = np.where(((ka + kc) % 2 == 0) == even_sum, kc, kc + 1)
    return Levels(j, energy, state, ka, kc.astype(int), full)


@dataclass(frozen=True)
class Moment:
    """Transition moment operator of one upper state, Debye; phi are the direction cosines of b (x) and a (z).

    Attributes
    ----------
    x, z : float
        Coefficients of phi_x and phi_z, the vibrational moments.
    jy_x, x_jy, jy_z, z_jy : float
        Coefficients of (i Jy) phi_x, phi_x (i Jy), (i Jy) phi_z and phi_z (i Jy).
    xz_x : float
        Coefficient of the commutator of Jx Jz + Jz Jx with phi_x.
    squares_x : (3,) tuple
        Coefficients of the commutators of Jx^2, Jy^2, Jz^2 with phi_x.
    """

    x: float = 0.0
    z: float = 0.0
    jy_x: float = 0.0
    x_jy: float = 0.0
    jy_z: float = 0.0
    z_jy: float = 0.0
    xz_x: float = 0.0
    squares_x: tuple[float, float, float] = (0.0, 0.0, 0.0)


def moments(lower: Levels, upper: Levels, operators: tuple[Moment, ...]) -> Floats:
    """Transition moments, Debye, whose squares are line strengths summed over the orientations in space.

    Parameters
    ----------
    lower : Levels of one vibrational state
    upper : Levels of S states
    operators : tuple of S Moment

    Returns
    -------
    (L upper, L lower) array; with phi_x or phi_z alone, squares over all upper levels of a state sum to 2 J + 1 times
    the coefficient's square.
    """
    total = np.zeros((upper.energy.size, lower.energy.size))
    for vectors, operator in zip(upper.vectors, operators, strict=True):
        total += vectors.T @ _moment_matrix(lower.j, upper.j, operator) @ lower.vectors[0]
    return total


@functools.lru_cache(maxsize=2048)
def _moment_matrix(j: int, upper: int, operator: Moment) -> Floats:
    """A moment operator between the functions of two J, (2 J' + 1, 2 J + 1)."""
    phi_x, phi_z = direction_cosines(j, upper)
    jx, i_jy, jz = angular_momentum(j)
    ux, ui_jy, uz = angular_momentum(upper)
    total = operator.x * phi_x + operator.z * phi_z
    for coefficient, matrix in (
        (operator.jy_x, ui_jy @ phi_x),
        (operator.x_jy, phi_x @ i_jy),
        (operator.jy_z, ui_jy @ phi_z),
        (operator.z_jy, phi_z @ i_jy),
        (operator.xz_x, (ux @ uz + uz @ ux) @ phi_x - phi_x @ (jx @ jz + jz @ jx)),
    ):
        total = total + coefficient * matrix
    for coefficient, before, after in zip(
        operator.squares_x, (ux @ ux, -ui_jy @ ui_jy, uz @ uz), (jx @ jx, -i_jy @ i_jy, jz @ jz), strict=True
    ):
        total = total + coefficient * (before @ phi_x - phi_x @ after)
    return np.asarray(total)


@functools.lru_cache(maxsize=512)
def direction_cosines(j: int, upper: int) -> tuple[Floats, Floats]:
    """Direction cosines of b (x) and a (z) between the functions |J, K> of two J, (2 J' + 1, 2 J + 1) each."""
    # Spherical components of a moment along x: -x / sqrt 2 for q = 1, x / sqrt 2 for q = -1.
    x = (clebsch_gordan(j, upper, -1) - clebsch_gordan(j, upper, 1)) / np.sqrt(2)
    size = np.sqrt(2 * j + 1)
    return size * x, size * clebsch_gordan(j, upper, 0)


@functools.lru_cache(maxsize=256)
def angular_momentum(j: int) -> tuple[Floats, Floats, Floats]:
    """Jx, i Jy and Jz in functions |J, K> whose Jx is real and positive (2 J + 1, 2 J + 1); i Jy is antisymmetric."""
    k = np.arange(-j, j + 0.0)
    step = 0.5 * np.sqrt(j * (j + 1.0) - k * (k + 1))
    if j == 0:
        return np.zeros((1, 1)), np.zeros((1, 1)), np.zeros((1, 1))
    above, below = np.diag(step, 1), np.diag(step, -1)
    return above + below, above - below, np.diag(np.arange(-j, j + 1.0))


def _assigned(share: Floats, states: tuple[VibrationalState, ...], j: int) -> tuple[Integers, Integers]:
    """Vibrational state and Ka of levels in the order of energy: within a state and a parity of K, Ka rises with
    energy. Levels go to the state and parity that prevails, the most certain first, until its Ka are used up.
    """
    projections = {
        (number, odd): [k for k in _allowed(j, odd=state.odd) if k % 2 == odd]
        for number, state in enumerate(states)
        for odd in (0, 1)
    }
    count = share.shape[-1]
    flat = share.reshape(2 * len(states), count)
    members: dict[tuple[int, int], list[int]] = {key: [] for key in projections}
    for level in np.argsort(-flat.max(axis=0), kind="stable") if count else ():
        for choice in np.argsort(-flat[:, level], kind="stable"):
            key = divmod(int(choice), 2)
            if len(members[key]) < len(projections[key]):
                members[key].append(int(level))
                break
    state, ka = np.zeros(count, int), np.zeros(count, int)
    for key, assigned in members.items():
        order = sorted(assigned)
        state[order], ka[order] = key[0], projections[key]
    return state, ka


def _allowed(j: int, *, odd: bool) -> list[int]:
    """K of the functions that nuclear spin statistics allow; K = 0 has no partner and is even where J is."""
    return [k for k in range(j + 1) if k > 0 or (j % 2 == 1) == odd]


def _basis(j: int, *, odd: bool) -> Floats:
    """Columns (2 J + 1, n): allowed combinations of |J, K>; the rotation about b turns |J, K> to (-1)^J |J, -K>."""
    sign = (-1) ** j * (-1 if odd else 1)
    columns = []
    for k in _allowed(j, odd=odd):
        column = np.zeros(2 * j + 1)
        column[j + k] += 1.0
        column[j - k] += sign if k else 0.0
        columns.append(column / np.linalg.norm(column))
    return np.array(columns).reshape(-1, 2 * j + 1).T


def _hamiltonian(state: VibrationalState, j: int) -> Floats:
    a, b, c = state.rotation
    d_k, d_jk, d_j, s_k, s_j = state.quartic
    h_k, h_kj, h_jk, h_j = state.sextic
    square, k = j * (j + 1.0), np.arange(-j, j + 1.0)
    diagonal = (
        state.origin
        + 0.5 * (b + c) * square
        + (a - 0.5 * (b + c)) * k**2
        - d_j * square**2
        - d_jk * square * k**2
        - d_k * k**4
        + h_j * square**3
        + h_jk * square**2 * k**2
        + h_kj * square * k**4
        + h_k * k**6
    )
    if j == 0:
        return np.diag(diagonal)
    low = k[:-2]
    ladder = 0.5 * np.sqrt((square - low * (low + 1)) * (square - (low + 1) * (low + 2)))  # <K + 2|Jx^2 - Jy^2|K>
    side = ladder * (0.5 * (b - c) - 2 * s_j * square - s_k * (low**2 + (low + 2) ** 2))
    return np.asarray(np.diag(diagonal) + np.diag(side, 2) + np.diag(side, -2))


def clebsch_gordan(j: int, upper: int, q: int) -> Floats:
    """<J K, 1 q | J' K + q> as a matrix (2 J' + 1, 2 J + 1) (Condon and Shortley, Theory of Atomic Spectra)."""
    k = np.arange(-j, j + 1.0)
    m = k + q
    inside = np.abs(m) <= upper
    m = np.where(inside, m, 0.0)
    if upper == j + 1:
        values = {
            1: np.sqrt((j + m) * (j + m + 1) / ((2 * j + 1) * (2 * j + 2))),
            0: np.sqrt((j - m + 1) * (j + m + 1) / ((2 * j + 1) * (j + 1))),
            -1: np.sqrt((j - m) * (j - m + 1) / ((2 * j + 1) * (2 * j + 2))),
        }[q]
    elif upper == j:
        if j == 0:
            values = np.zeros(k.size)
        else:
            values = {
                1: -np.sqrt((j + m) * (j - m + 1) / (2 * j * (j + 1))),
                0: m / np.sqrt(j * (j + 1.0)),
                -1: np.sqrt((j - m) * (j + m + 1) / (2 * j * (j + 1))),
            }[q]
    elif upper == j - 1:
        values = {
            1: np.sqrt((j - m) * (j - m + 1) / (2 * j * (2 * j + 1))),
            0: -np.sqrt((j - m) * (j + m) / (j * (2 * j + 1.0))),
            -1: np.sqrt((j + m + 1) * (j + m) / (2 * j * (2 * j + 1))),
        }[q]
    else:
        raise ValueError(f"no dipole transition from J = {j} to {upper}")
    matrix = np.zeros((2 * upper + 1, 2 * j + 1))
    matrix[(m[inside] + upper).astype(int), np.flatnonzero(inside)] = values[inside]
    return matrix
