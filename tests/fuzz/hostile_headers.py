"""Files whose header, arrays or values are not those of the format."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import h5py
import hdf5_changes as change
import numpy as np
from hostile_cases import ARRAYS, AXES, EITHER, MAIN, PROPERTIES, REFUSE, Case, edited


def cases() -> Iterator[Case]:
    """The cases of this subject; names are unique."""
    for part in (_headers, _missing, _values, _names):
        yield from part()


def _headers() -> Iterator[Case]:
    for kind in ARRAYS:
        for key in ("filetype", "format_version"):
            yield edited(kind, f"without-{key}", REFUSE, lambda file, key=key: file.attrs.pop(key))
    for name, value in {
        "of-the-major-before": "0.4",
        "of-the-next-major": "2.0",
        "of-a-far-major": "10.0",
        "empty": "",
        "a-number": 1,
        "an-array-of-texts": ["1.0"] * 300,
        "without-value": h5py.Empty("S5"),
        "long": "1.0" + "0" * 40_000,
    }.items():
        verdict = EITHER if name == "long" else REFUSE
        yield edited(
            "atmosphere",
            f"version-{name}",
            verdict,
            lambda file, value=value: change.set_attribute(file, "/", "format_version", value),
        )
    for name, value in {
        "of-another": "band",
        "an-array-of-texts": ["htt"] * 400,
        "numbers": np.arange(500.0),
        "long": "h" * 50_000,
        "without-value": h5py.Empty("S3"),
        "null": h5py.Empty(h5py.string_dtype()),
    }.items():
        yield edited(
            "surface",
            f"filetype-{name}",
            REFUSE,
            lambda file, value=value: change.set_attribute(file, "/", "filetype", value),
        )
    for count, name in ((400, "an-array-of-fixed-texts"), (0, "not-UTF-8")):
        text = b"band" if count else change.UNREADABLE_TEXT
        yield edited(
            "band",
            f"filetype-{name}",
            REFUSE,
            lambda file, text=text, count=count: change.set_fixed_text(file, "/", "filetype", text, count),
        )


def _missing() -> Iterator[Case]:
    for kind, arrays in ARRAYS.items():
        for name in (*arrays, *AXES[kind], *(["material_name"] if kind == "band" else [])):
            verdict = EITHER if name == "reflectance" else REFUSE  # a mean over the band, which no pixel needs
            yield edited(kind, f"without-{name}", verdict, lambda file, name=name: file.pop(name))


def _values() -> Iterator[Case]:
    for kind, arrays in ARRAYS.items():
        for name in arrays:
            for word, value in (("nan", np.nan), ("inf", np.inf), ("negative", -1.0)):
                if word != "inf" or name == MAIN[kind]:
                    yield edited(
                        kind, f"{word}-in-{name}", REFUSE, lambda file, n=name, v=value: change.set_middle(file, n, v)
                    )
    yield edited("surface", "absolute-zero", REFUSE, lambda file: change.set_middle(file, "temperature", 0.0))
    for name in PROPERTIES[:2]:
        yield edited("band", f"{name}-above-1", REFUSE, lambda file, name=name: change.set_middle(file, name, 1.5))
    for kind, name in (("surface", "temperature"), ("atmosphere", "effective_radius")):
        yield edited(kind, f"{name}-unwritten", REFUSE, lambda file, name=name: _unwritten(file, name))


def _unwritten(file: h5py.File, name: str) -> None:
    values = file[name]
    change.replace(file, name, shape=values.shape, dtype=values.dtype, chunks=values.shape)


def _names() -> Iterator[Case]:
    text = h5py.string_dtype()
    lists: dict[str, Any] = {
        "more-than-codes": [*(f"other_{k}" for k in range(500)), "asphalt_road", "grass_green"],
        "fewer-than-codes": ["asphalt_road"],
        "none": np.array([], object),
    }
    for word, value in lists.items():
        yield edited(
            "band", f"names-{word}", REFUSE, lambda f, v=value: change.replace(f, "material_name", v, dtype=text)
        )
    yield edited("band", "names-of-numbers", REFUSE, lambda f: change.replace(f, "material_name", np.arange(2.0)))
    yield edited("band", "names-not-UTF-8", REFUSE, lambda f: _raw_names(f, [change.UNREADABLE_TEXT] * 2))
    yield edited("band", "names-null", REFUSE, lambda f: change.replace(f, "material_name", shape=(2,), dtype=text))
    yield edited("band", "names-twice-the-same", REFUSE, lambda f: _raw_names(f, [b"grass_green"] * 2))
    yield edited("band", "name-of-a-megabyte", EITHER, lambda f: _raw_names(f, [b"asphalt_road", b"g" * 1_000_000]))
    yield edited("band", "names-without-space", REFUSE, lambda f: change.replace(f, "material_name", h5py.Empty(text)))


def _raw_names(file: h5py.File, names: list[bytes]) -> None:
    change.replace(file, "material_name", np.array(names, object), dtype=h5py.string_dtype())
