"""Bad and unusual files in what they hold by wavelength: spectra of a band, and shares of channels."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import h5py
import hdf5_changes as change
import numpy as np
from hostile_cases import EQUAL, REFUSE, Case, edited

WAVELENGTH = "band_wavelength"
# Arrays of each kind of file, with values that they may not hold, and those whose rows sum to 1.
OUTSIDE: dict[str, dict[str, tuple[float, ...]]] = {
    "band": {"reflectance_spectrum": (-0.1, 1.1), "emission_share": (-0.1, 1.1)},
    "atmosphere": {"thermal_wavelength_share": (-0.1, 1.1), "source_wavelength_share": (-0.1, 1.1)},
}
SHARES = {"band": ("emission_share",), "atmosphere": ("thermal_wavelength_share", "source_wavelength_share")}
ROWS = {"band": "planck_temperature", "atmosphere": "channel"}  # axis of the rows of the shares
FAR = 3e-5  # from 1, of the sum of a row: beyond rounding
CLAMP = ("out_of_range", "clamp")


def cases() -> Iterator[Case]:
    """The cases of this subject; names are unique."""
    for part in (_missing, _values, _sums, _axes, _arrays, _bands, _unusual):
        yield from part()


def _missing() -> Iterator[Case]:
    for kind, arrays in OUTSIDE.items():
        for name in (*arrays, WAVELENGTH, ROWS[kind]):
            if name != "channel":  # another subject has it
                yield edited(kind, f"without-{name}", REFUSE, lambda file, n=name: file.pop(n))


def _values() -> Iterator[Case]:
    for kind, arrays in OUTSIDE.items():
        for name, outside in arrays.items():
            for value in (np.nan, np.inf):
                yield edited(
                    kind, f"{name}-of-{value:g}", REFUSE, lambda f, n=name, v=value: change.set_middle(f, n, v)
                )
            for value in outside:
                yield edited(kind, f"{name}-of-{value:g}", REFUSE, lambda f, n=name, v=value: _swing(f, n, v))


def _swing(file: h5py.File, name: str, value: float) -> None:
    """Write one value of an array, and take it from its neighbour: the sum of the row stays."""
    values = file[name][()]
    row = values[values.shape[0] // 2]
    row[:2] = value, row[:2].sum() - value
    file[name][...] = values


def _sums() -> Iterator[Case]:
    for kind, names in SHARES.items():
        for name in names:
            for word, factor in (("heavy", 1 + FAR), ("light", 1 - FAR), ("zero", 0.0), ("double", 2.0)):
                yield edited(kind, f"{name}-{word}", REFUSE, lambda f, n=name, by=factor: _scale(f, n, by))
            yield edited(kind, f"{name}-all-zero", REFUSE, lambda f, n=name: f[n].write_direct(f[n][()] * 0))


def _scale(file: h5py.File, name: str, factor: float) -> None:
    """Multiply the last row of an array."""
    values = file[name][()]
    values[-1] *= factor
    file[name][...] = values


def _axes() -> Iterator[Case]:
    nodes: dict[str, Callable[[np.ndarray], Any]] = {
        "short": lambda n: n[:1],
        "long": lambda n: np.append(n, n[-1:] + 1),
        "descending": lambda n: n[::-1],
        "with-nan": lambda n: np.append(n[:-1], np.nan),
        "empty": lambda n: n[:0],
        "in-two-dimensions": lambda n: n[np.newaxis],
        "of-singles": lambda n: n.astype(np.float32),
    }
    for kind in OUTSIDE:
        for name in {WAVELENGTH, ROWS[kind]} - {"channel"}:
            for word, of in nodes.items():
                yield edited(
                    kind, f"{name}-{word}", REFUSE, lambda f, a=name, of=of: change.replace(f, a, of(f[a][()]))
                )
            for word, value in (("exact", "exact"), ("cubic", "cubic"), ("a-number", 3)):
                yield edited(
                    kind,
                    f"{name}-ruled-{word}",
                    REFUSE,
                    lambda f, a=name, v=value: change.set_attribute(f, a, "interpolation", v),
                )
            yield edited(kind, f"{name}-periodic", REFUSE, lambda f, a=name: change.set_attribute(f, a, "period", 1e3))


def _arrays() -> Iterator[Case]:
    shapes: dict[str, Callable[[np.ndarray], Any]] = {
        "as-doubles": lambda v: v.astype(np.float64),
        "as-integers": lambda v: v.astype(np.int32),
        "with-an-axis-more": lambda v: v[..., np.newaxis],
        "of-one-row": lambda v: v[0],
        "cut": lambda v: v[..., :1],
        "empty": lambda v: v[..., :0],
        "transposed": lambda v: v.T,
        "without-space": lambda v: h5py.Empty("f4"),
    }
    for kind, arrays in OUTSIDE.items():
        for name in arrays:
            for word, of in shapes.items():
                yield edited(
                    kind, f"{name}-{word}", REFUSE, lambda f, a=name, of=of: change.replace(f, a, of(f[a][()]))
                )
            yield edited(kind, f"{name}-without-scales", REFUSE, lambda f, a=name: f[a].attrs.pop("DIMENSION_LIST"))
            yield edited(kind, f"{name}-scales-swapped", REFUSE, lambda f, a=name: _swapped(f, a))
            yield edited(kind, f"{name}-in-another-file", REFUSE, lambda f, a=name: change.as_external_link(f, a))
            yield edited(kind, f"{name}-kept-elsewhere", REFUSE, lambda f, a=name: change.as_external(f, a))
            yield edited(kind, f"{name}-a-group", REFUSE, lambda f, a=name: (f.pop(a), f.create_group(a)))


def _swapped(file: h5py.File, name: str) -> None:
    change.replace(file, name, file[name][()], scales=change.scales_of(file, name)[::-1])


def _bands() -> Iterator[Case]:
    """Wavelengths that are not those of the other file: seen where a scene has both."""
    for word, of in (("shifted", lambda n: n + 1e-3), ("stretched", lambda n: n * (1 + 1e-5))):
        yield edited("atmosphere", f"of-a-band-{word}", REFUSE, lambda f, of=of: _move(f, of))
    yield edited("atmosphere", "of-a-band-rounded", EQUAL, lambda f: _move(f, lambda n: n * (1 + 1e-8)))
    yield edited("atmosphere", "of-fewer-wavelengths", REFUSE, _fewer)


def _move(file: h5py.File, of: Callable[[np.ndarray], np.ndarray]) -> None:
    file[WAVELENGTH][...] = of(file[WAVELENGTH][()])


def _fewer(file: h5py.File) -> None:
    """Sound shares of the first three wavelengths alone."""
    shares = {}
    for name in SHARES["atmosphere"]:
        values = file[name][()].astype(float)[:, :3]
        shares[name] = (values / values.sum(axis=1, keepdims=True)).astype(np.float32)
    change.replace(file, WAVELENGTH, file[WAVELENGTH][()][:3])
    for name, values in shares.items():
        change.replace(file, name, values)


def _unusual() -> Iterator[Case]:
    for kind, arrays in OUTSIDE.items():
        for name in arrays:
            yield edited(kind, f"{name}-big-endian", EQUAL, lambda f, a=name: _retype(f, a, ">f4"))
            yield edited(kind, f"{name}-contiguous", EQUAL, lambda f, a=name: change.replace(f, a, f[a][()]))
        yield edited(kind, f"{WAVELENGTH}-big-endian", EQUAL, lambda f: _retype(f, WAVELENGTH, ">f8"))
        yield edited(kind, f"{WAVELENGTH}-clamped", EQUAL, lambda f: change.set_attribute(f, WAVELENGTH, *CLAMP))
    yield edited(
        "band", "planck_temperature-clamped", EQUAL, lambda f: change.set_attribute(f, "planck_temperature", *CLAMP)
    )


def _retype(file: h5py.File, name: str, kind: str) -> None:
    change.replace(file, name, file[name][()].astype(kind))
