"""The same photograph stored or lit otherwise: how many texels keep their material.

The seeds stay where they are: they are read again on the changed photograph, as a user's job would. The library model
stays as it was trained, on other sheets as they are.
"""

import numpy as np
import pytest
import test_texture_orthophotos as orthophotos
from PIL import Image
from test_texture_suggest import MODEL, Sheet

from skyshine.materials.library import load_library
from skyshine.tmm import map_texture, open_tmm, write_texture
from skyshine.tmm.classify.model_file import write_model
from skyshine.tmm.job.model import TextureJob

pytestmark = [pytest.mark.shared_data, pytest.mark.validation]

EVERY, CLICKS = 5, 2
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


WAYS = {
    "speed fast": {"classifier": {"speed": "fast"}},
    "model alone": {"model": MODEL},
    "default with model": {"model": MODEL},
}


def _found(path, seeds, folder, way):
    """Codes of the file that was written."""
    settings = WAYS[way] | ({} if way == "model alone" else {"seeds": seeds})
    job = TextureJob.model_validate({"image": str(path), **settings})
    write_texture(map_texture(job, folder, load_library(None)), folder / "changed.tmm.h5")
    with open_tmm(folder / "changed.tmm.h5") as file:
        return file.array("levels/0/code")


def agreements(sheets, folder):
    """Share of the texels that keep their material, (mean over sheets), by way and change."""
    agree = {}
    for number, (path, truth, library) in enumerate(sheets):
        write_model(library, folder / MODEL, "job", "1", {})
        random, sheet = np.random.default_rng([orthophotos.RANDOM_SEED, number]), Sheet(path, truth, folder)
        clicks = np.full(truth.shape, -1)
        for _ in range(CLICKS):
            sheet.random_click(random, clicks)
        if len(np.unique(clicks)) < 3:  # one material alone
            continue
        with Image.open(path) as image:
            changed = list(_changes(image.convert("RGB"), folder))
        for way in WAYS:
            whole = _found(changed[0][1], sheet.painted(clicks), folder, way)
            for change, file, size in changed[1:]:
                found = _found(file, sheet.painted(clicks[::size, ::size]), folder, way)
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
        assert found["default with model", change] >= least
