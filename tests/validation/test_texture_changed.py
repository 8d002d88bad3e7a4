"""The same photograph stored or lit otherwise: how many texels keep their material.

The seeds stay where they are: they are read again on the changed photograph, as a user's job would. The library model
stays as it was trained, on other sheets as they are.
"""

import numpy as np
import pytest
import test_texture_orthophotos as orthophotos
from PIL import Image
from test_texture_suggest import NAMES, Clicks

from skyshine.tmm.classify.combined import CombinedMapper, survey
from skyshine.tmm.classify.gaussian import fit
from skyshine.tmm.classify.trained import TrainedModel
from skyshine.tmm.classify.translation import library_classes
from skyshine.tmm.features.colour import DistinctColours, to_coordinates
from skyshine.tmm.images.texture import TextureFile

pytestmark = [pytest.mark.shared_data, pytest.mark.validation]

EVERY, CLICKS, RADIUS = 5, 2, 8
LEAST = {"JPEG 30": 0.95, "half size": 0.92, "brightness": 0.95, "white balance": 0.93}


def _changes(image, folder):
    """Files of the photograph as it is and changed, and by what integer each is smaller."""
    pixels = np.asarray(image).astype(float)

    def save(name, values, size=1):
        path = folder / name
        Image.fromarray(np.clip(np.rint(values), 0, 255).astype(np.uint8)).save(path)
        return path, size

    yield "as it is", *save("plain.png", pixels)
    image.save(folder / "poor.jpg", quality=30)
    yield "JPEG 30", folder / "poor.jpg", 1
    half = pixels.reshape(pixels.shape[0] // 2, 2, pixels.shape[1] // 2, 2, 3).mean(axis=(1, 3))
    yield "half size", *save("half.png", half, 2)
    for part in (0.85, 1.15):
        yield "brightness", *save(f"bright{part}.png", pixels * part)
    for part in (0.93, 1.07):
        yield "white balance", *save(f"white{part}.png", pixels * (part, 1, 2 - part))


def _found(path, drawn, library, way):
    texture = TextureFile(path)
    colours, at = DistinctColours(texture), drawn >= 0
    present, material = np.unique(drawn[at], return_inverse=True)
    names = tuple(NAMES[k] for k in present)
    if way == "model alone":
        mapper = library.mapper(texture, colours, RADIUS)
        present = np.array([NAMES.index(name) for name in library.names])
    else:
        pixels, _ = texture.window(slice(0, texture.height), slice(0, texture.width))
        own = TrainedModel(names, fit(to_coordinates(pixels[at], "srgb"), material, names), None)
        if way == "colour":
            mapper = own.mapper(texture, colours, RADIUS)
        else:
            classes = library_classes(library.names, names, {name: name for name in NAMES})
            surveyed = survey(texture, colours, library)
            mapper = CombinedMapper(texture, colours, surveyed, own, classes, (*np.nonzero(at), material))
    return present[mapper.window(0, texture.height, 0, texture.width).material]


def agreements(sheets, folder):
    """Share of the texels that keep their material, (mean over sheets), by way and change."""
    agree = {}
    for number, (path, truth, library) in enumerate(sheets):
        random, clicks = np.random.default_rng([orthophotos.RANDOM_SEED, number]), Clicks(truth.astype(int))
        for _ in range(CLICKS):
            clicks.at_random(random)
        if len(np.unique(clicks.drawn)) < 3:  # one material alone
            continue
        with Image.open(path) as image:
            changed = list(_changes(image.convert("RGB"), folder))
        for way in ("colour", "model alone", "combined"):
            whole = _found(changed[0][1], clicks.drawn, library, way)
            for change, file, size in changed[1:]:
                found = _found(file, clicks.drawn[::size, ::size], library, way)
                agree.setdefault((way, change), []).append((found == whole[::size, ::size]).mean())
    return {key: float(np.mean(values)) for key, values in agree.items()}


def test_most_texels_keep_their_material(shared_data, tmp_path, record_property):
    pytest.importorskip("sklearn")
    parts = orthophotos.unseen_sheets(shared_data, tmp_path)
    found = agreements(((s.image, s.truth, model) for unseen, model in parts for s in unseen[::EVERY]), tmp_path)
    for (way, change), share in found.items():
        record_property(f"{way}, {change}", share)
        print(f"{way}, {change}: {share:.3f}")
    for change, least in LEAST.items():
        assert found["combined", change] >= least
