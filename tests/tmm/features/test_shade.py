"""Shade of made photographs: where it is, how dark, and the photograph without it."""

import numpy as np
import pytest
import tifffile

from skyshine.schemas.errors import InputError
from skyshine.tmm import export, open_tmm
from skyshine.tmm.features.shade import MARGIN, RelitTexture, Shade
from skyshine.tmm.images.texture import Texture
from skyshine.tmm.job.model import TextureJob

GAIN = np.array([4.5, 3.8, 2.8])  # sunlight and sky over the sky alone, as under a clear sky
GRASS, ROAD, BARK = (0.10, 0.20, 0.06), (0.30, 0.30, 0.32), (0.12, 0.09, 0.06)
RECT = slice(40, 120), slice(60, 180)  # in the shade


def encoded(light):
    curve = np.where(light > 0.0031308, 1.055 * np.maximum(light, 0.0031308) ** (1 / 2.4) - 0.055, 12.92 * light)
    return np.rint(255 * np.clip(curve, 0, 1)).astype(np.uint8)


def photograph(shade=RECT, gain=GAIN, noise=0.06, size=(160, 240)):
    """Grass, road and bark in strips, with noise of the light, and a rectangle of them in the shade."""
    random = np.random.default_rng(3)
    light = np.empty((*size, 3))
    light[:, :100], light[:, 100:170], light[:, 170:] = GRASS, ROAD, BARK
    light *= np.exp(noise * random.standard_normal((*size, 1)))
    lit = light.copy()
    if shade is not None:
        light[shade] /= gain
    return encoded(light), lit


def texture(pixels):
    return Texture(pixels, np.ones(pixels.shape[:2], bool), "srgb")


def inside(size=(160, 240)):
    mask = np.zeros(size, bool)
    mask[RECT] = True
    return mask


def test_the_shade_and_its_gain_are_found():
    pixels, _ = photograph()
    found = Shade.of(texture(pixels), "made")
    assert np.array(found.gain) == pytest.approx(GAIN, rel=0.12)
    light = (pixels / 255.0) ** 2.2
    fraction = found.fraction(light, np.ones(pixels.shape[:2], bool))
    assert ((fraction > 0.5) == inside()).mean() > 0.98
    assert fraction.min() >= 0 and fraction.max() <= 1


def test_the_photograph_without_shade_is_the_sunlit_one(tmp_path, write_image):
    pixels, lit = photograph()
    relit = RelitTexture(tmp_path / write_image("shaded.png", pixels))
    found, valid = relit.window(slice(0, 160), slice(0, 240))
    core = np.zeros((160, 240), bool)
    core[46:114, 66:94] = core[46:114, 106:164] = True  # away from edges of shade and of materials
    wanted = encoded(lit)[core].astype(float)
    assert np.abs(found[core] - wanted).mean() < 12 and valid.all() and found.dtype == np.uint8
    outside = ~inside()
    outside[30:130, 50:190] = False
    assert np.array_equal(found[outside], pixels[outside])


def test_windows_meet_without_seams(tmp_path, write_image):
    relit = RelitTexture(tmp_path / write_image("shaded.png", photograph()[0]))
    whole = relit.shade(slice(0, 160), slice(0, 240))
    parts = [relit.shade(slice(0, 160), slice(left, left + 60)) for left in range(0, 240, 60)]
    assert np.abs(np.concatenate(parts, axis=1) - whole).max() < 1e-6 and MARGIN >= 16


@pytest.mark.parametrize(
    "pixels",
    [
        photograph(None)[0],  # sunlit everywhere: three materials, none darker by shade
        photograph(gain=np.array([3.0, 3.0, 3.0]))[0],  # dark, not bluer: another material, such as asphalt
        photograph(gain=np.array([2.0, 2.6, 3.4]))[0],  # dark and redder
        np.full((64, 64, 3), 90, np.uint8),
        np.random.default_rng(0).integers(0, 255, (64, 64, 3)).astype(np.uint8),
        np.zeros((1, 1, 3), np.uint8),
    ],
    ids=["sunlit", "neutral", "redder", "flat", "noise", "one texel"],
)
def test_what_is_no_shade_is_refused(tmp_path, write_image, pixels):
    with pytest.raises(InputError, match="has no shade that is told from sunlight"):
        RelitTexture(tmp_path / write_image("none.png", pixels))


def test_texels_without_data_are_in_no_shade():
    pixels, _ = photograph()
    valid = np.ones(pixels.shape[:2], bool)
    valid[:, 120:] = False
    pixels[:, 120:] = 0
    found = Shade.of(Texture(pixels, valid, "srgb"), "made")
    fraction = found.fraction((pixels / 255.0) ** 2.2, valid)
    assert np.all(fraction[~valid] == 0) and fraction[80, 80] > 0.9


POLYGONS = {
    "grass_green": [[[5, 5], [90, 5], [90, 30], [5, 30]]],
    "asphalt_road": [[[110, 5], [160, 5], [160, 30], [110, 30]]],
    "wood_pine_weathered": [[[180, 5], [230, 5], [230, 30], [180, 30]]],
}


def job(**shade):
    return TextureJob.model_validate(
        {"image": "shaded.png", "shade": shade, "classifier": {"radius": 2}, "seeds": {"polygons": POLYGONS}}
    )


def test_the_material_is_that_beneath_and_the_shade_is_a_layer(tmp_path, write_image, build, library):
    pixels, _ = photograph()
    write_image("shaded.png", pixels)
    built = build(job())
    truth = np.empty((160, 240), np.uint16)
    truth[:, :100], truth[:, 100:170], truth[:, 170:] = (library[n].code for n in POLYGONS)
    assert (built.code == truth)[RECT].mean() > 0.9
    plain = build(TextureJob.model_validate(job().model_dump(exclude={"shade"})), "plain.tmm.h5")
    assert np.median(plain.typicality[RECT]) < np.median(built.typicality[RECT])
    assert built.written.shade == pytest.approx(inside().mean(), abs=0.02)
    with open_tmm(built.path) as file:
        assert file.has_shade and file.levels == 8
        assert file.shade(120.5, 80.5) > 0.95 and file.shade(20.5, 80.5) < 0.05
        whole = file.array("levels/0/shade").astype(float)
        for level in range(file.levels):
            rows, columns = file.size(level)
            blocks = whole[: rows << level, : columns << level]
            means = blocks.reshape(rows, 1 << level, columns, 1 << level).mean(axis=(1, 3))
            stored = file.array(f"levels/{level}/shade")
            # The last row and column of a level cover the rest, too.
            assert np.abs(stored[:-1, :-1] - means[:-1, :-1]).max(initial=0) <= 0.5 + 0.5 * level
        assert file.array("levels/7/shade")[0, 0] == pytest.approx(whole.mean(), abs=5)
    with open_tmm(plain.path) as file:
        assert not file.has_shade and file.shade(120.5, 80.5) == 0


def test_polygons_correct_the_shade(tmp_path, write_image, build):
    write_image("shaded.png", photograph()[0])
    drawn = {
        "shaded": [[[10, 130], [40, 130], [40, 155], [10, 155]]],
        "sunlit": [[[70, 50], [90, 50], [90, 70], [70, 70]], [[30, 130], [40, 130], [40, 155], [30, 155]]],
    }
    with open_tmm(build(job(**drawn)).path) as file:
        assert file.shade(15.5, 140.5) == 1 and file.shade(80.5, 60.5) == 0 and file.shade(35.5, 140.5) == 0
        assert file.shade(120.5, 80.5) > 0.95
    with pytest.raises(InputError, match=r"a polygon of 'shade' has the vertex \[300, 5\]"):
        build(job(shaded=[[[0, 0], [300, 5], [5, 5]]]))


def test_the_relit_photograph_and_the_shade_on_a_map_are_written(tmp_path, write_image, build, library):
    write_image("shaded.png", photograph()[0])
    (tmp_path / "shaded.pgw").write_text("0.5 0 0 -0.25 100.25 199.875")
    built = build(job())
    (written,) = export(built.path, "relit", tmp_path / "out", library)
    window = RelitTexture(tmp_path / "shaded.png").window(slice(0, 160), slice(0, 240))[0]
    assert np.array_equal(tifffile.imread(written), window)
    shade = [path for path in export(built.path, "geotiff", tmp_path / "out", library) if "shade" in path.name]
    with open_tmm(built.path) as file:
        assert np.array_equal(tifffile.imread(shade[0]), file.array("levels/0/shade"))
    plain = build(TextureJob.model_validate(job().model_dump(exclude={"shade"})), "plain.tmm.h5")
    with pytest.raises(InputError, match="has no layer of shade; classify the texture with 'shade: {}'"):
        export(plain.path, "relit", tmp_path / "out", library)
