"""Cast shade of a photograph: where it lies, and how much brighter the photograph were without it.

Shade is lit by the sky alone: darker than sunlit ground, and bluer. Where both together part the texels into two kinds,
the border between them runs along shadows, and what lies on either side of it is mostly of one material: the ratio of
both sides, by channel, is the gain that takes the shade away.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.features.colour import to_linear
from skyshine.tmm.images.texture import TextureFile, Windowed

_LEAST_LIGHT = 2e-3  # of white: where sensors and compression leave no ratio of channels
_SMOOTH = 1.0  # texels: standard deviation of the filter before the two kinds are told
_RADIUS = 6  # texels of the guided filter
_EDGE = 0.02  # variance of the logarithm below which the guided filter takes no edge: a seventh of the light
_LEAK = 0.05  # of the guided filter, that is taken for none and, likewise, for all
_NEAR = 3  # texels from the border, over as many more, in which both sides are compared
_AROUND = 6  # texels over which a side is averaged
MARGIN = 2 * _RADIUS + 4  # texels beyond a window on which its shade depends
_WINDOW, _WINDOWS = 512, 16  # texels and number of the windows in which the two kinds are found
_LUMINANCE = (0.2126, 0.7152, 0.0722)  # of linear Rec. 709
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
            for light, valid in _windows(texture)
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
        shade = _guided(inside.astype(float), np.clip(dark, *self.span))
        shade = np.clip((shade - _LEAK) / (1 - 2 * _LEAK), 0.0, 1.0)
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


def linear_light(colours: npt.NDArray[Any], encoding: str) -> npt.NDArray[np.float64]:
    """Linear light (h, w, C) of a window's colours; near infrared is linear as it is stored."""
    light: npt.NDArray[np.float64] = np.empty(colours.shape)
    flat = colours.reshape(-1, colours.shape[-1])
    light[..., :3] = to_linear(flat[:, :3], encoding).reshape(*colours.shape[:2], 3)
    if colours.shape[-1] > 3:
        scale = np.iinfo(colours.dtype).max if colours.dtype.kind == "u" else 1.0
        light[..., 3:] = colours[..., 3:] / np.float64(scale)
    return np.nan_to_num(light, posinf=0.0, neginf=0.0)


def _windows(texture: Windowed) -> Iterator[tuple[npt.NDArray[Any], npt.NDArray[np.bool_]]]:
    """Linear light and validity of windows spread over a texture; all of a small one."""
    rows, columns = (max(length // _WINDOW, 1) for length in (texture.height, texture.width))
    places = [(row, column) for row in range(rows) for column in range(columns)]
    for number in np.unique(np.linspace(0, len(places) - 1, min(_WINDOWS, len(places))).astype(int)):
        row, column = places[number]
        top, left = row * texture.height // rows, column * texture.width // columns
        bottom, right = (row + 1) * texture.height // rows, (column + 1) * texture.width // columns
        colours, valid = texture.window(slice(top, bottom), slice(left, right))
        yield linear_light(colours, texture.encoding), valid.copy()


def _darkness(light: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """Logarithm of blue over red and luminance: high where light is weak and blue."""
    least = np.maximum(light, 0.0) + _LEAST_LIGHT
    dark: npt.NDArray[np.float64] = np.log(least[..., 2] / least[..., 0]) - np.log(least[..., :3] @ _LUMINANCE)
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
    logarithm = np.log(np.maximum(light, 0.0) + _LEAST_LIGHT)
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


def _guided(mask: npt.NDArray[Any], guide: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """A mask with the edges of its guide."""
    from scipy.ndimage import uniform_filter

    def mean(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        filtered: npt.NDArray[Any] = uniform_filter(values, 2 * _RADIUS + 1)
        return filtered

    of_guide, of_mask = mean(guide), mean(mask)
    slope = (mean(guide * mask) - of_guide * of_mask) / (mean(guide * guide) - of_guide**2 + _EDGE)
    offset = of_mask - slope * of_guide
    filtered: npt.NDArray[Any] = mean(slope) * guide + mean(offset)
    return filtered


class RelitTexture(TextureFile):
    """A texture whose shade is taken away as it is read."""

    def __init__(self, *arguments: Any) -> None:
        """Open an image as `TextureFile` does, and find its shade.

        Raises
        ------
        InputError
            As `TextureFile` and `Shade.of`, or the colours have no encoding that is known here.
        """
        super().__init__(*arguments)
        if self.encoding not in ("srgb", "linear"):
            raise InputError(
                f"has the colour space '{self.encoding}'; allowed with shade: srgb and linear; say colour_space",
                file=self.path,
            )
        self._drawn: list[tuple[float, Any]] = []
        self._base = _Plain(self)
        self.found = Shade.of(self._base, self.path)

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
        return _stored(self.found.relit(light, fraction), self.encoding, self.dtype), valid

    def _shaded(
        self, rows: slice, columns: slice
    ) -> tuple[npt.NDArray[Any], npt.NDArray[np.float32], npt.NDArray[np.bool_]]:
        top, left = max(rows.start - MARGIN, 0), max(columns.start - MARGIN, 0)
        wide = slice(top, min(rows.stop + MARGIN, self.height)), slice(left, min(columns.stop + MARGIN, self.width))
        colours, valid = self.plain(*wide)
        light = linear_light(colours, self.encoding)
        fraction = self.found.fraction(light, valid)
        inner = slice(rows.start - top, rows.stop - top), slice(columns.start - left, columns.stop - left)
        light, fraction, valid = light[inner], fraction[inner], valid[inner]
        for share, masks in self._drawn:
            fraction[masks(rows.start, columns.start, fraction.shape) & valid] = share
        return light, fraction, valid


class _Plain:
    """A relit texture as its file holds it."""

    def __init__(self, texture: RelitTexture) -> None:
        self.height, self.width, self.channels = texture.height, texture.width, texture.channels
        self.dtype, self.encoding, self.window = texture.dtype, texture.encoding, texture.plain


def _stored(light: npt.NDArray[Any], encoding: str, dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    """Linear light (h, w, C) as a file of this encoding and type holds it."""
    values = light
    if encoding == "srgb":  # IEC 61966-2-1; near infrared is stored as it is
        colours = light[..., :3]
        bent = np.where(
            colours > 0.0031308, 1.055 * np.maximum(colours, 0.0031308) ** (1 / 2.4) - 0.055, 12.92 * colours
        )
        values = np.concatenate([bent, light[..., 3:]], axis=-1)
    if dtype.kind == "f":
        return values.astype(dtype)
    limit = np.iinfo(dtype).max
    stored: npt.NDArray[Any] = np.rint(np.clip(values, 0.0, 1.0) * limit).astype(dtype)
    return stored
