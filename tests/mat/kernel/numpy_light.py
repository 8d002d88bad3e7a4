"""Light along lines of sight in numpy, by which the kernel is judged: in double precision, segment by segment, with no
table or term in another form than the docstrings have it.

Tables of a state are the package's; what they are made of is tested with them.
"""

from dataclasses import dataclass
from math import factorial

import numpy as np

from skyshine.mat.atmosphere.transfer.directions import direction_cubics
from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS
from skyshine.mat.atmosphere.transfer.layer_parts import through_three
from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES, rayleigh_phase
from skyshine.mat.atmosphere.transfer.segments import Depths, mean_attenuation
from skyshine.mat.atmosphere.transfer.source_nodes import elevation_weights

HIDDEN = 1e4  # optical depth to a source behind the Earth
SHELL = 8e3  # m: scale height of the shell whose air mass divides the depths of the source table
TURN = 100.0  # directions below the horizon follow those above: from here on less what they are even in
LEVEL = 1e-9  # share of a layer's height below which a segment is level
NONE, WHOLE = 5e-3, 1e-2  # depths of peak scattering: no change below the first, the whole change above the second


# ---- Places and means


def direction_weights(upward_cosine, angles):
    """Weights of tabulated directions at `angles` (X,) rad from the vertical for others, of cosines (K,): of a cubic
    through the four nearest of the hemisphere, or of a straight line through two; held beyond the last. The first (K,)
    of the W neighbouring directions that have a weight, and the weights (K, W) of those from it on.
    """
    cubics, above = direction_cubics(tuple(angles.tolist()))
    rises = upward_cosine > 0
    if above in (0, angles.size):  # all directions are asked of the one hemisphere there is
        rises = np.full(upward_cosine.size, above > 0)
    place = np.arctanh(np.minimum(np.sqrt(np.maximum(1 - upward_cosine**2, 0.0)), 1 - 1e-12))
    lowest, highest = cubics.nodes[[0, above - 1]] if above else (0.0, 0.0)
    up = np.clip(place, lowest, highest)
    lowest, highest = cubics.nodes[[above, -1]] if above < angles.size else (0.0, 0.0)
    return cubics.weights(np.where(rises, up, np.clip(TURN - place, lowest, highest)))


def source_ends(segments, below, above, levels):
    """A source function (K, P) at both ends of each segment, from those at the lower and upper level of its layer: the
    line between them has the mean of the source over the segment's air and its difference between the ends.
    """
    climb = 0.5 * np.diff(segments.altitude) / np.diff(levels)[segments.layer]
    difference = above - below
    middle = below + difference * segments.upper_share[:, None]
    half = np.clip(difference * climb[:, None], -middle, middle)  # a source is never negative
    return middle - half, middle + half


def upper_share_of(segments, per_molecule):
    """Share (K,) of each segment's integral of a property (N, P) over all points that counts with the upper level."""
    total = per_molecule.sum(axis=1)
    upper = segments.upper * total[segments.layer + 1]
    column = segments.lower * total[segments.layer] + upper
    return np.where(column > 0, upper / np.where(column > 0, column, 1.0), segments.upper_share)


def line_of(depths):
    """Number of the line of each segment, (K,); between two lines that of the first."""
    return np.repeat(np.arange(depths.starts.size), np.diff(depths.starts, append=len(depths.per_segment) + 1))[:-1]


# ---- Weights of a source function in the light of segments


def source_weights_along(segments, depths, scaled, levels, extinction, parts):
    """Weights of a source function of delta-scaled layers: of each segment a list of places and weights (P,).

    Inside a segment the source is linear in optical depth, or, in each pair of parts of a cut layer, quadratic;
    between the last scattering and the observer all extinction applies. `depths` and `scaled` are of all extinction
    and delta-scaled, `levels` (N,) m, `extinction` (N, P) delta-scaled.
    """
    through = np.exp(-depths.cumulative[:-1].astype(float))
    result = []
    for k, layer in enumerate(segments.layer):
        bottom, height = levels[layer], levels[layer + 1] - levels[layer]
        optical = scaled.per_segment[k].astype(float)
        if parts.count[layer] == 1:
            near, far = source_weights(optical)
            upper = segments.upper[k] * extinction[layer + 1].astype(float)
            share = np.divide(upper, optical, out=np.zeros_like(upper), where=optical > 0)
            climb = 0.5 * (segments.altitude[k + 1] - segments.altitude[k]) / height
            above = np.clip((near + far) * share + (far - near) * climb, 0, near + far)
            pieces = [(layer, near + far - above), (layer + 1, above)]
        else:
            ends = np.clip((segments.altitude[k : k + 2] - bottom) / height, 0, 1)
            pieces = _pieces(optical, layer, *ends, parts)
        result.append([(place, weight * through[k]) for place, weight in pieces])
    return result


def _pieces(optical, layer, nearer, farther, parts):
    """Places and weights at the near end of a segment of a cut layer, between shares of the layer from below."""
    edges, places, known = parts.pairs
    low, high = layer + min(nearer, farther), layer + max(nearer, farther)
    first = int(np.searchsorted(edges, min(low, layer + 1 - LEVEL) + 0.5 * LEVEL, side="right")) - 1
    stop = max(int(np.searchsorted(edges, high - LEVEL, side="left")), first + 1)
    whole, result = farther - nearer, []
    for pair in range(first, stop):
        start, end = max(low, edges[pair]) - layer, min(high, edges[pair + 1]) - layer
        begin, step = (start, end - start) if whole >= 0 else (end, start - end)
        share, before = (1.0, 0.0) if abs(whole) < LEVEL else (step / whole, (begin - nearer) / whole)
        powers = np.stack(power_weights(share * optical))
        of_values = through_three(known[pair][None], np.array([begin]), np.array([step]))[0] @ powers
        result += zip(places[pair].tolist(), of_values * np.exp(-before * optical), strict=True)
    return result


def source_weights(depth):
    """Weights of a source linear in optical depth, of its near and far end."""
    thin, thick, far = np.minimum(depth, 0.5), np.maximum(depth, 0.5), np.zeros_like(depth)
    for n in range(20, 0, -1):  # sum of (-1)^(n + 1) n t^n / (n + 1)!
        far = (far + (-1) ** (n + 1) * n / factorial(n + 1)) * thin
    far = np.where(depth < 0.5, far, -np.expm1(-thick) * (1 + 1 / thick) - 1)
    return -np.expm1(-depth) - far, far


def power_weights(depth):
    """What sources 1, u and u^2 send out of the near end, with u from 0 there to 1 at an optical depth."""
    near, far = source_weights(depth)
    thin, series = np.minimum(depth, 0.5), np.zeros_like(depth)
    for n in range(20, -1, -1):  # sum of (-1)^n t^(n + 1) / (n! (n + 3))
        series = series * thin + (-1) ** n / (factorial(n) * (n + 3))
    square = 2 * far / np.maximum(depth, 0.5) - np.exp(-depth)
    return near + far, far, np.where(depth < 0.5, series * thin, square)


def straight_weights(depths, scaled):
    """Share (K, P) of the light at the far end of each segment that reaches the observer scattered straight forward."""
    all_of_it, left = depths.per_segment.astype(float), scaled.per_segment.astype(float)
    through = np.exp(-depths.cumulative[:-1].astype(float))
    return through * np.exp(-left) * -np.expm1(np.minimum(left - all_of_it, 0))


def straight_at(table, segments, levels, angles):
    """Radiance (K, ...) of a table (N, X, ...) of levels and directions at the far ends of segments."""
    first, of_direction = direction_weights(segments.upward_cosine, angles)
    result = []
    for k, layer in enumerate(segments.layer):
        share = np.clip((segments.altitude[k + 1] - levels[layer]) / (levels[layer + 1] - levels[layer]), 0, 1)
        near = table[layer : layer + 2, first[k] : first[k] + of_direction.shape[1]].astype(float)
        result.append(np.tensordot(np.outer([1 - share, share], of_direction[k]), near, 2))
    return np.array(result)


# ---- Thermal radiation


def thermal(air, segments, depths):
    """Thermal radiance (K, P) of each segment at the observer, W m^-2 sr^-1 (cm^-1)^-1."""
    source, field = air.thermal, air.thermal.field
    depths = Depths(depths.per_segment.astype(float), depths.starts)
    if field is None:
        emission, layer = source.emission.astype(float), segments.layer
        near, far = source_ends(segments, emission[layer], emission[layer + 1], source.levels)
        of_near, of_far = source_weights(depths.per_segment)
        return (of_near * near + of_far * far) * depths.transmittance
    scaled = Depths(segments.column(field.scaled), depths.starts)
    radiance = straight_weights(depths, scaled) * straight_at(field.straight, segments, source.levels, field.angles)
    functions = field.ordinates.functions(segments.upward_cosine)
    weights = source_weights_along(segments, depths, scaled, source.levels, field.scaled, field.parts)
    for k, of_segment in enumerate(weights):
        for place, weight in of_segment:
            radiance[k] += weight * (functions[k] @ field.source[place])
    return radiance


# ---- Light of a source scattered once


def source_depth(paths, altitude, cosine):
    """Optical depth (K, S, P) to a source from altitudes (K,) [m], for cosines (K, S) of its zenith angle; 1e4 or more
    where the Earth hides it, 0 where its light meets no air.
    """
    top, result = paths.levels[-1], np.zeros((*np.shape(cosine), paths.log_depth.shape[2]))
    for k, height in enumerate(np.asarray(altitude, float)):
        elevation = np.arcsin(np.clip(cosine[k], -1, 1))
        if height > top:  # moved along the ray to where it enters the air
            ratio = (EARTH_RADIUS + height) / (EARTH_RADIUS + top) * np.cos(elevation)
            meets = (elevation < 0) & (ratio < 1)
            height, elevation = top, np.where(meets, -np.arccos(np.minimum(ratio, 1)), elevation)
        else:
            meets = np.full(elevation.shape, True)
        lower = int(np.clip(np.searchsorted(paths.levels, height, side="right") - 1, 0, paths.levels.size - 2))
        share = np.clip((height - paths.levels[lower]) / (paths.levels[lower + 1] - paths.levels[lower]), 0, 1)
        of_levels = np.array([1 - share, share])
        nodes = of_levels @ paths.elevation[lower : lower + 2]
        place = np.interp(elevation, nodes, np.arange(nodes.size))
        first = np.minimum(place.astype(int), nodes.size - 2)
        of_far = (place - first)[:, None]
        corners = np.tensordot(of_levels, paths.log_depth[lower : lower + 2].astype(float), 1)
        logarithm = (1 - of_far) * corners[first] + of_far * corners[first + 1]
        across = (EARTH_RADIUS + height) / SHELL * np.sin(elevation)
        root = np.sqrt(across**2 + 2 * (EARTH_RADIUS + height) / SHELL + 1)
        depth = np.exp(logarithm) * (root - across)[:, None] + HIDDEN * (elevation < nodes[0])[:, None]
        result[k, meets] = depth[meets]
    return result


def attenuation(segments, depths, paths, cosine):
    """Mean transmittance (K, S, P) from a source to each segment and on to the observer; `cosine` (K + 1, S) of the
    source's zenith angle at the segment ends. The optical depth is linear inside a segment.
    """
    depth = source_depth(paths, segments.altitude, cosine)
    depth += np.minimum(depths.cumulative.astype(float), HIDDEN)[:, None]
    return mean_attenuation(depth[:-1], depth[1:])


def scattering(segments, optics, deflection, phase=None, line=None):
    """Optical depth of scattering in each segment times the phase function, (K, S, P), for cosines (K + 1, S) of the
    scattering angle at the segment ends. `phase` (L, N, S, C), by `line` (K,), is that of the particles in place of the
    one at that angle.
    """
    middle = np.clip(0.5 * (deflection[:-1] + deflection[1:]), -1, 1)
    molecules = segments.column(optics.rayleigh.astype(float))[:, None]
    light = rayleigh_phase(middle, optics.rayleigh_anisotropy.mean())[..., None] * molecules
    particles = optics.aerosol_scattering.astype(float)
    if not np.any(particles):
        return light
    share = upper_share_of(segments, particles)
    angle = np.arccos(middle)
    for k, s in np.ndindex(middle.shape):
        layer = segments.layer[k]
        if phase is None:
            place = angle[k, s] / PHASE_ANGLES[1]
            first = min(int(place), PHASE_ANGLES.size - 2)
            near, far = optics.phase[first, layer : layer + 2], optics.phase[first + 1, layer : layer + 2]
            ends = near + (far - near) * (place - first)
        else:
            ends = phase[line[k], layer : layer + 2, s]
        shape = (1 - share[k]) * ends[0] + share[k] * ends[1]
        column = segments.lower[k] * particles[layer] + segments.upper[k] * particles[layer + 1]
        light[k, s] += shape @ optics.phase_share * column
    return light


def peak_depth(peak, segments, depths, to_source):
    """Depth of peak scattering (K + 1, S, Q) from the source by each segment end to the observer."""
    source = source_depth(peak.paths, segments.altitude, to_source)
    source[source >= HIDDEN] = 0
    along = Depths(segments.column(peak.scattering[:, peak.few].astype(float)), depths.starts).cumulative
    return source + along[:, None]


def peak_is_near(peak, segments, depths, to_source, deflection):
    """Sources so close to a line, through so much peak scattering, that the peak matters, (L, S)."""
    along = Depths(segments.column(peak.scattering[:, peak.few].astype(float)), depths.starts).cumulative
    source = peak_depth(peak, segments, depths, to_source) - along[:, None]
    near = []
    for first, stop in zip(depths.starts, np.append(depths.starts[1:], len(to_source)), strict=True):
        close = deflection[first:stop].max(axis=0) > np.cos(np.radians(peak.degrees[-1]))
        whole = np.maximum(source[first], source[stop - 1]) + along[stop - 1]
        near.append(close & np.any(whole > NONE, axis=1))
    return np.array(near)


def peak_change(peak, segments, depths, to_source, deflection, near):
    """Change (K, S, P) of what `scattering` gives, by scattering again and again in the forward peak; 0 where the peak
    is not `near` (K, S).
    """
    depth = peak_depth(peak, segments, depths, to_source)
    known = np.log(peak.limits[0]) + peak.limits[1] * np.arange(peak.mixed.shape[2])
    first, share = peak.spread
    few = np.arange(depth.shape[2])
    change = np.zeros((segments.layer.size, to_source.shape[1], peak.scattering.shape[1]))
    for k in np.flatnonzero(near.any(axis=1)):
        s = np.flatnonzero(near[k])
        middle = 0.5 * (depth[k, s] + depth[k + 1, s])
        cosine = np.clip(0.5 * (deflection[k, s] + deflection[k + 1, s]), -1, 1)
        turn = np.interp(np.degrees(np.arccos(cosine)), peak.degrees, np.arange(peak.degrees.size))[:, None]
        angle = np.minimum(turn.astype(int), peak.degrees.size - 2)
        deep = np.interp(np.log(np.maximum(middle, 1e-9)), known, np.arange(known.size))
        lower = np.minimum(deep.astype(int), known.size - 2)
        part = np.clip((middle - NONE) / (WHOLE - NONE), 0, 1) * np.minimum(middle / peak.limits[0], 1)
        for level, air in ((segments.layer[k], segments.lower[k]), (segments.layer[k] + 1, segments.upper[k])):
            mixed = peak.mixed[level]
            near_angle, far_angle = (
                mixed[node, lower, few] * (lower + 1 - deep) + mixed[node, lower + 1, few] * (deep - lower)
                for node in (angle, angle + 1)
            )
            at_few = (near_angle * (angle + 1 - turn) + far_angle * (turn - angle)) * part
            every = at_few[:, first] * (1 - share) + at_few[:, np.minimum(first + 1, few.size - 1)] * share
            change[k, s] += air * peak.scattering[level] * every
    return change


# ---- Light scattered more than once


def again(air, segments, depths, to_source, deflection):
    """Light scattered more than once, of each segment at the observer, (K, S, P) sr^-1."""
    field = air.diffuse_light
    depths = Depths(depths.per_segment.astype(float), depths.starts)
    scaled = Depths(segments.column(field.scaled), depths.starts)
    middle, angle = (0.5 * (part[:-1] + part[1:]) for part in (to_source, deflection))
    nodes = elevation_weights(field.sine, middle)  # (K, S, U)
    turns = multiples(segments.upward_cosine[:, None], middle, angle, field.ordinates.azimuthal)  # (K, S, M)
    functions, moment = field.ordinates.functions(segments.upward_cosine), field.ordinates.pairs[0]
    light = np.zeros((*middle.shape, scaled.per_segment.shape[1]))
    weights = source_weights_along(segments, depths, scaled, field.levels, field.scaled, field.parts)
    for k, of_segment in enumerate(weights):
        table = sum(weight * field.source[place].astype(float) for place, weight in of_segment)  # (U, B, P)
        light[k] = np.einsum("su,sb,ubp->sp", nodes[k], turns[k][:, moment] * functions[k], table, optimize=True)
    if field.straight is not None:
        by_direction = np.moveaxis(field.straight, 1, 2)  # (N, X, U, M, P)
        straight = straight_at(by_direction, segments, field.levels, field.angles)  # (K, U, M, P)
        share = straight_weights(depths, scaled)[:, None]
        light += share * np.einsum("ksu,ksm,kump->ksp", nodes, turns, straight, optimize=True)
    return light


def multiples(upward_cosine, to_source, deflection, count):
    """Cosines (..., M) of multiples of the azimuth between scattered light and the beam, from the cosines of the
    light's angle from the vertical, of the source's zenith angle and of the scattering angle.
    """
    across = np.sqrt(np.maximum((1 - upward_cosine**2) * (1 - to_source**2), 1e-12))
    azimuth = np.arccos(np.clip((deflection + upward_cosine * to_source) / across, -1, 1))
    return np.cos(azimuth[..., None] * np.arange(count))


# ---- Both


@dataclass
class Scattered:
    """Light of sources along joined lines: scattered once and more often, of segments (K, S, P), and of which lines and
    sources the forward peak matters, (L, S); never negative where that is asked.
    """

    once: np.ndarray
    again: np.ndarray
    near: np.ndarray
    depths: Depths

    @classmethod
    def of(cls, air, segments, depths, to_source, deflection, phase=None):
        """That of a state; `phase` as of `scattering`."""
        paths = air.scaled_source_paths
        scaled = Depths(segments.column(air.scaled_extinction), depths.starts)
        light = scattering(segments, air.optics, deflection, phase, line_of(depths))
        near = np.zeros((depths.starts.size, to_source.shape[1]), bool)
        if np.any(air.optics.aerosol_scattering):
            near = peak_is_near(air.forward_peak, segments, depths, to_source, deflection)
        if near.any():
            light += peak_change(air.forward_peak, segments, depths, to_source, deflection, near[line_of(depths)])
        once = attenuation(segments, scaled, paths, to_source) * light / (4 * np.pi)
        return cls(once, again(air, segments, depths, to_source, deflection), near, depths)

    def along(self):
        """(L, S, P)."""
        once, more = (self.depths.by_line(part) for part in (self.once, self.again))
        once = np.where(self.near[..., None], np.maximum(once, 0), once)
        return once + np.maximum(more, 0)

    def in_band(self, weight):
        """(K + 1, S) of a band of weights (P,)."""
        once, more = self.once @ weight, np.maximum(self.again @ weight, 0)
        once = np.where(self.near[line_of(self.depths)], np.maximum(once, 0), once)
        return self.depths.summed(once + more)

    def of_segments(self):
        """(K, P) of one source."""
        return self.once[:, 0] + np.maximum(self.again[:, 0], 0)
