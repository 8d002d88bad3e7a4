"""The default classifier on labelled orthophotos, trained on a few patches of each photograph's own labels."""

import numpy as np
import OpenImageIO as oiio
import pytest

from skyshine.materials.library import load_library
from skyshine.tmm.build import load_texture
from skyshine.tmm.classify import TextureClassifier, fit_seeds
from skyshine.tmm.features.colour import DistinctColours
from skyshine.tmm.job import TextureJob
from skyshine.tmm.raster import read_channels

pytestmark = [pytest.mark.shared_data, pytest.mark.validation]

# Label colours of the photographs and a material of the library for each.
PALETTE = {
    "#32FFA7": "deciduous",
    "#A67556": "soil_loam_brown",
    "#6D32FF": "asphalt_road",
    "#FFE132": "roof_shingle_asphalt_grey",
    "#32A7FF": "water_fresh",
    "#FF8C00": "gravel_limestone",
}
RANDOM_SEED, PATCHES, HALF, SMALLEST = 0, 8, 4, 400


def _truth(mask: np.ndarray) -> np.ndarray:
    truth = np.full(mask.shape[:2], -1)
    for k, key in enumerate(PALETTE):
        truth[(mask[..., :3] == [int(key[i : i + 2], 16) for i in (1, 3, 5)]).all(axis=-1)] = k
    return truth


def _patches(mask: np.ndarray, truth: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """The label image with everything black but PATCHES squares of 2 HALF + 1 texels a class."""
    keep = np.zeros(truth.shape, bool)
    for k in range(len(PALETTE)):
        rows, columns = np.nonzero(truth == k)
        if len(rows) < SMALLEST:
            continue
        for i in random.choice(len(rows), PATCHES):
            square = np.s_[
                max(rows[i] - HALF, 0) : rows[i] + HALF + 1, max(columns[i] - HALF, 0) : columns[i] + HALF + 1
            ]
            keep[square] |= truth[square] == k
    return np.where(keep[..., np.newaxis], mask[..., :3], 0).astype(np.uint8)


def test_mean_iou_with_seeds_of_the_photograph(shared_data, tmp_path, record_property):
    folder, library = shared_data / "textures" / "orthophoto", load_library(None)
    confusion = np.zeros((len(PALETTE), len(PALETTE)), np.int64)
    images = sorted((folder / "images").glob("*.jpg"))
    assert len(images) == 58
    for number, image in enumerate(images):
        mask = read_channels(folder / "masks" / f"{image.stem}.png")
        truth = _truth(mask)
        labels = _patches(mask, truth, np.random.default_rng([RANDOM_SEED, number]))
        path = tmp_path / f"{image.stem}.png"
        output = oiio.ImageOutput.create(str(path))
        output.open(str(path), oiio.ImageSpec(labels.shape[1], labels.shape[0], 3, "uint8"))
        output.write_image(labels)
        output.close()
        present = {key: name for k, (key, name) in enumerate(PALETTE.items()) if (truth == k).sum() >= SMALLEST}
        seeds = {"labels": {"image": str(path), "palette": present}}
        job = TextureJob.model_validate({"image": image.name, "seeds": seeds})
        texture, seeds = load_texture(job, image.parent, library)
        model = fit_seeds(texture, seeds, job.classifier)
        result = TextureClassifier(texture, DistinctColours(texture), model, job.classifier.radius).whole()
        found = np.array([list(PALETTE.values()).index(name) for name in model.names])[result.material]
        scored = truth >= 0
        scored[seeds.rows, seeds.columns] = False
        np.add.at(confusion, (truth[scored], found[scored]), 1)
    hit = np.diag(confusion)
    iou = hit / (confusion.sum(axis=0) + confusion.sum(axis=1) - hit)
    accuracy = hit.sum() / confusion.sum()
    record_property("mean_iou", float(iou.mean()))
    record_property("accuracy", float(accuracy))
    print(
        f"\nmean IoU {iou.mean():.3f}, accuracy {accuracy:.3f}, IoU", dict(zip(PALETTE.values(), iou.round(3).tolist()))
    )
    assert iou.mean() >= 0.49
