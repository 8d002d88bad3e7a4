"""How far the model that comes with the package carries, on aerial sheets of another continent.

It was trained on five photographs of wild land in the United States; the sheets are of fields, roads and villages in
Moravia, and most of their materials are none of its own.
"""

import numpy as np
import pytest
import test_texture_orthophotos as orthophotos
from test_texture_suggest import NAMES, Row, Sheet

from skyshine.materials.library import load_library
from skyshine.tmm.classify.model_file import model_path, read_model
from skyshine.tmm.classify.trained import ModelMapper
from skyshine.tmm.features.colour import DistinctColours
from skyshine.tmm.images.texture import TextureFile
from skyshine.tmm.job.model import PACKAGED

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
        mapper = ModelMapper(texture, DistinctColours(texture), model, LIBRARY_RADIUS)
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
    rows = {"seeds alone": Row(), "and the packaged model": Row()}
    sheets = orthophotos._photographs(shared_data, "orthophoto", tmp_path)[1::EVERY]
    for number, photograph in enumerate(sheets):
        sheet, clicks = Sheet(photograph.image, photograph.truth, tmp_path), np.full(photograph.truth.shape, -1)
        sheet.random_click(np.random.default_rng([orthophotos.RANDOM_SEED, number]), clicks)
        if len(np.unique(clicks)) < 3:  # one material alone
            continue
        for row, settings in zip(rows.values(), ({}, {"model": PACKAGED}), strict=True):
            sheet.score(row, sheet.painted(clicks), clicks >= 0, **settings)
    reports = {way: row.report() for way, row in rows.items()}
    for way, report in reports.items():
        record_property(way, report["accuracy"])
        print(f"\n{way}: mean IoU {report['mean_iou']:.3f}, accuracy {report['accuracy']:.3f}")
    plain, helped = reports.values()
    assert helped["accuracy"] >= plain["accuracy"] - 0.01
