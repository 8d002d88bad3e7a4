"""Normal coordinates of ozone and what follows from them: Coriolis constants, changes of inertia, signs of moments.

A transition moment operator of a fundamental has, beside the vibrational moment, parts that depend on the rotation
(C. Camy-Peyret and J.-M. Flaud 1985, in Molecular Spectroscopy: Modern Research 3, 69): first-order perturbation by the
Coriolis coupling to the other fundamentals, and by the change of the moments of inertia along the normal coordinate,
which brings in the permanent moment. Here they are computed from the harmonic force field, the geometry, the permanent
moment and the vibrational moments.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from skyshine.schemas.arrays import Floats

# Force field of T. Tanaka and Y. Morino 1970, J. Mol. Spectrosc. 33, 538, mdyn/Angstrom, bends divided by the length or
# its square; geometry: r = 1.2717 Angstrom, 116.78 degrees (same).
STRETCH, STRETCH_STRETCH, BEND, STRETCH_BEND = 6.1636, 1.6018, 1.302, 0.4127
LENGTH, ANGLE = 1.2717, np.radians(116.78)
MASS = 15.9949146  # u
PERMANENT_MOMENT = 0.5337  # Debye, along b from the outer atoms (negative) to the inner; Mack and Muenter 1977
FREQUENCY_UNIT = 1302.79  # cm^-1 of a force constant of 1 mdyn/Angstrom and a mass of 1 u
ROTATION_UNIT = 16.857629  # u Angstrom^2 cm^-1: h / (8 pi^2 c)


@dataclass(frozen=True)
class NormalModes:
    """Harmonic wavenumbers and first derivatives, in the order v1 v2 v3.

    Attributes
    ----------
    wavenumber : (3,) array, cm^-1
    zeta : (3, 3) array
        Coriolis constants about the axis c.
    inertia : (3, 3, 3) array
        Derivatives of the inverse inertia with the dimensionless coordinate, cm^-1, by mode and axes x, y, z: their sum
        with J_alpha J_beta is the energy.
    moment_sign : (3,) array
        Signs of the vibrational moments (along b, b and a) of rigid bond moments that grow as the bond lengthens.
    """

    wavenumber: Floats
    zeta: Floats
    inertia: Floats
    moment_sign: Floats


@functools.cache
def normal_modes() -> NormalModes:
    """Normal coordinates by diagonalising the mass-weighted force constants."""
    position = _geometry()
    step = 1e-5
    shifts = step * np.eye(6)
    slope = np.array(
        [(_internal(position.ravel() + d) - _internal(position.ravel() - d)) / (2 * step) for d in shifts]
    ).T
    mixed = STRETCH_BEND * LENGTH
    forces = np.array(
        [[STRETCH, STRETCH_STRETCH, mixed], [STRETCH_STRETCH, STRETCH, mixed], [mixed, mixed, BEND * LENGTH**2]]
    )
    square, modes = np.linalg.eigh(slope.T @ forces @ slope / MASS)
    frequency = FREQUENCY_UNIT * np.sqrt(square[3:])
    # The antisymmetric stretch moves the inner atom along a only.
    antisymmetric = int(np.argmax(np.abs(modes[0, 3:])))
    bend, stretch = (k for k in np.argsort(frequency) if k != antisymmetric)
    order = [stretch, bend, antisymmetric]
    wavenumber, modes = frequency[order], modes[:, 3:][:, order]
    along_a, along_b = modes[0::2], modes[1::2]
    zeta = along_a.T @ along_b - along_b.T @ along_a
    size = np.sqrt(2 * ROTATION_UNIT / wavenumber) / np.sqrt(MASS)  # Angstrom per dimensionless coordinate
    signs, inertia = np.zeros(3), np.zeros((3, 3, 3))
    for k in range(3):
        move = step * size[k] * modes[:, k].reshape(3, 2)
        inverse = [np.linalg.inv(_inertia(position + way * move)) for way in (1, -1)]
        inertia[k] = ROTATION_UNIT * (inverse[0] - inverse[1]) / (2 * step)
        change = _bond_moment(position + move) - _bond_moment(position - move)
        signs[k] = np.sign(change[0 if k == 2 else 1])
    return NormalModes(wavenumber, zeta, inertia, signs)


def rotation_ratio(masses: tuple[float, float, float]) -> Floats:
    """Rotational constants A, B, C (3,) with other masses (inner atom, outer ones; u) over those of the main one."""
    return _constants(masses) / _constants((MASS, MASS, MASS))


def _constants(masses: tuple[float, float, float]) -> Floats:
    """Rotational constants (3,), cm^-1, from the largest."""
    position, weight = _geometry(), np.array(masses)
    z, x = (position - weight @ position / weight.sum()).T
    plane = np.array([[weight @ z**2, -weight @ (x * z)], [-weight @ (x * z), weight @ x**2]])
    small, large = np.linalg.eigvalsh(plane)
    return np.asarray(ROTATION_UNIT / np.array([small, large, small + large]))


def _geometry() -> Floats:
    """Positions (3, 2) along a and b, Angstrom, about the centre of like masses; the inner atom first."""
    position = LENGTH * np.array(
        [[0.0, 0.0], [np.sin(ANGLE / 2), -np.cos(ANGLE / 2)], [-np.sin(ANGLE / 2), -np.cos(ANGLE / 2)]]
    )
    return np.asarray(position - position.mean(axis=0))


def _internal(flat: Floats) -> Floats:
    """Bond lengths and angle of coordinates (6,)."""
    inner, *outer = flat.reshape(3, 2)
    bond, other_bond = (atom - inner for atom in outer)
    lengths = np.linalg.norm(bond), np.linalg.norm(other_bond)
    return np.array([*lengths, np.arccos(bond @ other_bond / (lengths[0] * lengths[1]))])


def _inertia(position: Floats) -> Floats:
    """Inertia tensor (x, y, z) = (b, c, a) of positions (3, 2)."""
    z, x = position.T
    return MASS * np.array(
        [[np.sum(z**2), 0.0, -np.sum(x * z)], [0.0, np.sum(x**2 + z**2), 0.0], [-np.sum(x * z), 0.0, np.sum(x**2)]]
    )


def _bond_moment(position: Floats) -> Floats:
    """Moment (a, b) of two bonds whose moments point to the inner atom and are proportional to the bond's length."""
    return np.asarray(2 * position[0] - position[1] - position[2])
