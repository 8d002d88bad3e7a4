"""Conditions on a texture database; a file that fails one is refused with one line."""

from __future__ import annotations

import os
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.database.layout import SHADE_TOTAL
from skyshine.tmm.database.levels import COMPONENTS, WEIGHT_TOTAL, level_sizes

ROOT = ("filetype", "format_version", "data_version", "generator", "job", "content_sha256")
PROVENANCE = ("texture", "texture_sha256", "width", "height", "pixel_type", "encoding")
USAGE = ("texels", "texels_with_data", "texels_with_material")
TESTED = ("tested_texels", "seed_texels")
MEASURED = (
    "overall_accuracy",
    "mean_iou",
    "calibration_error",
    "folds",
    "expected_accuracy",
    "separate_places",
    "tested_places",
)
PLANES = {"code": np.uint16, "mix_code": np.uint16, "mix_weight": np.uint16}
FINEST = {"confidence": np.float32, "typicality": np.float32}  # the latter where it has a threshold
SHADE = {"shade": np.uint8}  # on all levels or on none


def check_parts(file: h5py.File, path: str | os.PathLike[str]) -> None:
    """Refuse a texture database that lacks a part, or whose parts do not fit each other.

    The large arrays are not read; `check_values` looks at what is read of them.
    Raises InputError.
    """
    _require(path, file, "", ROOT)
    _require(path, file["provenance"], "provenance", PROVENANCE)
    _require(path, file["usage"], "usage", USAGE)
    measured = MEASURED if "quality/confusion" in file else ()
    _require(path, file["quality"], "quality", (*TESTED, *measured))
    _check_materials(file, path)
    height, width = (int(file["provenance"].attrs[name]) for name in ("height", "width"))
    if height < 1 or width < 1:
        raise _damaged(path, f"the texture is {width} x {height}")
    sizes = level_sizes(height, width)
    if sorted(file["levels"]) != sorted(str(k) for k in range(len(sizes))):
        raise _damaged(path, f"it does not have the levels 0 to {len(sizes) - 1}")
    shade = SHADE if "levels/0/shade" in file else {}
    finest = {name: kind for name, kind in FINEST.items() if name != "typicality" or f"levels/0/{name}" in file}
    for k, size in enumerate(sizes):
        for name, kind in (PLANES | (finest if k == 0 else {}) | shade).items():
            plane = file[f"levels/{k}/{name}"]
            shape = (*size, COMPONENTS) if name.startswith("mix") else size
            if plane.shape != shape or plane.dtype != kind:
                raise _damaged(
                    path, f"levels/{k}/{name} is {plane.dtype} {plane.shape}; allowed: {kind.__name__} {shape}"
                )
            if name in SHADE and not np.array_equal(plane.attrs.get("total"), SHADE_TOTAL):
                raise _damaged(path, f"levels/{k}/{name} does not state its total, {SHADE_TOTAL}")


def _check_materials(file: h5py.File, path: str | os.PathLike[str]) -> None:
    codes, names = file["materials/material"][()], file["materials/name"].asstr()[()].tolist()
    if (
        codes.dtype.kind != "u"
        or codes.ndim != 1
        or not len(codes)
        or (codes == 0).any()
        or (np.diff(codes.astype(int)) <= 0).any()
    ):
        raise _damaged(path, "the codes of its materials do not ascend from 1")
    if len(names) != len(codes) or "" in names or len(set(names)) != len(names):
        raise _damaged(path, "its materials do not have one name each")
    share = file["usage/share"][()]
    if share.shape != codes.shape or not ((share >= 0) & (share <= 1)).all() or share.sum() > 1 + 1e-3:
        raise _damaged(path, "the shares of its materials are not between 0 and 1")


def _require(path: str | os.PathLike[str], group: h5py.Group, name: str, attributes: tuple[str, ...]) -> None:
    for key in attributes:
        if key not in group.attrs:
            raise _damaged(path, f"lacks the attribute '{key}' of {name or 'the file'}")
    for key, value in group.attrs.items():
        if np.asarray(value).dtype.kind == "f" and not np.isfinite(value).all():
            raise _damaged(path, f"the attribute '{key}' of {name or 'the file'} is not finite")


def check_values(
    path: str | os.PathLike[str], name: str, values: npt.NDArray[Any], valid_codes: npt.NDArray[np.bool_]
) -> None:
    """Refuse values of a level that no texture has.

    Raises InputError: a code is not in the table of materials, weights do not sum to their total, or a probability is
    not one.

    name : str; path of the array in the file.
    values : array; some rows of it.
    valid_codes : (65536,) bool; which codes are those of materials, or 0.
    """
    plane = name.rpartition("/")[2]
    if not name.startswith("levels/"):
        return
    if plane in ("code", "mix_code") and not valid_codes[values].all():
        code = int(values[~valid_codes[values]].flat[0])
        raise _damaged(path, f"{name} has the code {code}, which is not in the table of its materials")
    if plane == "mix_weight" and (values.sum(axis=-1, dtype=np.int64) != WEIGHT_TOTAL).any():
        raise _damaged(path, f"the weights of {name} do not sum to {WEIGHT_TOTAL}")
    if plane in FINEST and not ((values >= 0) & (values <= 1)).all():
        raise _damaged(path, f"{name} has values that are not between 0 and 1")


def _damaged(path: str | os.PathLike[str], what: str) -> InputError:
    return InputError(f"is damaged ({what}); build it again", file=path)
