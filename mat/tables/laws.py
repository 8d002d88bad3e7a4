"""The physical laws that the values of a database obey, whatever job it is from."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import h5py
import numpy as np
import numpy.typing as npt

from skyshine.mat.quantities.formulas import BETA_CAP_KM
from skyshine.mat.radiometry.spherical_harmonics import COUNTS, HARMONICS, zonal
from skyshine.mat.tables.atmq import GRID
from skyshine.mat.tables.axes import FOLDED, PERIODIC, AxisRule
from skyshine.mat.tables.band import WAVELENGTH
from skyshine.mat.tables.channel_laws import broken_channel_laws
from skyshine.mat.tables.limits import LIMITS, ROUNDING
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Group
from skyshine.schemas.hdf5_digest import bands, parts

Array = npt.NDArray[np.float64]
Law = Callable[[Group], Iterator[str]]

PATH = ("range", "altitude", "elevation")
TEXEL_ROWS = 256  # texel rows of the arrays of a texture read at a time, which have rows in common
_SPECTRA = {"reflectance_spectrum": ("material", WAVELENGTH), "emission_share": ("planck_temperature", WAVELENGTH)}


def broken_laws(filetype: str, root: Group) -> Iterator[str]:
    """One line for each law that a file breaks; parts that are missing are the layout's matter.

    Parameters
    ----------
    filetype : str
    root : Group
    """
    for law in (broken_rules_of_axes, _limits, *LAWS.get(filetype, ()), _accuracy):
        yield from law(root)


def broken_texture_laws(file: h5py.File) -> Iterator[str]:
    """As `broken_laws`, of a texture, whose arrays may be larger than memory."""
    if "materials/material" in file:
        codes = np.append(0, file["materials/material"][()])
        for name, level in file["levels"].items():
            yield from _level(f"levels/{name}", level, codes)
    if "composites/weight" in file:
        weight = file["composites/weight"]
        sums = weight[()].astype(np.int64).sum(axis=-1)
        total = int(weight.attrs.get("total", 0))
        yield from _where("composites/weight", sums, sums != total, f"sum to {total}")
    if "usage/share" in file:
        share = file["usage/share"][()].astype(float)
        yield from _where("usage/share", share, ~((share >= 0) & (share <= 1 + ROUNDING)), "lie in 0 to 1")
        yield from _where("usage/share", share.sum(), share.sum() > 1 + ROUNDING, "sum to at most 1")


def _level(path: str, level: h5py.Group, codes: npt.NDArray[np.integer]) -> Iterator[str]:
    if "mix_weight" in level and "mix_code" in level and "code" in level:
        total = int(level["mix_weight"].attrs.get("total", 0))
        pieces = (bands(level[plane], TEXEL_ROWS) for plane in ("code", "mix_code", "mix_weight"))
        for code, mix_code, mix_weight in zip(*pieces, strict=False):
            sums = mix_weight.astype(np.int64).sum(axis=-1)
            is_material = np.isin(mix_code, codes)
            problems = [
                *_where(f"{path}/mix_weight", sums, (sums != total) & (sums != 0), f"sum to {total}"),
                *_where(f"{path}/mix_code", mix_code, ~is_material, "name codes of the file's materials"),
                *_where(f"{path}/code", code, code != mix_code[..., 0], "equal the first code of the mixture"),
            ]
            if problems:
                yield from problems
                break
    for name in ("confidence", "typicality"):
        for values in parts(level[name]) if name in level else ():
            if bad := [*_where(f"{path}/{name}", values, ~((values >= 0) & (values <= 1)), "lie in 0 to 1")]:
                yield from bad
                break


def _where(name: str, values: npt.ArrayLike, wrong: npt.ArrayLike, law: str) -> Iterator[str]:
    """The line of a law that some values break."""
    values, wrong = np.asarray(values), np.asarray(wrong)
    if wrong.any():
        index = tuple(int(i) for i in np.argwhere(wrong)[0])
        yield (
            f"{name}: {np.count_nonzero(wrong)} of {wrong.size} values do not {law}; the first is {values[index]:g} at"
            f" {list(index)}"
        )


def _values(root: Group, name: str) -> Array | None:
    variable = root.variables.get(name)
    return None if variable is None or variable.dtype.kind not in "iuf" else np.asarray(variable.data, float)


def broken_rules_of_axes(root: Group) -> Iterator[str]:
    """One line for each axis whose nodes do not fit the rule by which it is read."""
    for name, axis in root.axes.items():
        if "interpolation" not in axis.attributes:
            continue
        try:
            rule = AxisRule.of(name, axis)
        except InputError as error:
            yield error.message
            continue
        low, high = float(rule.nodes[0]), float(rule.nodes[-1])
        if rule.interpolation == PERIODIC and high - low >= rule.period:
            yield f"{name}: the nodes span {high - low:g}; allowed: less than the period {rule.period:g}"
        if rule.interpolation == FOLDED and not 0 <= low <= high <= rule.period / 2:
            yield f"{name}: the nodes span {low:g} to {high:g}; allowed: 0 to half the period {rule.period:g}"
    yield from _harmonics(root)


def _harmonics(root: Group) -> Iterator[str]:
    """Codes of harmonics are those of the format, and as many of both kinds as belong together."""
    names = [name for name in ("harmonic", "zonal_harmonic") if name in root.axes]
    file_codes = [tuple(np.ravel(root.axes[name].values).tolist()) for name in names]
    allowed_codes = [[HARMONICS[:count] if name == "harmonic" else zonal(count) for name in names] for count in COUNTS]
    if names and file_codes not in allowed_codes:
        allowed = " or ".join(" with ".join(str(codes) for codes in pair) for pair in allowed_codes)
        yield f"{' and '.join(names)}: found codes that are not those of the format; allowed: {allowed}"


def _limits(root: Group) -> Iterator[str]:
    for name, limits in LIMITS.items():
        values = _values(root, name)
        if values is not None:
            yield from _where(name, values, limits.outside(values), limits.words)


def _accuracy(root: Group) -> Iterator[str]:
    group = root.groups.get("accuracy", Group())
    for name, variable in group.variables.items():
        values = _values(group, name)
        if values is not None:
            yield from _where(f"accuracy/{name}", values, values < 0, "lie at 0 or above")
        for smaller in ("p95", "rms"):
            if values is not None and name.startswith("maximum"):
                smaller_values = _values(group, name.replace("maximum", smaller))
                if (
                    smaller_values is not None
                    and group.variables[name.replace("maximum", smaller)].dims == variable.dims
                ):
                    wrong = smaller_values > values * (1 + ROUNDING)
                    yield from _where(f"accuracy/{name}", values, wrong, f"reach the {smaller} of the same errors")


def _falls_with_range(root: Group) -> Iterator[str]:
    """Transmittance falls with range where both ends of a step lie in air."""
    beta, valid = _values(root, "beta_star"), _values(root, "valid")
    if beta is None or root.variables["beta_star"].dims != PATH or LIMITS["beta_star"].outside(beta).any():
        return
    span = np.asarray(root.axes[PATH[0]].values, float)
    yield from _where("beta_star over range", span, span < 0, "lie at 0 or above")
    depth = span[:, None, None] / beta  # -ln(transmittance), but for a factor
    # beta* at its cap means that the path contains no air: its depth is a bound, not a value.
    thin = beta[1:] >= BETA_CAP_KM * (1 - ROUNDING)
    grows = (depth[1:] >= depth[:-1] * (1 - ROUNDING)) | thin
    air = True if valid is None or valid.shape != beta.shape else (valid[1:] == 1) & (valid[:-1] == 1)
    yield from _where("beta_star over range", depth[1:], ~grows & air, "give a transmittance that falls with range")


def _mask(root: Group) -> Iterator[str]:
    valid = _values(root, "valid")
    if valid is None:
        return
    yield from _where("valid", valid, (valid != 0) & (valid != 1), "equal 0 or 1")
    if root.variables["valid"].dims == PATH:
        yield from _where("valid", valid[1:], valid[1:] > valid[:-1], "stay 0 beyond the ground")


def _diagnostics(root: Group) -> Iterator[str]:
    group = root.groups.get("diagnostics", Group())
    for name in ("residual", "bound_excess", "iterations"):
        values = _values(group, name)
        if values is not None:
            yield from _where(f"diagnostics/{name}", values, values < 0, "lie at 0 or above")


def _materials(root: Group) -> Iterator[str]:
    axis, names = root.axes.get("material"), root.variables.get("material_name")
    if axis is not None and np.asarray(axis.values).dtype.kind in "iuf":
        codes = np.asarray(axis.values)
        yield from _where("material", codes, (codes < 1) | (codes > 65535), "lie in 1 to 65535")
    if names is not None and names.dtype.kind == "O":
        texts = [str(text) for text in np.ravel(names.data)]
        if len(set(texts)) < len(texts) or "" in texts:
            yield "material_name: a name is empty or occurs twice"


def broken_spectrum_laws(root: Group) -> Iterator[str]:
    """One line for each fault of the spectra of a band: arrays and axes that do not fit, shares that do not sum to 1.

    Parameters
    ----------
    root : Group
    """
    if not set(_SPECTRA) & set(root.variables):
        return  # refused by the layout, or when they are read
    for name, dims in _SPECTRA.items():
        if name not in root.variables:
            yield f"the array '{name}' is missing; a band must contain it"
        elif tuple(root.variables[name].dims) != dims:
            yield f"'{name}' is on the axes {', '.join(root.variables[name].dims)}; allowed: {', '.join(dims)}"
    for name in sorted({dim for dims in _SPECTRA.values() for dim in dims}):
        if name not in root.axes:
            yield f"the axis '{name}' is missing; a band must contain it"
        elif np.any(np.asarray(root.axes[name].attributes.get("period", 0.0)) != 0.0):
            yield f"{name}: found a period; allowed: none"
    shares = _values(root, "emission_share")
    if shares is not None and shares.ndim == 2:
        sums = shares.sum(axis=1)
        yield from _where("emission_share", sums, ~(np.abs(sums - 1) <= ROUNDING), "sum to 1 over the wavelengths")


def _band(root: Group) -> Iterator[str]:
    response = _values(root, "response")
    if response is not None and response.size and abs(response.max() - 1) > ROUNDING:
        yield f"response: the peak is {response.max():g}; allowed: 1"
    radiance = _values(root, "blackbody_radiance")
    if radiance is not None:
        falls = np.diff(radiance) < -ROUNDING * radiance[:-1]
        yield from _where("blackbody_radiance", radiance[1:], falls, "rise with temperature")
    flat, emitted = _values(root, "reflectance"), _values(root, "emissivity")
    if flat is not None and emitted is not None:
        yield from _where("emissivity", emitted, np.abs(emitted + flat - 1) > ROUNDING, "equal 1 - reflectance")
    reflectance, emitted = _values(root, "reflectance_planck"), _values(root, "emissivity_planck")
    if reflectance is not None and emitted is not None:
        yield from _where(
            "emissivity_planck", emitted, emitted + reflectance > 1 + ROUNDING, "stay below 1 - reflectance"
        )


def _classifier(root: Group) -> Iterator[str]:
    colour = root.groups.get("colour", Group())
    covariance, prior = _values(colour, "covariance"), _values(colour, "log_prior")
    if covariance is not None and covariance.ndim == 3 and np.all(np.isfinite(covariance)):
        skew = np.abs(covariance - covariance.swapaxes(1, 2)).max(axis=(1, 2))
        size = np.abs(covariance).max(axis=(1, 2))
        yield from _where("colour/covariance", skew, skew > ROUNDING * size, "form a symmetric matrix")
        smallest = np.linalg.eigvalsh(covariance).min(axis=-1)
        yield from _where("colour/covariance", smallest, ~(smallest > 0), "form a positive definite matrix")
    if prior is not None and not abs(np.exp(prior).sum() - 1) <= 1e-3:
        yield f"colour/log_prior: the probabilities sum to {np.exp(prior).sum():g}; allowed: 1"
    scale = _values(root.groups.get("network", Group()), "scale")
    if scale is not None:
        yield from _where("network/scale", scale, ~(scale > 0), "lie above 0")


def _grid(root: Group) -> Iterator[str]:
    """Tables on five axes: their limits, their mask, and a transmittance that falls with range."""
    if GRID in root.groups:
        for law in (broken_rules_of_axes, _limits, _falls_with_range, _mask, _accuracy):
            yield from (f"{GRID}/{line}" for line in law(root.groups[GRID]))


_ATMOSPHERE: tuple[Law, ...] = (broken_channel_laws, _grid)
LAWS: dict[str, tuple[Law, ...]] = {
    "htt": (_diagnostics, _materials),
    "atmq": _ATMOSPHERE,
    "lunar_atmq": _ATMOSPHERE,
    "band": (_band, broken_spectrum_laws, _materials),
    "tmm-model": (_classifier,),
}
