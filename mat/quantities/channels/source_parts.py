"""Few directions of the source whose path radiance gives that under all others.

Path radiance as a matrix, lines of sight by directions of the source (elevation and scattering angle), has a low rank:
a few of its columns span the others. The tables hold those columns on the nodes of the lines, and the factors of all
others by direction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

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
MOST_PARTS = 40


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
    """Scattered path radiance of sample lines under all directions of the source.

    Parameters
    ----------
    atmosphere : BandAtmosphere
    light : BandLight
    elevation, angle : (SE,), (SA,) arrays
        Nodes of source elevation and of scattering angle, degree.
    lines : altitude, elevation (n,), ranges (n, R)
        Of the sample, km and degree.

    Returns
    -------
    numbers : (n R,) int array
        Of the line of each row.
    radiance : (n R, SE SA) array
        W m^-2 sr^-1.
    """
    altitude, line_elevation, ranges = lines
    atmosphere.air.prepare()
    paths = list(lines_of_sight(atmosphere.air, ranges * 1e3, altitude * 1e3, np.radians(line_elevation)))
    up, away = np.radians(elevation), np.radians(angle)

    def seen(some: slice) -> Floats:
        reference = LightOver.of(atmosphere, JoinedPaths.of(paths[some]))
        sources = [LineSources.of_axes(path.elevation, up, away, True) for path in paths[some]]
        divisor = reference.absorbed @ light.source
        return (reference.scattered(sources, light) * divisor[..., None]).reshape(-1, up.size * away.size)

    groups = in_groups(len(paths), elevation.size * angle.size)
    return np.repeat(np.arange(len(paths)), ranges.shape[1]), np.concatenate(parallel_map(seen, groups))


def source_parts(
    elevation: Floats, angle: Floats, samples: Sequence[tuple[Integers, Floats]], allowed: float
) -> SourceParts:
    """The fewest directions that give the path radiance of sample lines under all.

    Parameters
    ----------
    elevation, angle : (SE,), (SA,) arrays
        Nodes of source elevation and of scattering angle, degree.
    samples : sequence of `sampled_radiance`
        Of one air or of several; none without light. Lines with odd numbers only test.
    allowed : float
        Root mean square error of path radiance on the lines that only test [W m^-2 sr^-1].

    Returns
    -------
    SourceParts
    """
    if not samples:
        return SourceParts(elevation, angle, np.zeros(0), np.zeros(0), np.zeros((0, elevation.size, angle.size)))
    numbers, radiance = (np.concatenate(part) for part in zip(*samples, strict=True))
    fit = numbers % 2 == 0
    order = pivots(radiance[fit])
    most = min(MOST_PARTS, radiance.shape[1], int(np.count_nonzero(fit)))
    for count in range(1, most + 1):
        chosen = fitted_parts(radiance[fit], np.sort(order[:count]))
        error = radiance[~fit][:, chosen.index] @ chosen.factor.T - radiance[~fit]
        if np.sqrt(np.mean(error**2)) <= allowed:
            break
    row, column = np.divmod(chosen.index, angle.size)
    factor = chosen.factor.T.reshape(chosen.count, elevation.size, angle.size)
    return SourceParts(elevation, angle, elevation[row], angle[column], factor)
