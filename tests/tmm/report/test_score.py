"""Scores against label images: confusion and calibration by hand, and what does not fit."""

import numpy as np
import pytest
import yaml

from skyshine.schemas.errors import InputError
from skyshine.tmm.quality.counts import Tally
from skyshine.tmm.report.score import score

GREEN, GREY = "grass_green", "asphalt_road"


@pytest.fixture
def scored(build, job, two_halves, write_image, tmp_path, library):
    """Scores the two halves against labels drawn on them."""

    def run(draw, palette=None, height=20):
        result = build(job(two_halves))
        values = np.zeros((height, 40, 1), np.uint8)
        draw(values[..., 0])
        write_image("truth.png", values)
        labels = {"image": "truth.png", "palette": palette or {"1": GREEN, "2": GREY, "3": "water_fresh"}}
        (tmp_path / "truth.yaml").write_text(yaml.safe_dump(labels))
        return result, score(result.path, tmp_path / "truth.yaml", library)

    return run


def test_confusion_of_a_known_error(scored):
    def draw(values):
        values[:, :10], values[:, 30:], values[:5, 30:] = 1, 2, 3

    _, found = scored(draw)
    assert found.quality.tested == 20 * 10 + 20 * 10
    assert found.quality.overall_accuracy == pytest.approx(350 / 400)
    iou = dict(zip(found.names, found.quality.intersection_over_union, strict=True))
    assert iou == pytest.approx({GREEN: 1, GREY: 150 / 200, "water_fresh": 0})
    assert found.quality.mean_iou == pytest.approx((1 + 0.75 + 0) / 3)


def test_calibration_error_by_hand():
    tally = Tally(2)
    # Ten texels of confidence 0.95, eight of them right; ten of 0.55, all right; one unknown counts for nothing.
    tally.add(np.zeros(10, int), np.array([0] * 8 + [1] * 2), np.full(10, 0.95))
    tally.add(np.ones(10, int), np.ones(10, int), np.full(10, 0.55))
    tally.add(np.zeros(1, int), np.full(1, -1), np.full(1, 0.9))
    quality = tally.quality()
    assert quality.calibration_error == pytest.approx((10 * 0.15 + 10 * 0.45) / 20)
    assert quality.confusion.tolist() == [[1, 8, 2], [0, 0, 10]]


def test_nothing_labelled(scored):
    with pytest.raises(InputError, match="labels no texel"):
        scored(lambda values: None)


def test_labels_of_another_size(scored):
    with pytest.raises(InputError, match="label image is 40 x 21; allowed: the texture's 40 x 20"):
        scored(lambda values: None, height=21)


def test_unknown_material_in_the_palette(scored):
    with pytest.raises(InputError, match="truth.yaml:3:.*unknown material 'gras'"):
        scored(lambda values: None, {"1": "gras"})
