"""Unknown materials: one material of each photograph gets no seeds, and is to be found by default settings.

Thresholds were chosen on every second sheet, by name; the others judge them.
"""

import numpy as np
import pytest
from scipy.stats import rankdata
from test_texture_orthophotos import PALETTES, _photographs

from skyshine.materials.library import load_library
from skyshine.tmm.job.model import TextureJob
from skyshine.tmm.mapping.texture_map import map_texture

pytestmark = [pytest.mark.shared_data, pytest.mark.validation]

SAMPLE = 7  # every so many texels count in the area under the curve
EVERY = {"orthophoto": 2, "drone": 1}  # of the photographs
LEAST_AREA, LEAST_FOUND, MOST_FALSE = 0.85, 0.40, 0.021


def _mapped(photograph, palette, library):
    """Whether each texel is unknown, and its typicality, with seeds of the materials of a palette."""
    seeds = {"labels": {"image": photograph.job.seeds.labels.image, "palette": palette}}
    job = TextureJob.model_validate({"image": photograph.job.image, "seeds": seeds})
    unknown, typicality = np.zeros(photograph.truth.shape, bool), np.zeros(photograph.truth.shape, np.float32)
    for rows, columns, level, found in map_texture(job, photograph.image.parent, library).windows():
        unknown[rows, columns], typicality[rows, columns] = level.code == 0, found.typicality
    return unknown, typicality


def area(known, unknown):
    """Chance that a texel of an unknown material is less typical than one of a known material."""
    ranks = rankdata(np.concatenate([known, unknown]))[len(known) :]
    return 1 - (ranks.sum() - len(unknown) * (len(unknown) + 1) / 2) / (len(unknown) * len(known))


def test_area_by_hand():
    assert area(np.array([0.5, 0.9]), np.array([0.1, 0.6])) == 0.75


def _sheet(photograph, kind):
    return photograph.image.stem.rsplit("_", 1)[0] if kind == "orthophoto" else photograph.image.stem


@pytest.mark.parametrize("half", ["chosen on", "judged"])
@pytest.mark.parametrize("kind", ["orthophoto", "drone"])
def test_a_material_without_seeds_is_found(shared_data, tmp_path, record_property, kind, half):
    library, names = load_library(None), list(PALETTES[kind].values())
    photographs = _photographs(shared_data, kind, tmp_path)
    chosen = set(sorted({_sheet(photograph, kind) for photograph in photographs})[::2])
    known, unknown, counts = [], [], np.zeros((3, 2))  # no unknown; known beside an unknown; unknown: found, all
    mine = [p for p in photographs if (_sheet(p, kind) in chosen) == (half == "chosen on")][:: EVERY[kind]]
    for photograph in mine:
        palette = photograph.job.seeds.labels.palette
        if len(palette) < 3:
            continue
        found, _ = _mapped(photograph, palette, library)
        counts[0] += found[photograph.scored].sum(), photograph.scored.sum()
        for key, name in palette.items():
            found, typicality = _mapped(photograph, {k: n for k, n in palette.items() if k != key}, library)
            out = photograph.truth == names.index(name)
            left = photograph.scored & ~out & np.isin(photograph.truth, [names.index(n) for n in palette.values()])
            for row, where in ((1, left), (2, out)):
                counts[row] += found[where].sum(), where.sum()
            known.append(typicality[left][::SAMPLE])
            unknown.append(typicality[out][::SAMPLE])
    shares = counts[:, 0] / counts[:, 1]
    whole = area(np.concatenate(known), np.concatenate(unknown))
    what = ("false without unknown materials", "false beside one", "found")
    for name, share in zip((*what, "area"), (*shares, whole), strict=True):
        record_property(name, share)
    print(
        f"\n{kind}, {half}, {len(mine)} photographs, {len(known)} left out: area {whole:.4f},",
        ", ".join(f"{name} {share:.4f}" for name, share in zip(what, shares, strict=True)),
    )
    assert whole >= LEAST_AREA and shares[0] <= MOST_FALSE and shares[2] >= LEAST_FOUND
