"""Random extreme classifiers and textures: one seed per material, one texel, one colour, grey, NaN."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import tifffile

from skyshine.mat.tables.verify import problems
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError
from skyshine.tmm import map_texture, open_tmm, write_texture
from skyshine.tmm.classify.gaussian import fit
from skyshine.tmm.job.model import TextureJob

_MATERIALS = ("asphalt_road", "conifer", "grass_green", "concrete", "sand_desert")
_LARGEST = 90  # texels along a side


def classifier_case(generator: np.random.Generator) -> dict[str, tuple[float, float]]:
    """Materials of one seed, of one colour, of colours on a line; posteriors of any colour."""
    count = int(generator.integers(1, 12))
    seeds, number = [], []
    for material in range(count):
        size = int(generator.choice([1, 2, 3, 500]))
        spread = float(generator.choice([0.0, 1e-9, 1.0, 60.0]))
        centre = generator.uniform([0, -100, -100], [100, 100, 100])
        if generator.random() < 0.3:
            centre = np.array([50.0, 0.0, 0.0])  # several materials of the very same colour
        across = generator.normal(size=(1, 3)) if generator.random() < 0.3 else np.ones((1, 3))
        seeds.append(
            centre
            + spread * generator.normal(size=(size, 1 if across.any() and generator.random() < 0.5 else 3)) * across
        )
        number += [material] * size
    names = tuple(f"m{k}" for k in range(count))
    prior = {name: float(np.exp(generator.uniform(-20, 20))) for name in names}
    model = fit(np.concatenate(seeds), np.array(number), names, prior)
    colours = generator.uniform([-10, -150, -150], [110, 150, 150], (200, 3))
    log = model.log_posterior(model.squared_distance(colours))
    return {
        "not finite": (float(np.count_nonzero(np.isnan(log) | (log == np.inf))), 0.0),
        "posterior off 1": (float(np.abs(np.exp(log).sum(axis=0) - 1).max()), 1e-9),
    }


def texture_case(generator: np.random.Generator) -> dict[str, tuple[float, float]]:
    """A texture of one texel to several windows, in any type, mapped in any of the ways that need no training set, and
    read back.
    """
    library = load_library()
    with tempfile.TemporaryDirectory() as folder:
        height, width = (int(generator.choice([1, 2, 3, int(generator.integers(4, _LARGEST))])) for _ in range(2))
        pixels = _random_pixels(generator, height, width)
        tifffile.imwrite(Path(folder) / "drawn.tif", pixels, photometric="rgb" if pixels.shape[2] > 2 else "minisblack")
        job = TextureJob.model_validate({"image": "drawn.tif", **_random_way(generator, height, width)})
        try:
            mapped = map_texture(job, Path(folder), library)
            write_texture(mapped, Path(folder) / "drawn.tmm.h5")
        except InputError as error:
            return {"refused in more than a line": (float("\n" in str(error)), 0.0)}
        wrong = problems(Path(folder) / "drawn.tmm.h5")
        with open_tmm(Path(folder) / "drawn.tmm.h5") as file:
            code, confidence = (file.array(f"levels/0/{name}").astype(float) for name in ("code", "confidence"))
    allowed = np.append(mapped.codes, 0)
    return {
        "not finite": (float(np.count_nonzero(~np.isfinite(confidence))), 0.0),
        "problems of the database": (float(len(wrong)), 0.0),
        "codes that no material has": (float(np.count_nonzero(~np.isin(code, allowed))), 0.0),
        "confidence outside 0 to 1": (float(max(0.0, -confidence.min(), confidence.max() - 1)), 1e-6),
    }


def _random_pixels(generator: np.random.Generator, height: int, width: int) -> npt.NDArray[Any]:
    kind = str(generator.choice(["uint8", "uint16", "float32"]))
    channels = int(generator.choice([1, 3, 4]))
    top = np.iinfo(kind).max if kind != "float32" else 1.0
    pixels = generator.uniform(0, top, (height, width, channels))
    look = generator.choice(["noise", "flat", "two", "black", "white"])
    if look == "flat":
        pixels[:] = pixels[0, 0]
    elif look == "two":
        pixels[:, : width // 2] = pixels[0, 0]
    elif look in ("black", "white"):
        pixels[:] = 0 if look == "black" else top
    if kind == "float32":
        bad = generator.random((height, width)) < generator.choice([0.0, 0.1])
        pixels[bad] = generator.choice([np.nan, np.inf, -1.0, 1e30])
    typed: npt.NDArray[Any] = pixels.astype(kind)
    return typed


def _random_way(generator: np.random.Generator, height: int, width: int) -> dict[str, Any]:
    """One of the ways of a texture job, with polygons of one texel to the whole texture."""
    way = str(generator.choice(["material", "seeds", "clusters", "palette", "rules"]))
    chosen = [
        str(name)
        for name in generator.choice(_MATERIALS, int(generator.integers(1, len(_MATERIALS) + 1)), replace=False)
    ]
    settings = {
        "radius": int(generator.choice([0, 1, 8, 127])),
        "confidence_threshold": float(generator.choice([0.0, 0.5, 1.0])),
    }
    if way == "material":
        return {"material": chosen[0]}
    if way == "seeds":
        polygons = {}
        for name in chosen:
            corners = generator.uniform(0, [width, height], (int(generator.choice([1, 3, 6])), 2))
            polygons[name] = [np.minimum(corners, [width - 0.5, height - 0.5]).tolist()]
        return {"seeds": {"polygons": polygons}, "classifier": settings}
    if way == "clusters":
        count = int(generator.integers(1, 6))
        return {
            "clusters": {"count": count, "names": {1: chosen[0]}, "random_seed": int(generator.integers(100))},
            "classifier": settings,
        }
    if way == "palette":
        colours = {
            f"#{int(value):06X}": name
            for value, name in zip(generator.integers(0, 1 << 24, len(chosen)), chosen, strict=True)
        }
        return {"palette": {"colours": colours, "match": str(generator.choice(["exact", "nearest"]))}}
    ranges = [
        {"material": name, "when": {"lightness": {"at_least": 100.0 * k / len(chosen)}}}
        for k, name in enumerate(chosen)
    ]
    return {"rules": {"rules": ranges}}
