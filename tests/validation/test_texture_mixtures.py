"""Mixtures by the posterior against labelled photographs: the shares of materials in texels of coarse levels."""

import numpy as np
import pytest
from test_texture_orthophotos import PALETTES, _photographs

from skyshine.materials.library import load_library
from skyshine.tmm.database.levels import WEIGHT_TOTAL
from skyshine.tmm.database.reader import open_tmm
from skyshine.tmm.mapping.texture_map import map_texture
from skyshine.tmm.mapping.write import write_texture

pytestmark = [pytest.mark.shared_data, pytest.mark.validation]

EVERY = 4  # photograph that is measured


def shares(path, level, codes):
    with open_tmm(path) as file:
        found, weights = (file.array(f"levels/{level}/{name}") for name in ("mix_code", "mix_weight"))
    return np.stack([np.where(found == code, weights, 0).sum(axis=-1) / WEIGHT_TOTAL for code in codes])


def errors(path, truth, scored, codes):
    """Mean squared error, summed over materials (Brier's score), of the shares of texels of level 0 and of blocks of 8
    and 32 texels a side, all of them scored; and the share of the sheet that is given to the wrong material.
    """
    height, width = (length // 32 * 32 for length in truth.shape)
    is_material = np.stack([truth == k for k in range(len(codes))])[:, :height, :width].astype(float)
    found = shares(path, 0, codes)[:, :height, :width]
    used = scored[:height, :width]
    result = []
    for side in (1, 8, 32):
        blocks = (height // side, side, width // side, side)
        whole = used.reshape(blocks).all(axis=(1, 3))
        means = (part.reshape(len(codes), *blocks).mean(axis=(2, 4)) for part in (found, is_material))
        result.append((np.subtract(*means) ** 2).sum(axis=0)[whole].mean())
    area = (found - is_material)[:, used].mean(axis=1)
    return [*result, np.abs(area).sum() / 2]


@pytest.mark.parametrize("kind", ["orthophoto", "drone"])
def test_shares_of_texels_are_nearer_to_the_truth(shared_data, tmp_path, record_property, kind):
    """Of single texels. Errors of neighbours go together, so that blocks and sheets gain less or lose (printed)."""
    library, names = load_library(None), list(PALETTES[kind].values())
    codes = [library[name].code for name in names]
    found, sizes = {False: [], True: []}, {False: 0, True: 0}
    for photograph in _photographs(shared_data, kind, tmp_path)[::EVERY]:
        for mixtures in (False, True):
            settings = photograph.job.classifier.model_copy(update={"mixtures": mixtures})
            job = photograph.job.model_copy(update={"classifier": settings})
            path = tmp_path / "found.tmm.h5"
            write_texture(map_texture(job, photograph.image.parent, library), path)
            found[mixtures].append(errors(path, photograph.truth, photograph.scored, codes))
            sizes[mixtures] += path.stat().st_size
    hard, soft = (np.nanmean(found[mixtures], axis=0) for mixtures in (False, True))
    for name, values in (("likeliest", hard), ("mixtures", soft)):
        scores = ", ".join(f"{value:.4f}" for value in values[:3])
        print(f"\n{kind}, {name}: Brier of 1, 8, 32 texels a side {scores}; wrong area of a sheet {values[3]:.4f}")
        record_property(name, values.tolist())
    print(f"bytes {sizes[True] / sizes[False]:.2f} times")
    assert soft[0] < hard[0]
