"""Shade of labelled aerial sheets: materials inside and outside real shade, without the layer of shade and with it.

Shade here is where a texel is darker than .4 of the median of its labelled class: a rule that the method does not know.
It also holds the shaded sides of crowns, and what is dark in a bright class. Sheets on which no shade is found are
classified as they are, in all ways. No sheet states when it was taken: the azimuths of the Sun below were read off the
pictures by eye, by the shadows of poles, cars, trees and corners of roofs, within some 10 degrees. The constants of
`cast_shade` were chosen on the sheets of `CHOSEN_ON` alone, which are printed apart.
"""

import numpy as np
import pytest
from test_texture_orthophotos import PALETTES, _photographs

from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError
from skyshine.tmm.features.colour import to_xyz
from skyshine.tmm.inputs.load import open_texture
from skyshine.tmm.job.shade import Shade
from skyshine.tmm.mapping.texture_map import map_texture

pytestmark = [pytest.mark.shared_data, pytest.mark.validation]

DARK = 0.4
EVERY = 4  # photograph of each kind
SUN = {  # azimuth in degrees; on the sheets that are missing no shadow is seen
    "BLAN981": 130,
    "BOS12": 132,
    "KROM371": 115,
    "PROS36": 160,
    "PROS83": 138,
    "VYSK111": 108,
    "VYSK121": 125,
    "VYSK131": 102,
    "VYSK151": 115,
    "VYSK301": 114,
    "VYSK303": 105,
}
SUN_OF_DRONE = 227
CHOSEN_ON = ("BLAN981", "KROM371", "PROS36", "VYSK111", "VYSK131", "VYSK301")
WAYS = ("plain", "by the Sun")


def real_shade(photograph):
    """Where labelled texels are far darker than their class."""
    texture = open_texture(photograph.job, photograph.image.parent)
    pixels, valid = texture.window(slice(0, texture.height), slice(0, texture.width))
    light = to_xyz(pixels.reshape(-1, pixels.shape[-1])[:, :3], texture.encoding)[:, 1].reshape(valid.shape)
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


def shades(photograph, kind):
    """The ways to look for shade on a sheet; none where nothing is said of it."""
    azimuth = SUN_OF_DRONE if kind == "drone" else SUN.get(photograph.image.stem.rsplit("_", 1)[0])
    return None, None if azimuth is None else Shade(sun_azimuth_deg=azimuth)


@pytest.mark.parametrize("kind", ["orthophoto", "drone"])
def test_materials_in_real_shade(shared_data, tmp_path, record_property, kind):
    library, names = load_library(None), list(PALETTES[kind].values())
    count = np.zeros((2, len(WAYS), 2, 2))  # chosen on or judged by; way; outside or inside; right of all
    found = np.zeros((2, len(WAYS)), int)
    for photograph in _photographs(shared_data, kind, tmp_path)[::EVERY]:
        shade = real_shade(photograph)
        judged = int(photograph.image.stem.rsplit("_", 1)[0] not in CHOSEN_ON)
        plain = correct(photograph, photograph.job, library, names)
        for way, wanted in enumerate(shades(photograph, kind)):
            right = plain
            if wanted is not None:
                try:
                    right = correct(photograph, photograph.job.model_copy(update={"shade": wanted}), library, names)
                    found[judged, way] += 1
                except InputError:
                    pass
            for inside, where in enumerate((photograph.scored & ~shade, shade)):
                count[judged, way, inside] += right[where].sum(), where.sum()
    accuracy = {"all sheets": count.sum(axis=0)}
    if kind == "orthophoto":
        accuracy |= {"chosen on": count[0], "judged by": count[1]}
    accuracy = {which: sums[..., 0] / sums[..., 1] for which, sums in accuracy.items()}
    print(
        f"\n{kind}: {count[:, 0, 1, 1].sum() / count[:, 0, :, 1].sum():.3f} of the texels in real shade;"
        f" shade found on {dict(zip(WAYS[1:], found.sum(axis=0).tolist()[1:], strict=True))} sheets"
    )
    for which, ways in accuracy.items():
        for way, (outside, inside) in zip(WAYS, ways, strict=True):
            record_property(f"{which}, {way}, inside", inside)
            print(
                f"  {which:10s} {way:10s} accuracy outside {outside:.3f}, inside {inside:.3f},"
                f" ratio {inside / outside:.3f}"
            )
    for outside, inside in accuracy["all sheets"][1:] - accuracy["all sheets"][0]:
        assert inside >= -0.005 and outside >= -0.005
    if kind == "orthophoto":
        (_, plain), (_, by_sun) = accuracy["judged by"]
        assert by_sun > plain
