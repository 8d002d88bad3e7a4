"""Interpolation of path radiance over all directions of the source from a few of them.

Path radiance as a matrix, lines of sight by directions of the source (elevation and scattering angle), has a low rank:
a few of its columns span the others. The tables contain those columns on the nodes of the lines, and the factors of all
others by direction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.atmosphere.transfer.line_of_sight import lines_of_sight
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.channels.parts import fitted_parts, pivots
from skyshine.mat.quantities.channels.path_fields import BandLight, LightOver
from skyshine.mat.quantities.joined_paths import JoinedPaths, in_groups
from skyshine.mat.quantities.line_sources import LineSources
from skyshine.mat.threads import parallel_map
from skyshine.schemas.arrays import Floats, Integers

# For diffuse light on surfaces, which changes more slowly.
SKY_ELEVATIONS = (-18, -12, -8, -5, -2, 0, 3, 7, 14, 25, 40, 60, 90)
MOST_PARTS = 40  # directions of the source: a limit of the file's size
_TRIED = 1500
_WORST = 25.0  # root mean square errors: what the aureole of a low Sun may miss, in which few directions lie


@dataclass(frozen=True, eq=False)
class SourceParts:
    """K directions of the source, and the factors of all others.

    Attributes
    ----------
    elevation, angle : (SE,), (SA,) arrays
        Nodes of source elevation and scattering angle, degree.
    chosen_elevation, chosen_angle : (K,) arrays
        degree.
    factor : (K, SE, SA) array
    """

    elevation: Floats
    angle: Floats
    chosen_elevation: Floats
    chosen_angle: Floats
    factor: Floats


def sampled_radiance(
    atmosphere: BandAtmosphere,
    light: BandLight,
    elevation: Floats,
    angle: Floats,
    lines: tuple[Floats, Floats, Floats],
) -> tuple[Integers, Floats]:
    """Scattered path radiance of sample lines under directions of the source.

    Parameters
    ----------
    elevation, angle : (S,) arrays
        Source elevation and scattering angle, degree.
    lines : altitude, elevation (n,), ranges (n, R)
        Lines of the sample, km and degree.

    Returns
    -------
    numbers : (n R,) int array
        Of the line of each row.
    radiance : (n R, S) array
        W m^-2 sr^-1.
    """
    altitude, line_elevation, ranges = lines
    atmosphere.air.prepare()
    paths = list(lines_of_sight(atmosphere.air, ranges * 1e3, altitude * 1e3, np.radians(line_elevation)))
    up, away = np.radians(elevation), np.radians(angle)

    def seen(group: slice) -> Floats:
        reference = LightOver.of(atmosphere, JoinedPaths.of(paths[group]))
        sources = [LineSources.at_angle(path.elevation, up, away) for path in paths[group]]
        divisor = reference.absorbed @ light.source
        return (reference.scattered(sources, light) * divisor[..., None]).reshape(-1, up.size)

    groups = in_groups(len(paths), up.size)
    return np.repeat(np.arange(len(paths)), ranges.shape[1]), np.concatenate(parallel_map(seen, groups))


def all_directions(elevation: Floats, angle: Floats) -> tuple[Floats, Floats]:
    """Source elevation and scattering angle (SE SA,) of all pairs of nodes (SE,) and (SA,)."""
    return np.repeat(elevation, angle.size), np.tile(angle, elevation.size)


def source_parts(
    elevation: Floats, angle: Floats, samples: Sequence[tuple[Integers, Floats]], allowed: float
) -> SourceParts:
    """The fewest directions that give the path radiance of sample lines under all.

    Parameters
    ----------
    elevation, angle : (SE,), (SA,) arrays
        Nodes of source elevation and of scattering angle, degree.
    samples : sequence of `sampled_radiance`
        Samples under all directions of the nodes, of one air or of several; none without light. Lines with odd numbers
        are for testing only.
    allowed : float
        Root mean square error of path radiance on the lines that only test [W m^-2 sr^-1]; the largest is within
        `_WORST` times.
    """
    if not samples:
        return SourceParts(elevation, angle, np.zeros(0), np.zeros(0), np.zeros((0, elevation.size, angle.size)))
    numbers, radiance = (np.concatenate(part) for part in zip(*samples, strict=True))
    fit = numbers % 2 == 0
    order = pivots(radiance[fit])
    limit = min(MOST_PARTS, radiance.shape[1], int(np.count_nonzero(fit)))
    for count in range(1, limit + 1):
        chosen = fitted_parts(radiance[fit], np.sort(order[:count]))
        error = radiance[~fit][:, chosen.index] @ chosen.factor.T - radiance[~fit]
        if np.sqrt(np.mean(error**2)) <= allowed and np.abs(error).max() <= _WORST * allowed:
            break
    chosen = fitted_parts(radiance, chosen.index)
    row, column = np.divmod(chosen.index, angle.size)
    factor = chosen.factor.T.reshape(chosen.count, elevation.size, angle.size)
    return SourceParts(elevation, angle, elevation[row], angle[column], factor)


def leading_parts(factor: Floats, fields: Floats, allowed: float) -> tuple[Floats, Floats]:
    """The fewest fields, and their factors by direction, that give the sum of all within an error.

    They are the leading singular vectors of path radiance, nodes by directions (Eckart and Young 1936, Psychometrika 1:
    211-218), so that the later ones are faint. The largest factor of each is 1.

    Parameters
    ----------
    factor : (K, SE, SA) array
    fields : (K, X, Z, U) array
        Fields of the chosen directions on the nodes [W m^-2 sr^-1].
    allowed : float
        Root mean square error over all nodes and directions [W m^-2 sr^-1]; the largest is within `_WORST` times on
        `_TRIED` nodes.

    Returns
    -------
    factor : (k, SE, SA) array
    fields : (k, X, Z, U) array
        Values of both signs.
    """
    count = len(factor)
    if count < 2:
        return factor, fields
    of_direction, inner_direction = np.linalg.qr(factor.reshape(count, -1).T)
    of_node, inner_node = np.linalg.qr(fields.reshape(count, -1).T)
    left, size, right = np.linalg.svd(inner_direction @ inner_node.T)
    directions, nodes = of_direction @ left, of_node @ (right.T * size)
    rest = np.sqrt(np.cumsum(size[::-1] ** 2)[::-1] / (len(directions) * len(nodes)))
    tried = nodes[:: -(-len(nodes) // _TRIED)]
    kept = max(1, int(np.count_nonzero(rest > allowed)))
    while kept < count and np.abs(directions[:, kept:] @ tried[:, kept:].T).max() > _WORST * allowed:
        kept += 1
    directions, nodes = directions[:, :kept], nodes[:, :kept]
    largest = directions[np.abs(directions).argmax(axis=0), np.arange(kept)]
    scale = np.where(largest == 0, 1.0, largest)
    return (directions / scale).T.reshape(kept, *factor.shape[1:]), (nodes * scale).T.reshape(kept, *fields.shape[1:])


def telling_lines(sample: tuple[Integers, Floats], count: int) -> Integers:
    """Numbers of so many lines of a sample, whose path radiance under all directions gives that of the others."""
    numbers, radiance = sample
    of_rows = numbers[pivots(radiance.T)]
    _, row_start = np.unique(of_rows, return_index=True)
    lines: Integers = np.sort(of_rows[np.sort(row_start)[:count]])
    return lines


def at_other_nodes(parts: SourceParts, elevation: Floats, angle: Floats, radiance: Floats) -> SourceParts:
    """The chosen directions with factors at other nodes, of path radiance (m, K + SE SA) under the chosen directions
    and under all of the nodes (SE,) and (SA,).
    """
    count = parts.chosen_angle.size
    factor = fitted_parts(radiance, np.arange(count)).factor[count:]
    return replace(parts, elevation=elevation, angle=angle, factor=factor.T.reshape(count, elevation.size, angle.size))
