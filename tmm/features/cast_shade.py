"""Cast shade of a photograph by the Sun's direction: dark texels that end, away from the Sun, in their own ground.

A shadow begins at what casts it and ends, along the line from the Sun, where the same ground lies in sunlight. All
these far ends of one photograph step up by the same light, that of the Sun and the sky over that of the sky alone.
Borders of materials step up by other ratios, and as often towards the Sun as away from it: the ratio of which there are
more away from the Sun than towards it is the gain of sunlight. From every far end of that ratio a run of dark texels
leads back towards the Sun to the caster. Dark forest, water and asphalt have no such ends, or have the same ground on
both sides, and so no caster.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.features.light import GUIDED_RADIUS, LEAST_LIGHT, LUMINANCE, guided, light_windows
from skyshine.tmm.images.texture import Windowed

REACH = 128  # texels that a shadow is followed at most
_FINE, _COARSE = 1.0, 2.0  # texels: standard deviations of the filters of light, and of edges
_APART = 5  # texels from an edge at which its sides are compared: beyond the penumbra of crowns
_SLOPE = 0.04  # slope of the logarithm of light, a texel: least of an edge
_STEP = 0.25  # logarithm of the least ratio of an edge, in every channel
_ALONG = 0.25  # least cosine of an edge's normal with the line from the Sun
_MOST_STEP = 2.6  # logarithm: thirteenfold; the sky alone gives no less on clear days
_BIN, _BINS = 0.1, 30  # bins of the histogram of ratios
_LEAST_EDGES, _SIGNIFICANT = 30, 3.0  # edges; standard deviations by which more of them lie away from the Sun
_OFTEN = 1.5  # times as many: neighbouring edges of one dark thing are not independent
_LEAST_GAIN = 1.4  # smallest gain of the least channel
_BLUER = 0.1  # least difference of the logarithms of the gains of red and blue: sky is blue
_SPREAD = 0.35  # standard deviation of the logarithms of true ratios around the gain
_SHALLOW, _DEEP = 0.6, 1.15  # shares of the gain's logarithm that a far end may have: half shade, and darker ground
_SAME = 0.35  # likewise, of the light before a caster and beyond its shadow, where both are one ground
_DOUBT = (
    0.7  # weight of a run with the same ground at both ends: a dark thing rather than a bridge over its own asphalt
)
_BOX = 15  # texels over which runs are counted
_LIKELY = 0.35  # least share of the runs through a texel that end as shade does
_NEAR_RUNS = 0.22  # least number of runs a texel, over 5 x 5 of them; between two of its steps of 0.04
_CELL, _CELLS, _DARKEST = 0.2, 33, -6.3  # cells of the table of sunlit light; logarithm where it begins
_LLR_LIMIT = 3.0  # limit of the logarithm of the ratio of its likelihoods
_HEADROOM = 0.25  # logarithm above the light of all but 1 % of the texels, that a texel without its shade may have
_LEAST_SHARE = 0.001  # fraction of the texels


@dataclass(frozen=True)
class Fall:
    """How shadows fall in a photograph.

    x, y : float; unit vector in texels, away from the Sun: x to the right, y down.
    reach : int; texels that the longest shadow has, `REACH` at most.
    azimuth : float; of the Sun, in degrees clockwise from north; for messages.
    """

    x: float
    y: float
    reach: int
    azimuth: float


@dataclass(frozen=True)
class _Edges:
    """Edges of light of one window: away from the Sun, or towards it.

    ratio : (N, C); logarithm of light on the bright over the dark side.
    along : (N,); cosine between the normal to the bright side and the line from the Sun; negative towards the Sun.
    texel, edge : (M,) int; texels of the runs that lead from the edges through the dark, and the edge of each.
    ended : (N,) bool; whether the run came to an end in brighter light.
    cast : (N,)
        How little the light beyond the run is that of the edge's own bright side: 1 is a caster, 0.3 the same ground.
    """

    ratio: npt.NDArray[Any]
    along: npt.NDArray[Any]
    texel: npt.NDArray[Any]
    edge: npt.NDArray[Any]
    ended: npt.NDArray[np.bool_]
    cast: npt.NDArray[Any]


@dataclass(frozen=True)
class CastShade:
    """What tells cast shade from sunlight in one photograph, where the Sun's direction is known.

    fall : Fall
    gain : tuple of float; sunlit over shaded light, for each channel of the photograph.
    brightest : float; logarithm of the luminance that no texel without its shade has.
    span : (float, float); limits of the logarithm of luminance, within which the filter follows edges.
    sunlit : (33, 33, 33) float32; logarithm of the density of sunlit light by the logarithms of red, green and blue.

    References
    ----------
    Gain of pairs across the border: Guo, Dai and Hoiem (2013), Paired regions for shadow detection and removal, IEEE
    TPAMI 35, 2956-2967. The side away from the Sun tells shade from dark things: Irvin and McKeown (1989), Methods for
    exploiting the relationship between buildings and their shadows in aerial imagery, IEEE Trans. Syst. Man Cybern.
    19, 1564-1575. Edges: Canny (1986), IEEE TPAMI 8, 679-698. Soft edges: as `shade.Shade`.
    """

    fall: Fall
    gain: tuple[float, ...]
    brightest: float
    span: tuple[float, float]
    sunlit: npt.NDArray[np.float32]

    @property
    def margin(self) -> int:
        """Texels beyond a window on which its shade depends: a run, what lies beyond it, and widths of filters."""
        return self.fall.reach + 3 * _APART + _BOX + 2 * GUIDED_RADIUS + 2 * int(8 * _COARSE)

    @classmethod
    def of(cls, texture: Windowed, path: Any, fall: Fall) -> CastShade:
        """Find the shade of a texture in some windows of it.

        Raises InputError: no more edges step up away from the Sun than towards it, by a light that is brighter and less
        blue.
        """
        parts: list[tuple[npt.NDArray[Any], npt.NDArray[np.bool_]]] = []
        aways: list[_Edges] = []
        edges: list[_Edges] = []
        for light, valid in light_windows(texture):
            if valid.any():
                parts.append((_fine(light, valid), valid))
                away, towards = _edges(light, valid, parts[-1][0], fall, (1, -1))
                aways.append(away)
                # Runs towards the Sun, which are long, tell nothing more.
                empty = np.empty(0, np.int32)
                edges += [away, replace(towards, texel=empty, edge=empty)]
        gain = _gain(edges)
        if gain is None:
            raise _no_shade(path, fall)
        levels = np.concatenate([fine[..., -1][valid] for fine, valid in parts])
        low, high = (float(at) for at in np.percentile(levels, (1, 99)))
        initial = cls(
            fall, tuple(np.exp(gain).tolist()), high + _HEADROOM, (low, high), np.zeros((1, 1, 1), np.float32)
        )
        counts, marked, total = np.zeros((_CELLS,) * 3), 0, 0
        for (fine, valid), away in zip(parts, aways, strict=True):
            inside = initial._inside(away, valid, fine)[0]
            marked, total = marked + int(inside.sum()), total + int(valid.sum())
            np.add.at(counts, _cells(fine[valid & ~inside]), 1.0)
        if marked < _LEAST_SHARE * total:
            raise _no_shade(path, fall)
        return cls(fall, initial.gain, initial.brightest, initial.span, _density(counts))

    def fraction(self, light: npt.NDArray[Any], valid: npt.NDArray[np.bool_]) -> npt.NDArray[np.float32]:
        """Share (h, w) of the Sun that is hidden from each texel, of linear light (h, w, C).

        The outer `margin` is less sure.
        """
        fine = _fine(light, valid)
        inside, depth = self._inside(_edges(light, valid, fine, self.fall, (1,))[0], valid, fine)
        shade = guided(inside.astype(float), np.clip(fine[..., -1], *self.span))
        step = np.log(np.dot(LUMINANCE, self.gain[:3]))
        shade *= (1 - np.exp(-depth * step)) / (1 - np.exp(-step))  # what leaves light of the gain to this depth
        fraction: npt.NDArray[np.float32] = np.where(valid, np.clip(shade, 0.0, 1.0), 0.0).astype(np.float32)
        return fraction

    def relit(self, light: npt.NDArray[Any], fraction: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Linear light (h, w, C) without its shade: with all of the Sun where a fraction of it is hidden."""
        sunlit: npt.NDArray[Any] = light / (1 - fraction[..., np.newaxis] * (1 - 1 / np.array(self.gain)))
        return sunlit

    def _inside(
        self, away: _Edges, valid: npt.NDArray[np.bool_], fine: npt.NDArray[Any]
    ) -> tuple[npt.NDArray[np.bool_], npt.NDArray[Any]]:
        """Which texels lie in the shade, by the edges away from the Sun, and how deep: 1 is the gain's logarithm."""
        from scipy.ndimage import gaussian_filter, uniform_filter

        gain = np.log(self.gain)
        share = away.ratio[:, :3] @ gain[:3] / (gain[:3] @ gain[:3])
        depth = np.clip(share, _SHALLOW, _DEEP)
        distance = np.linalg.norm(away.ratio[:, :3] - depth[:, np.newaxis] * gain[:3], axis=1)
        strong = (share > _SHALLOW).astype(float)
        match = strong * away.ended * away.cast * np.exp(-0.5 * (distance / _SPREAD) ** 2)

        def runs(weight: npt.NDArray[Any]) -> npt.NDArray[Any]:
            sums = np.bincount(away.texel, weight[away.edge], minlength=valid.size)
            counted: npt.NDArray[Any] = sums.reshape(valid.shape)
            return counted

        count, matched, deep = (runs(weight) for weight in (strong, match, match * depth))
        over, like, depths = (uniform_filter(values, _BOX) for values in (count, matched, deep))
        likely = np.clip((like + 0.015) / (over + 0.1), 0.01, 0.99)
        depth_here = np.where(like > 0.02, depths / np.maximum(like, 1e-9), 1.0)
        inside = valid & (likely > _LIKELY) & (uniform_filter(count, 5) > _NEAR_RUNS)
        inside &= fine[..., -1] + depth_here * np.log(np.dot(LUMINANCE, self.gain[:3])) < self.brightest
        if self.sunlit.size > 1:
            # Without its shade the texel must look like sunlit ground of this photograph rather than as it is.
            bright = self.sunlit[_cells(fine[..., :3] + depth_here[..., np.newaxis] * gain[:3])]
            evidence = np.clip(bright - self.sunlit[_cells(fine)], -_LLR_LIMIT, _LLR_LIMIT)
            odds = np.log(likely / (1 - likely)) - np.log(_LIKELY / (1 - _LIKELY))
            inside &= odds + gaussian_filter(evidence, 2.0) > 0
        return inside, depth_here


def _no_shade(path: Any, fall: Fall) -> InputError:
    return InputError(
        f"has no shade that falls away from a Sun at azimuth {fall.azimuth:.0f} degrees; correct 'sun_azimuth_deg' or "
        "'time', or leave 'shade' out",
        file=path,
    )


def _fine(light: npt.NDArray[Any], valid: npt.NDArray[np.bool_]) -> npt.NDArray[Any]:
    """Logarithms (h, w, C + 1) of the channels and, last, of luminance, smoothed over texels with data."""
    return _smooth(light, valid, _FINE)


def _smooth(light: npt.NDArray[Any], valid: npt.NDArray[np.bool_], width: float) -> npt.NDArray[Any]:
    from scipy.ndimage import gaussian_filter

    clipped = np.maximum(light, 0.0)
    logarithms = np.log(
        np.concatenate([clipped, clipped[..., :3] @ np.array(LUMINANCE)[:, np.newaxis]], -1) + LEAST_LIGHT
    )
    planes = [gaussian_filter(np.where(valid, plane, 0.0), width) for plane in np.moveaxis(logarithms, -1, 0)]
    if valid.all():
        return np.stack(planes, axis=-1)
    weight = np.maximum(gaussian_filter(valid.astype(float), width), 1e-6)
    return np.stack([plane / weight for plane in planes], axis=-1)


def _edges(
    light: npt.NDArray[Any],
    valid: npt.NDArray[np.bool_],
    fine: npt.NDArray[Any],
    fall: Fall,
    sides: tuple[int, ...],
) -> list[_Edges]:
    """Edges of a window whose bright side lies away from the Sun (1) or towards it (-1), and the runs from them."""
    from scipy.ndimage import minimum_filter

    coarse = _smooth(light, valid, _COARSE)
    level = coarse[..., -1]
    down, right = np.gradient(level) if min(level.shape) > 1 else (np.zeros_like(level), np.zeros_like(level))
    slope = np.hypot(down, right)
    # Both sides lie within the window, on texels with data.
    solid = minimum_filter(valid, 2 * _APART + 5, mode="constant", cval=False)
    row, column = np.nonzero(solid & (slope > _SLOPE))
    steep = slope[row, column]
    x, y = right[row, column] / steep, down[row, column] / steep
    ahead, behind = (_between(slope[..., np.newaxis], row + side * y, column + side * x)[:, 0] for side in (1, -1))
    crest = (steep >= ahead) & (steep > behind)
    row, column, x, y = row[crest], column[crest], x[crest], y[crest]
    bright, dark = (_between(coarse, row + side * y, column + side * x) for side in (_APART, -_APART))
    ratio, middle, along = bright - dark, (bright[:, -1] + dark[:, -1]) / 2, x * fall.x + y * fall.y
    clear = ratio[:, :3].min(axis=1, initial=np.inf) > _STEP
    edges = []
    for side in sides:
        accepted = clear & (side * along > _ALONG)
        step = -side * fall.x, -side * fall.y
        start = row[accepted], column[accepted]
        edge_of, texel, length, ended = _runs(fine[..., -1], valid, start, middle[accepted], step, fall.reach)
        beyond = _at(fine, start, step, np.maximum(length, _APART - 1) + 1 + _APART)
        before = _at(fine, start, step, np.full(len(length), -_APART))
        apart = np.linalg.norm((beyond - before)[:, :3], axis=1)
        cast = 1 - _DOUBT * np.exp(-0.5 * (apart / _SAME) ** 2)
        edges.append(_Edges(ratio[accepted, :-1], along[accepted], texel, edge_of, ended, cast))
    return edges


def _between(values: npt.NDArray[Any], row: npt.NDArray[Any], column: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Values (N, K) of planes (h, w, K) between texels, bilinear; all places lie within."""
    top, left = np.floor(row).astype(int), np.floor(column).astype(int)
    top, left = np.minimum(top, values.shape[0] - 2), np.minimum(left, values.shape[1] - 2)
    down, right = (row - top)[:, np.newaxis], (column - left)[:, np.newaxis]
    upper = values[top, left] * (1 - right) + values[top, left + 1] * right
    lower = values[top + 1, left] * (1 - right) + values[top + 1, left + 1] * right
    between: npt.NDArray[Any] = upper * (1 - down) + lower * down
    return between


def _at(
    values: npt.NDArray[Any],
    start: tuple[npt.NDArray[Any], npt.NDArray[Any]],
    step: tuple[float, float],
    count: npt.NDArray[Any],
) -> npt.NDArray[Any]:
    """Values (N, C) so many steps from texels, or at the border of the window."""
    row, column = (np.rint(at + move * count).astype(int) for at, move in zip(start, (step[1], step[0]), strict=True))
    sampled: npt.NDArray[Any] = values[np.clip(row, 0, values.shape[0] - 1), np.clip(column, 0, values.shape[1] - 1)]
    return sampled


def _runs(
    level: npt.NDArray[Any],
    valid: npt.NDArray[np.bool_],
    start: tuple[npt.NDArray[Any], npt.NDArray[Any]],
    limit: npt.NDArray[Any],
    step: tuple[float, float],
    reach: int,
) -> tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[np.bool_]]:
    """Runs of texels darker than a limit for each, from edges along a line; their edges, texels, lengths and ends."""
    height, width = level.shape
    dimmest, data = np.ravel(level), np.ravel(valid)
    active = np.arange(len(limit), dtype=np.int32)
    length, ended = np.zeros(len(limit), int), np.zeros(len(limit), bool)
    edges, texels = [np.empty(0, np.int32)], [np.empty(0, np.int32)]
    for count in range(_APART - 1, reach + _APART - 1):
        row = np.rint(start[0][active] + step[1] * count).astype(int)
        column = np.rint(start[1][active] + step[0] * count).astype(int)
        within = (row >= 0) & (row < height) & (column >= 0) & (column < width)
        active, texel = active[within], row[within] * width + column[within]
        there = data[texel]
        active, texel = active[there], texel[there]
        dark = dimmest[texel] < limit[active]
        ended[active[~dark]] = True
        active, texel = active[dark], texel[dark]
        if not len(active):
            break
        length[active] = count
        edges.append(active)
        texels.append(texel.astype(np.int32))
    return np.concatenate(edges), np.concatenate(texels), length, ended


def _gain(edges: Sequence[_Edges]) -> npt.NDArray[Any] | None:
    """Logarithm (C,) of the ratio of which there are more edges away from the Sun than towards it; None without."""
    from scipy.ndimage import gaussian_filter

    if not edges:
        return None
    ratio = np.concatenate([part.ratio[part.ended] for part in edges])
    weight = np.concatenate([(part.along * part.cast)[part.ended] for part in edges])
    colours = ratio[:, :3]
    # Light of the sky is blue: what it leaves is least in red and most in blue.
    sky = (colours.min(axis=1, initial=np.inf) > _STEP) & (colours.max(axis=1, initial=-np.inf) < _MOST_STEP)
    sky &= (np.diff(colours, axis=1) <= 0.05).all(axis=1) & (colours[:, 0] > colours[:, 2] + _BLUER)
    ratio, colours, weight = ratio[sky], colours[sky], weight[sky]
    if len(ratio) < _LEAST_EDGES:
        return None
    sides = []
    for towards in (1, -1):
        counts = np.zeros((_BINS,) * 3)
        np.add.at(counts, tuple((colours / _BIN).astype(int).T), np.maximum(towards * weight, 0.0))
        sides.append(gaussian_filter(counts, 1.0))
    excess = sides[0] - sides[1]
    peak = (np.array(np.unravel_index(excess.argmax(), excess.shape)) + 0.5) * _BIN
    gain = np.zeros(ratio.shape[1])
    for _ in range(5):  # rounds of the mean shift: it moves by a bin at most
        near = weight * np.exp(-0.5 * ((colours - peak) ** 2).sum(axis=1) / 0.15**2)
        if near.sum() <= 0:
            return None
        gain = near @ ratio / near.sum()
        peak = gain[:3]
    near = np.abs(weight) * np.exp(-0.5 * ((colours - peak) ** 2).sum(axis=1) / 0.2**2)
    away, towards_sun = near[weight > 0].sum(), near[weight < 0].sum()
    if away - towards_sun < _SIGNIFICANT * np.sqrt(away + towards_sun) or away < _OFTEN * towards_sun:
        return None
    return gain if np.exp(peak.min()) >= _LEAST_GAIN and peak[0] >= peak[2] + _BLUER else None


def _cells(logarithms: npt.NDArray[Any]) -> tuple[npt.NDArray[Any], ...]:
    """Cells of the table of sunlit light that logarithms (..., 3 or more) of red, green and blue fall in."""
    cells = np.clip((logarithms[..., :3] - _DARKEST) / _CELL, 0, _CELLS - 1).astype(int)
    return tuple(np.moveaxis(cells, -1, 0))


def _density(counts: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    from scipy.ndimage import gaussian_filter

    smooth = gaussian_filter(counts, 0.8)
    density: npt.NDArray[np.float32] = np.log(smooth / max(smooth.sum(), 1.0) + 1e-5).astype(np.float32)
    return density
