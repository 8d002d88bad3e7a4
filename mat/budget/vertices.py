"""A runtime that knows temperatures at the vertices of faces alone (DSTO-TN-0193, section 2.1.2): the materials that
vertices have by the textures of a job.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from skyshine.schemas.arrays import Floats, Integers
from skyshine.tmm.database.reader import TmmFile, open_tmm

# Texel of which a vertex has the material.
CENTRE, NEAREST = "vertices_centre", "vertices_nearest"
SHORTEST_TEXELS = 8  # side of a face; its logarithm is even from there to that of the shorter side of the texture
FACES = 20_000  # drawn in each texture; the standard error of a share is then below 0.004


def vertex_materials(files: Sequence[Path], names: Sequence[str], generator: np.random.Generator) -> dict[str, Floats]:
    """Materials of the vertices around pixels.

    Faces of random place, length and direction are drawn in the textures, with a pixel at a random place between the
    two vertices of each.

    Parameters
    ----------
    files : sequence of Path
        Files of textures.
    names : sequence of M str
        Materials that are known; pixels and vertices of others are not counted.

    Returns
    -------
    dict of str to (M, M) array
        For `CENTRE` and `NEAREST`, of pixels of each material the shares in the light of their vertices of the
        material assigned there; a vertex weighs as radiance interpolated to the pixel does. A material of no pixel has
        vertices of its own. Empty where a file shows no known material.
    """
    total = {way: np.zeros((len(names), len(names))) for way in (CENTRE, NEAREST)}
    for file in files:
        with open_tmm(file) as texture:
            _count(texture, list(names), total, generator)
    if not total[CENTRE].any():
        return {}
    return {way: _shares(counts) for way, counts in total.items()}


def drawn_materials(shares: Floats | None, generator: np.random.Generator, shape: tuple[int, int]) -> Integers:
    """Materials (n, M) assigned to n texels of each of M materials, drawn from shares (M, M) of each."""
    true = np.broadcast_to(np.arange(shape[1]), shape)
    if shares is None:
        return np.array(true)
    drawn = generator.random(shape)[..., None]
    assigned: Integers = np.argmax(np.cumsum(shares, axis=1)[true] > drawn, axis=-1)
    return assigned


def _count(texture: TmmFile, names: list[str], total: dict[str, Floats], generator: np.random.Generator) -> None:
    """Add the faces of one texture to the weights of pairs of materials of pixel and vertex."""
    size = np.array([texture.width, texture.height], float)
    start = generator.random((FACES, 2)) * size
    longest = max(float(size.min()), SHORTEST_TEXELS)
    length = np.exp(generator.uniform(np.log(SHORTEST_TEXELS), np.log(longest), (FACES, 1)))
    angle, share = generator.uniform(0.0, 2 * np.pi, FACES), generator.random((FACES, 1))
    second = start + length * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    inside = np.all((second >= 0) & (second < size), axis=-1)
    numbers = np.full(1 + max(texture.materials), -1)
    for code, name in texture.materials.items():
        numbers[code] = names.index(name) if name in names else -1

    def material(share: Floats | float) -> Integers:
        x, y = (start + share * (second - start))[inside].T
        of_face: Integers = numbers[texture.code(x, y)]
        return of_face

    pixel, weight = material(share), share[inside, 0]
    for way, vertex, counts in (
        (CENTRE, material(0.5), np.ones(weight.size)),
        (NEAREST, material(0.0), 1 - weight),
        (NEAREST, material(1.0), weight),
    ):
        assigned = (pixel >= 0) & (vertex >= 0)
        np.add.at(total[way], (pixel[assigned], vertex[assigned]), counts[assigned])


def _shares(counts: Floats) -> Floats:
    """Rows that sum to 1; of materials without any, those of the material itself."""
    counted = counts.sum(axis=1) > 0
    filled = np.where(counted[:, None], counts, np.eye(len(counts)))
    shares: Floats = filled / filled.sum(axis=1, keepdims=True)
    return shares
