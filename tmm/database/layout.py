"""What a ``.tmm.h5`` database contains.

``/materials`` (codes, names), ``/usage``, ``/quality``, ``/composites``, ``/provenance`` and, for each mip level,
``/levels/k`` with ``code``, ``mix_code`` and ``mix_weight``, where shade was found also ``shade``; level 0 also has
``confidence`` and, where it has a threshold, ``typicality``.
"""

from __future__ import annotations

import zlib
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt
import yaml

from skyshine.schemas.hdf5 import Axis, Group, Header, Streamed, Variable
from skyshine.schemas.hdf5_chunks import ChunkWriter, Packing
from skyshine.tmm.database.levels import PERCENT, WEIGHT_TOTAL
from skyshine.tmm.job.model import TextureJob

FILETYPE = "tmm"
CHUNK = 256  # texels of a side of an HDF5 chunk
# Steps of what is stored. A byte for each would keep 256 steps, whose noise no filter compresses: 7 and 14 MB of a
# photograph of 4096 x 4096 texels. With these steps, which floats have with all but their first bits 0, 4 and 2 MB.
CONFIDENCE_STEPS = 64
SHADE_TOTAL = 255  # shade of a texel that lies in the shade as a whole
TYPICALITY_RATIO, LEAST_TYPICALITY = 4, 4.0**-4
# Data in runs, coded as runs alone, are as small as searched patterns, in a third of the time. With level 6 for
# mixtures a photograph of 4096 x 4096 texels takes 5.2 MB in place of 6.3, and 0.25 s of 3 more; with it for confidence
# 0.3 MB less and 0.3 s more.
RUNS, PATTERNS, FAST = Packing(1, zlib.Z_RLE), Packing(1), Packing(3)
PACKINGS = {
    "code": RUNS,
    "mix_code": FAST,
    "mix_weight": FAST,
    "confidence": PATTERNS,
    "typicality": RUNS,
    "shade": PATTERNS,
}


def texture_header(job: TextureJob, library_version: str) -> Header:
    """Root attributes of the database of a texture."""
    text = yaml.safe_dump(job.model_dump(mode="json"), sort_keys=False, allow_unicode=True, default_flow_style=None)
    return Header(FILETYPE, f"materials {library_version}", text, f"Materials of the texture {job.name}")


def code_axis(codes: npt.NDArray[np.uint16]) -> Axis:
    """The axis of materials by their codes (K,), ascending."""
    return Axis(codes, "1", "material code")


def materials_layout(codes: npt.NDArray[np.uint16], names: tuple[str, ...]) -> Group:
    """The layout of the materials: codes (K,) and names."""
    named = Variable(("material",), np.array(names, dtype=object), "1", "material name")
    return Group({"material": code_axis(codes)}, {"name": named})


def usage_layout(
    codes: npt.NDArray[np.uint16], share: npt.NDArray[np.float64], texels: int, with_data: int, with_material: int
) -> Group:
    """The layout of the shares (K,) of the texels with data that have each material, and the counts of texels."""
    name = "share of the texels with data that have the material"
    counts = {"texels": texels, "texels_with_data": with_data, "texels_with_material": with_material}
    variables = {"share": Variable(("material",), share, "1", name)}
    return Group({"material": code_axis(codes)}, variables, attributes=counts)


def _component_axis() -> Axis:
    return Axis(np.arange(3, dtype=np.uint8), "1", "rank of the component, largest share first")


def composite_layout(components: npt.NDArray[Any], weights: npt.NDArray[Any]) -> Group:
    """The layout of distinct mixtures: codes (N, 3) and weights (N, 3) in percent."""
    number = Axis(np.arange(len(components), dtype=np.int32), "1", "number of the mixture")
    dims = ("composite", "component")
    return Group(
        {"composite": number, "component": _component_axis()},
        {
            "code": Variable(dims, components, "1", "material code, 0 where unused"),
            "weight": Variable(dims, weights, "percent", "share of the material", {"total": PERCENT}),
        },
    )


def level_layout(
    k: int, size: tuple[int, int], height: int, width: int, *, shade: bool = False, typicality: bool = False
) -> Group:
    """The layout of a level, with or without layers of shade and typicality; its arrays are written as they come."""
    axes = {
        "y": Axis(_centres(height, size[0]), "1", "row of the texel's centre, in texels of level 0"),
        "x": Axis(_centres(width, size[1]), "1", "column of the texel's centre, in texels of level 0"),
        "component": _component_axis(),
    }
    plane, mixed, chunk = ("y", "x"), ("y", "x", "component"), (CHUNK, CHUNK)
    codes, parts = Streamed(size, np.uint16), Streamed((*size, 3), np.uint16)
    weights = {"total": WEIGHT_TOTAL}
    variables = {
        "code": Variable(plane, codes, "1", "material code of the largest share, 0 for none", chunks=chunk),
        "mix_code": Variable(mixed, parts, "1", "material codes of the mixture", chunks=(*chunk, 3)),
        "mix_weight": Variable(
            mixed, parts, "1", "shares of the mixture; they sum to `total`", weights, chunks=(*chunk, 3)
        ),
    }
    if shade:
        variables["shade"] = Variable(
            plane,
            Streamed(size, np.uint8),
            "1",
            "share of the texel in cast shade, in parts of `total`",
            {"total": SHADE_TOTAL},
            chunks=chunk,
        )
    if k == 0:
        values = Streamed(size, np.float32)
        name = "probability that the material is right: its posterior, averaged over the box and calibrated"
        step = {"step": 1 / CONFIDENCE_STEPS}
        variables["confidence"] = Variable(plane, values, "1", name, step, chunks=chunk)
    if k == 0 and typicality:
        name = "share of the most alike material's boxes (texels, without seeds) that lie farther from their mean"
        ratio = {"ratio": TYPICALITY_RATIO, "least": LEAST_TYPICALITY}
        variables["typicality"] = Variable(plane, values, "1", name, ratio, chunks=chunk)
    return Group(axes, variables)


def chunk_writers(group: h5py.Group) -> dict[str, ChunkWriter]:
    """What writes the arrays of a level, by their names."""
    return {name: ChunkWriter(group[name], packing) for name, packing in PACKINGS.items() if name in group}


def in_steps(confidence: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Confidence as it is stored: the nearest multiple of 1 / CONFIDENCE_STEPS."""
    stored: npt.NDArray[np.float32] = np.rint(confidence * np.float32(CONFIDENCE_STEPS))
    stored /= np.float32(CONFIDENCE_STEPS)
    return stored


def in_ratios(typicality: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Typicality as it is stored: the nearest power of TYPICALITY_RATIO, right to a factor of 2; 0 where it is below
    half of LEAST_TYPICALITY.
    """
    # From 2^(2k - 1) to below 2^(2k + 1) it is 4^k: in IEEE 754 an odd exponent in place of the even one below it, for
    # exponents are kept 127 larger, and no further bits.
    bits = np.ascontiguousarray(typicality, np.float32).view(np.uint32) & np.uint32(0x7F000000)
    bits |= np.uint32(0x00800000)
    stored: npt.NDArray[np.float32] = bits.view(np.float32)
    stored *= typicality >= np.float32(LEAST_TYPICALITY / 2)
    return stored


def _centres(length: int, parts: int) -> npt.NDArray[Any]:
    return (np.arange(parts) + 0.5) * (length / parts)
