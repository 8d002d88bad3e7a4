"""Cast shade of a photograph: where it lies, and how much brighter the photograph were without it.

Shade is lit by the sky alone: darker than sunlit ground, and bluer. Where both together part the texels into two kinds,
the border between them runs along shadows, and what lies on either side of it is mostly of one material: the ratio of
both sides, by channel, is the gain that takes the shade away.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.features.cast_shade import CastShade, Fall
from skyshine.tmm.features.light import (
    GUIDED_RADIUS,
    LEAST_LIGHT,
    LUMINANCE,
    guided,
    light_windows,
    linear_light,
    stored_light,
)
from skyshine.tmm.images.texture import TextureFile, Windowed

_TILE = 512  # texels of a side of a tile whose cast shade is found at once
_SMOOTH = 1.0  # texels: standard deviation of the filter before the two kinds are told
_NEAR = 3  # texels from the border, over as many more, in which both sides are compared
_AROUND = 6  # texels over which a side is averaged
MARGIN = 2 * GUIDED_RADIUS + 4  # texels beyond a window on which its shade depends
# Share of the variance between both kinds below which they are one: .64 is that of a single Gaussian cut at its mean.
_LEAST_PARTED = 0.7
_LEAST_GAIN = 1.5  # of the least channel: the sky alone gives at most two thirds of clear daylight
_BLUER = 1.2  # least ratio of the gains of red and blue: 1.6 under a clear sky (`textured.SHADOW_LIGHT`)
_LEAST_SHARE = 0.005  # of the texels, in each kind


@dataclass(frozen=True)
class Shade:
    """What tells shade from sunlight in one photograph.

    Attributes
    ----------
    threshold : float
        Of the logarithm of blue over red and luminance, above which a texel is in the shade.
    span : (float, float)
        Limits of that logarithm, within which the filter follows edges.
    gain : tuple of float
        Sunlit over shaded light, for each channel of the photograph.

    References
    ----------
    Two kinds: Otsu (1979), IEEE Trans. Syst. Man Cybern. 9, 62-66. Soft edges: He, Sun and Tang (2013), Guided image
    filtering, IEEE TPAMI 35, 1397-1409. Gain of pairs across the border: Guo, Dai and Hoiem (2013), Paired regions for
    shadow detection and removal, ibid. 35, 2956-2967.
    """

    threshold: float
    span: tuple[float, float]
    gain: tuple[float, ...]

    @property
    def margin(self) -> int:
        """Texels beyond a window on which its shade depends."""
        return MARGIN

    @classmethod
    def of(cls, texture: Windowed, path: Any) -> Shade:
        """Find the shade of a texture in some windows of it.

        Raises
        ------
        InputError
            The texels are not of two kinds, one darker and bluer than the other.
        """
        from skimage.filters import threshold_otsu

        parts = [
            (_darkness(light), light, valid)
            for light, valid in light_windows(texture)
            if valid.any()
        ]  # fmt: skip
        values = np.concatenate([_smooth(dark, valid)[valid] for dark, _, valid in parts] or [np.zeros(1)])
        if np.ptp(values) < 1e-6:
            raise _unparted(path)
        threshold = float(threshold_otsu(values))  # type: ignore[no-untyped-call]
        above = values > threshold
        share = above.mean()
        between = share * (1 - share) * (values[above].mean() - values[~above].mean()) ** 2
        if min(share, 1 - share) < _LEAST_SHARE or between < _LEAST_PARTED * values.var():
            raise _unparted(path)
        ratios = [_across_border(dark, light, valid, threshold) for dark, light, valid in parts]
        pairs = np.concatenate(ratios)
        gain = np.exp(np.median(pairs, axis=0)) if len(pairs) else np.ones(texture.channels)
        if gain[:3].min() < _LEAST_GAIN or gain[0] < _BLUER * gain[2]:
            raise _unparted(path)
        low, high = np.percentile(values, (1, 99))
        return cls(threshold, (float(low), float(high)), tuple(gain.tolist()))

    def fraction(self, light: npt.NDArray[Any], valid: npt.NDArray[np.bool_]) -> npt.NDArray[np.float32]:
        """Share (h, w) of each texel in the shade, of linear light (h, w, C); the outer `MARGIN` is less sure."""
        dark = _darkness(light)
        inside = _smooth(dark, valid) > self.threshold
        shade = guided(inside.astype(float), np.clip(dark, *self.span))
        fraction: npt.NDArray[np.float32] = np.where(valid, shade, 0.0).astype(np.float32)
        return fraction

    def relit(self, light: npt.NDArray[Any], fraction: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Linear light (h, w, C) without its shade."""
        brighter: npt.NDArray[Any] = light * (1 + fraction[..., np.newaxis] * (np.array(self.gain) - 1))
        return brighter


def _unparted(path: Any) -> InputError:
    return InputError(
        "has no shade that is told from sunlight by being darker and bluer; leave 'shade' out, or draw what to "
        "override",
        file=path,
    )


def _darkness(light: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """Logarithm of blue over red and luminance: high where light is weak and blue."""
    least = np.maximum(light, 0.0) + LEAST_LIGHT
    dark: npt.NDArray[np.float64] = np.log(least[..., 2] / least[..., 0]) - np.log(least[..., :3] @ LUMINANCE)
    return dark


def _smooth(dark: npt.NDArray[Any], valid: npt.NDArray[np.bool_]) -> npt.NDArray[Any]:
    """Means over neighbours with data."""
    from scipy.ndimage import gaussian_filter

    weight = gaussian_filter(valid.astype(float), _SMOOTH)
    smooth: npt.NDArray[Any] = gaussian_filter(np.where(valid, dark, 0.0), _SMOOTH)
    smooth /= np.maximum(weight, 1e-6)
    return smooth


def _across_border(
    dark: npt.NDArray[Any], light: npt.NDArray[Any], valid: npt.NDArray[np.bool_], threshold: float
) -> npt.NDArray[Any]:
    """Logarithms (n, C) of sunlit over shaded light on both sides of the border."""
    from scipy.ndimage import distance_transform_edt, uniform_filter

    inside = _smooth(dark, valid) > threshold
    if inside.all() or not inside.any():
        return np.empty((0, light.shape[-1]))
    within, beyond = distance_transform_edt(inside), distance_transform_edt(~inside)
    logarithm = np.log(np.maximum(light, 0.0) + LEAST_LIGHT)
    sides, weights = [], []
    for distance in (beyond, within):
        ring = ((distance > _NEAR - 1) & (distance <= 2 * _NEAR - 1) & valid).astype(float)
        weight = uniform_filter(ring, 2 * _AROUND + 1)
        mean = [uniform_filter(logarithm[..., c] * ring, 2 * _AROUND + 1) for c in range(light.shape[-1])]
        sides.append(np.stack(mean, axis=-1) / np.maximum(weight, 1e-9)[..., np.newaxis])
        weights.append(weight)
    border = ((within == 1) | (beyond == 1)) & (np.minimum(*weights) > 0.05)
    ratio: npt.NDArray[Any] = (sides[0] - sides[1])[border]
    return ratio


class RelitTexture(TextureFile):
    """A texture whose shade is taken away as it is read."""

    def __init__(self, *arguments: Any, fall: Fall | None = None) -> None:
        """Open an image as `TextureFile` does, and find its shade: by colour, or by how shadows fall where that is
        known.

        Raises
        ------
        InputError
            As `TextureFile`, `Shade.of` and `CastShade.of`, or the colours have no encoding that is known here.
        """
        super().__init__(*arguments)
        if self.encoding not in ("srgb", "linear"):
            raise InputError(
                f"has the colour space '{self.encoding}'; allowed with shade: srgb and linear; say colour_space",
                file=self.path,
            )
        self._drawn: list[tuple[float, Any]] = []
        self._tiles: dict[tuple[int, int], npt.NDArray[np.float32]] = {}
        self._base = _Plain(self)
        self.found: Shade | CastShade = (
            Shade.of(self._base, self.path) if fall is None else CastShade.of(self._base, self.path, fall)
        )

    def draw(self, fraction: float, masks: Any) -> None:
        """Say how much of what polygons cover is in the shade.

        Parameters
        ----------
        fraction : float
            0 to 1.
        masks : callable
            Of a window's top and left and its shape (h, w): which of its texels they cover.
        """
        self._drawn.append((fraction, masks))

    def plain(self, rows: slice, columns: slice) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Colours of a window as the file holds them, and validity."""
        return super().window(rows, columns)

    def shade(self, rows: slice, columns: slice) -> npt.NDArray[np.float32]:
        """Share (h, w) of the texels of a window in the shade."""
        return self._shaded(rows, columns)[1]

    def window(self, rows: slice, columns: slice) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Colours without shade, as the file would hold them, and validity; see `Windowed`."""
        light, fraction, valid = self._shaded(rows, columns)
        return stored_light(self.found.relit(light, fraction), self.encoding, self.dtype), valid

    def _shaded(
        self, rows: slice, columns: slice
    ) -> tuple[npt.NDArray[Any], npt.NDArray[np.float32], npt.NDArray[np.bool_]]:
        if isinstance(self.found, CastShade):
            colours, valid = self.plain(rows, columns)
            light, fraction = linear_light(colours, self.encoding), self._cast(self.found, rows, columns)
        else:
            light, fraction, valid = self._by_colour(self.found, rows, columns)
        for share, masks in self._drawn:
            fraction[masks(rows.start, columns.start, fraction.shape) & valid] = share
        return light, fraction, valid

    def _by_colour(
        self, found: Shade, rows: slice, columns: slice
    ) -> tuple[npt.NDArray[Any], npt.NDArray[np.float32], npt.NDArray[np.bool_]]:
        colours, valid, inner = self._wide(found.margin, rows, columns)
        light = linear_light(colours, self.encoding)
        return light[inner], found.fraction(light, valid)[inner], valid[inner]

    def _cast(self, found: CastShade, rows: slice, columns: slice) -> npt.NDArray[np.float32]:
        """Of tiles that are kept while a band of the texture is read: shadows reach far into their neighbours."""
        fraction = np.empty((rows.stop - rows.start, columns.stop - columns.start), np.float32)
        for row in range(rows.start // _TILE, -(-rows.stop // _TILE)):
            for column in range(columns.start // _TILE, -(-columns.stop // _TILE)):
                top, left = row * _TILE, column * _TILE
                tile = self._tile(found, row, column)
                down = slice(max(rows.start, top), min(rows.stop, top + _TILE))
                across = slice(max(columns.start, left), min(columns.stop, left + _TILE))
                part = tile[down.start - top : down.stop - top, across.start - left : across.stop - left]
                fraction[
                    down.start - rows.start : down.stop - rows.start,
                    across.start - columns.start : across.stop - columns.start,
                ] = part
        return fraction

    def _tile(self, found: CastShade, row: int, column: int) -> npt.NDArray[np.float32]:
        if (row, column) not in self._tiles:
            while len(self._tiles) > self.width // _TILE + 1:
                self._tiles.pop(next(iter(self._tiles)))
            rows = slice(row * _TILE, min((row + 1) * _TILE, self.height))
            columns = slice(column * _TILE, min((column + 1) * _TILE, self.width))
            colours, valid, inner = self._wide(found.margin, rows, columns)
            self._tiles[row, column] = found.fraction(linear_light(colours, self.encoding), valid)[inner]
        return self._tiles[row, column]

    def _wide(
        self, margin: int, rows: slice, columns: slice
    ) -> tuple[npt.NDArray[Any], npt.NDArray[np.bool_], tuple[slice, slice]]:
        """Colours and validity of a window with a margin, and where the window is within."""
        top, left = max(rows.start - margin, 0), max(columns.start - margin, 0)
        wide = slice(top, min(rows.stop + margin, self.height)), slice(left, min(columns.stop + margin, self.width))
        colours, valid = self.plain(*wide)
        inner = slice(rows.start - top, rows.stop - top), slice(columns.start - left, columns.stop - left)
        return colours, valid, inner


class _Plain:
    """A relit texture as its file holds it."""

    def __init__(self, texture: RelitTexture) -> None:
        self.height, self.width, self.channels = texture.height, texture.width, texture.channels
        self.dtype, self.encoding, self.window = texture.dtype, texture.encoding, texture.plain
