"""Shade of labelled aerial sheets: materials inside and outside real shade, with and without the layer of shade.

Shade here is where a texel is darker than .4 of the median of its labelled class: a rule that the method does not know.
Sheets on which no shade is told from sunlight are classified as they are, in both.
"""

import numpy as np
import pytest
from test_texture_orthophotos import PALETTES, _photographs

from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError
from skyshine.tmm.features.shadow import luminance
from skyshine.tmm.inputs.load import open_texture
from skyshine.tmm.job.model import Shade
from skyshine.tmm.mapping.texture_map import map_texture

pytestmark = [pytest.mark.shared_data, pytest.mark.validation]

DARK = 0.4


def real_shade(photograph):
    """Where labelled texels are far darker than their class."""
    texture = open_texture(photograph.job, photograph.image.parent)
    pixels, valid = texture.window(slice(0, texture.height), slice(0, texture.width))
    light = luminance(pixels.reshape(-1, pixels.shape[-1]), texture.encoding).reshape(valid.shape)
    limit = np.zeros(valid.shape)
    for k in np.unique(photograph.truth[photograph.truth >= 0]):
        own = photograph.truth == k
        limit[own] = DARK * np.median(light[own])
    return (light < limit) & photograph.scored


def correct(photograph, job, library, names):
    mapped = map_texture(job, photograph.image.parent, library)
    number = {int(code): names.index(name) for code, name in zip(mapped.codes, mapped.names, strict=True)} | {0: -1}
    right = np.zeros(photograph.truth.shape, bool)
    for rows, columns, level, _ in mapped.windows():
        found = np.vectorize(number.get)(level.code)
        right[rows, columns] = found == photograph.truth[rows, columns]
    return right


@pytest.mark.parametrize("kind", ["orthophoto", "drone"])
def test_materials_in_real_shade(shared_data, tmp_path, record_property, kind):
    library, names = load_library(None), list(PALETTES[kind].values())
    count = np.zeros((2, 2, 2))  # plain or with shade; outside or inside; right of all
    found = 0
    for photograph in _photographs(shared_data, kind, tmp_path):
        shade = real_shade(photograph)
        with_shade = photograph.job.model_copy(update={"shade": Shade()})
        plain = correct(photograph, photograph.job, library, names)
        try:
            relit = correct(photograph, with_shade, library, names)
            found += 1
        except InputError:
            relit = plain
        for way, right in enumerate((plain, relit)):
            for inside, where in enumerate((photograph.scored & ~shade, shade)):
                count[way, inside] += right[where].sum(), where.sum()
    accuracy = count[..., 0] / count[..., 1]
    print(
        f"\n{kind}: shade found on {found} sheets;"
        f" {count[0, 1, 1] / count[0, :, 1].sum():.3f} of the texels in real shade"
    )
    for way, (outside, inside) in zip(("plain", "with shade"), accuracy, strict=True):
        record_property(f"{way}_inside", inside)
        print(f"  {way:10s} accuracy outside {outside:.3f}, inside {inside:.3f}, ratio {inside / outside:.3f}")
    outside, inside = accuracy[1] - accuracy[0]
    assert inside >= -0.005 and outside >= -0.005
