"""Masks and splat maps, read again by Pillow."""

import json

import numpy as np
import pytest
from PIL import Image

from skyshine.tmm.database.levels import WEIGHT_TOTAL, Level
from skyshine.tmm.exchange.image import MaterialImage
from skyshine.tmm.exchange.share_maps import write_masks, write_splat_maps

CODES = (3, 22, 68, 81, 90)


@pytest.fixture
def image():
    """16 x 16 texels of one to three of five materials, or of none."""
    random = np.random.default_rng(2)
    code = np.stack([random.permutation([0, *CODES])[:3] for _ in range(256)]).reshape(16, 16, 3).astype(np.uint16)
    share = -np.sort(-random.dirichlet([1, 1, 1], (16, 16)), axis=-1)
    share[:8] = (1, 0, 0)
    weight = np.floor(share * WEIGHT_TOTAL).astype(np.uint16)
    weight[..., 0] += (WEIGHT_TOTAL - weight.sum(axis=-1, dtype=int)).astype(np.uint16)
    code[weight == 0] = 0
    names = {code: f"material_{code}" for code in CODES}
    return MaterialImage("patch", names, Level(code[..., 0].copy(), code, weight))


def _true_share(image, code):
    return (image.level.mix_weight * (image.level.mix_code == code)).sum(axis=-1) / WEIGHT_TOTAL


def test_a_mask_is_the_share_of_its_material(image, tmp_path):
    *pictures, legend = write_masks(tmp_path, image)
    total = _true_share(image, 0) * 255
    entries = json.loads(legend.read_text())["materials"].values()
    assert [entry["code"] for entry in entries] == list(CODES) and len(pictures) == 5
    for entry in entries:
        with Image.open(tmp_path / entry["image"]) as picture:
            assert picture.mode == "L" and picture.size == (16, 16)
            mask = np.array(picture)
        np.testing.assert_allclose(mask, 255 * _true_share(image, entry["code"]), atol=1)
        assert set(np.unique(mask[:8])) <= {0, 255}
        total = total + mask
    np.testing.assert_allclose(total, 255, atol=1)
    whole = (image.level.mix_code > 0) | (image.level.mix_weight == 0)
    assert (total[whole.all(axis=-1)] == 255).all()


def test_splat_maps_hold_four_masks_each(image, tmp_path):
    *_, masks = write_masks(tmp_path, image)
    *pictures, legend = write_splat_maps(tmp_path, image)
    assert [path.name for path in pictures] == ["patch.splat0.png", "patch.splat1.png"]
    entries = json.loads(legend.read_text())["materials"]
    assert [(entry["image"][11], entry["channel"]) for entry in entries.values()] == [
        *zip("00001", "RGBAR", strict=True)
    ]
    for number, entry in entries.items():
        mask = json.loads(masks.read_text())["materials"][number]["image"]
        splat = np.array(Image.open(tmp_path / entry["image"]))
        assert splat.shape == (16, 16, 4)
        assert np.array_equal(splat[..., "RGBA".index(entry["channel"])], np.array(Image.open(tmp_path / mask)))
    assert not np.array(Image.open(pictures[1]))[..., 1:].any()


def test_the_same_bytes_again(image, tmp_path):
    first = [path.read_bytes() for path in write_splat_maps(tmp_path, image)]
    assert [path.read_bytes() for path in write_splat_maps(tmp_path, image)] == first
