"""How far the model that comes with the package carries, on aerial sheets of another continent.

It was trained on five photographs of wild land in the United States; the sheets are of fields, roads and villages in
Moravia, and most of their materials are none of its own.
"""

import numpy as np
import pytest
import test_texture_orthophotos as orthophotos
from test_texture_suggest import NAMES, RADIUS, SMALLEST

from skyshine.materials.library import load_library
from skyshine.tmm.classify.combined import CombinedMapper, survey
from skyshine.tmm.classify.gaussian import fit
from skyshine.tmm.classify.model_file import model_path, read_model
from skyshine.tmm.classify.trained import TrainedModel
from skyshine.tmm.classify.translation import library_classes
from skyshine.tmm.features.colour import DistinctColours, to_coordinates
from skyshine.tmm.images.texture import TextureFile
from skyshine.tmm.job.model import PACKAGED
from skyshine.tmm.quality.counts import Tally

pytestmark = [pytest.mark.shared_data, pytest.mark.validation]

LIBRARY_RADIUS = 8
LEAST_VEGETATION = 0.9  # of what is named vegetation is; of what is not, is not
EVERY = 3  # sheet of those with a click


def test_vegetation_is_told_from_other_ground(shared_data, tmp_path, record_property):
    model, library = read_model(model_path(PACKAGED, ".")), load_library(None)
    green = np.array([library[name].group == "vegetation" for name in model.names])
    truly = np.array([library[name].group == "vegetation" for name in NAMES])
    count, classes = np.zeros((2, 2)), np.zeros((len(NAMES), len(model.names)), int)
    for photograph in orthophotos._photographs(shared_data, "orthophoto", tmp_path):
        texture = TextureFile(photograph.image)
        mapper = model.mapper(texture, DistinctColours(texture), LIBRARY_RADIUS)
        found = mapper.window(0, texture.height, 0, texture.width).material
        known = photograph.truth >= 0
        np.add.at(classes, (photograph.truth[known], found[known]), 1)
        np.add.at(count, (truly[photograph.truth[known]].astype(int), green[found[known]].astype(int)), 1)
    print("\nshare of each class of the sheets by class of the model:", *model.names, sep="\n  ")
    for name, row in zip(NAMES, classes / classes.sum(axis=1, keepdims=True), strict=True):
        print(f"  {name}:", *row.round(2))
    share = count / count.sum(axis=1, keepdims=True)
    record_property("vegetation_found", share[1, 1])
    record_property("other_ground_found", share[0, 0])
    print(f"vegetation found as such {share[1, 1]:.3f}, other ground {share[0, 0]:.3f}")
    assert share[1, 1] >= LEAST_VEGETATION


def test_beside_one_click_a_material_it_does_no_harm(shared_data, tmp_path, record_property):
    packaged, library = read_model(model_path(PACKAGED, ".")), load_library(None)
    tallies = {"seeds and graph": Tally(len(NAMES)), "and the packaged model": Tally(len(NAMES))}
    sheets = orthophotos._photographs(shared_data, "orthophoto", tmp_path)[1::EVERY]
    for number, photograph in enumerate(sheets):
        texture = TextureFile(photograph.image)
        colours, drawn = DistinctColours(texture), _clicks(photograph.truth, number)
        at = drawn >= 0
        present, material = np.unique(drawn[at], return_inverse=True)
        if len(present) < 2:
            continue
        pixels, _ = texture.window(slice(0, texture.height), slice(0, texture.width))
        names = tuple(NAMES[k] for k in present)
        own = TrainedModel(names, fit(to_coordinates(pixels[at], "srgb"), material, names), None)
        for general, tally in zip((None, packaged), tallies.values(), strict=True):
            known = () if general is None else general.names
            groups = {name: library[name].group for name in (*known, *names)}
            classes = library_classes(known, names, groups)
            mapper = CombinedMapper(
                texture, colours, survey(texture, colours, general), own, classes, (*np.nonzero(at), material)
            )
            found = mapper.window(0, texture.height, 0, texture.width)
            scored = (photograph.truth >= 0) & ~at
            tally.add(photograph.truth[scored], present[found.material[scored]], found.confidence[scored])
    quality = {way: tally.quality() for way, tally in tallies.items()}
    for way, each in quality.items():
        record_property(way, each.mean_iou)
        print(f"\n{way}: mean IoU {each.mean_iou:.3f}, accuracy {each.overall_accuracy:.3f}")
    plain, helped = quality.values()
    assert helped.overall_accuracy >= plain.overall_accuracy - 0.01


def _clicks(truth, number):
    """A disk of each class that has enough texels, placed at random."""
    random, drawn = np.random.default_rng([orthophotos.RANDOM_SEED, number]), np.full(truth.shape, -1)
    rows, columns = np.ogrid[: truth.shape[0], : truth.shape[1]]
    for k in range(len(NAMES)):
        texels = np.flatnonzero(truth == k)
        if len(texels) >= SMALLEST:
            row, column = divmod(int(random.choice(texels)), truth.shape[1])
            drawn[((rows - row) ** 2 + (columns - column) ** 2 <= RADIUS**2) & (truth == k)] = k
    return drawn
