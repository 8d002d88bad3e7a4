"""Cast shade of made scenes: boxes on ground of three materials, with dark forest, water and asphalt that cast nothing.

The scenes are drawn here by geometry alone: a texel is in the shade where the line to the Sun meets a box.
"""

import numpy as np
import pytest
import tifffile
from scipy.ndimage import gaussian_filter

from skyshine.schemas.errors import InputError
from skyshine.tmm import export, open_tmm
from skyshine.tmm.features import shade as shade_module
from skyshine.tmm.features.cast_shade import CastShade, Fall
from skyshine.tmm.features.light import linear_light
from skyshine.tmm.features.shade import RelitTexture
from skyshine.tmm.images.texture import Texture
from skyshine.tmm.job.model import TextureJob

SIZE = 420
GAIN = np.array([4.5, 3.8, 2.8])  # sunlight and sky over the sky alone, as under a clear sky
GRASS, ROAD, ROOF = (0.10, 0.20, 0.06), (0.30, 0.30, 0.32), (0.45, 0.30, 0.24)
FOREST, WATER, ASPHALT = (0.030, 0.055, 0.028), (0.020, 0.040, 0.050), (0.05, 0.05, 0.055)
BOXES = [  # top, left, height, width, and texels of the shadow's length
    (60, 60, 50, 40, 26),
    (70, 230, 30, 70, 40),
    (200, 105, 40, 40, 30),
    (340, 300, 60, 30, 34),
    (350, 80, 30, 60, 24),
]
LURES = {  # what is dark and casts nothing
    "forest": (slice(190, 280), slice(210, 300), FOREST),
    "water": (slice(120, 180), slice(330, 400), WATER),
    "asphalt": (slice(20, 50), slice(340, 400), ASPHALT),
}


def lure(name):
    return LURES[name][:2]


def fall(azimuth, reach=128):
    angle = np.radians(azimuth)
    return Fall(-np.sin(angle), np.cos(angle), reach, azimuth)


def encoded(light):
    curve = np.where(light > 0.0031308, 1.055 * np.maximum(light, 0.0031308) ** (1 / 2.4) - 0.055, 12.92 * light)
    return np.rint(255 * np.clip(curve, 0, 1)).astype(np.uint8)


def scene(azimuth, boxes=BOXES, gain=GAIN, lures=True, hidden_by=None):
    """Pixels, light without any shade, and where shade lies on the ground."""
    random = np.random.default_rng(7)
    light = np.empty((SIZE, SIZE, 3))
    light[:] = GRASS
    light[:, 150:190] = ROAD
    light[290:320] = ROAD
    if lures:
        for rows, columns, colour in LURES.values():
            light[rows, columns] = colour
    x, y = fall(azimuth).x, fall(azimuth).y
    shaded, roofs = np.zeros((SIZE, SIZE), bool), np.zeros((SIZE, SIZE), bool)
    for top, left, height, width, length in boxes:
        footprint = np.zeros((SIZE, SIZE), bool)
        footprint[top : top + height, left : left + width] = True
        roofs |= footprint
        for step in range(1, length + 1):
            shaded |= np.roll(footprint, (round(step * y), round(step * x)), (0, 1))
    light[roofs] = ROOF
    shaded &= ~roofs
    fine, rough = (random.standard_normal((SIZE, SIZE, 1)) for _ in range(2))
    grain = np.exp(0.06 * fine + 0.72 * gaussian_filter(rough, (3, 3, 0)))
    lit = gaussian_filter(light, (0.7, 0.7, 0)) * grain
    hidden = gaussian_filter(shaded.astype(float), 0.8)[..., np.newaxis]
    if hidden_by is not None:  # the first box alone hides part of the Sun, as a thin crown does
        hidden[:160, :145] *= hidden_by
    return encoded(lit * (1 - hidden * (1 - 1 / np.array(gain)))), lit, shaded


def spots():
    """Dark spots on grass, by the very light of shade, that nothing casts."""
    _, lit, _ = scene(135, boxes=[], lures=False)
    rows, columns = np.indices((SIZE, SIZE))
    for top, left in np.random.default_rng(5).integers(20, SIZE - 20, (40, 2)):
        lit[(rows - top) ** 2 + (columns - left) ** 2 < 100] /= GAIN
    return encoded(lit)


def texture(pixels, valid=None):
    return Texture(pixels, np.ones(pixels.shape[:2], bool) if valid is None else valid, "srgb")


def found_in(pixels, azimuth, valid=None):
    image = texture(pixels, valid)
    found = CastShade.of(image, "made", fall(azimuth))
    return found, found.fraction(linear_light(pixels, "srgb"), image.valid)


@pytest.mark.parametrize("azimuth", [40, 135, 180, 250])
def test_shade_is_found_and_dark_things_that_cast_none_are_not(azimuth):
    pixels, _, shaded = scene(azimuth)
    found, fraction = found_in(pixels, azimuth)
    # Sides are means of smoothed logarithms over a least light, which keeps a tenth of the gain back.
    assert np.array(found.gain) == pytest.approx(0.9 * GAIN, rel=0.08)
    on_lures = np.zeros_like(shaded)
    for name in LURES:
        on_lures[lure(name)] = True
    # What is missed lies where a shadow leaves one ground for a brighter one, still in the shade.
    assert (fraction > 0.5)[shaded & ~on_lures].mean() > 0.75
    assert (fraction > 0.5)[~shaded & ~on_lures].mean() < 0.001
    for name in LURES:
        assert (fraction[lure(name)] > 0.5)[~shaded[lure(name)]].mean() < 0.02, name
    assert fraction.min() >= 0 and fraction.max() <= 1 and np.isfinite(fraction).all()


def test_an_azimuth_a_little_off_does_no_harm():
    pixels, _, shaded = scene(135)
    for azimuth in (123, 147):
        assert (found_in(pixels, azimuth)[1] > 0.5)[shaded].mean() > 0.7


@pytest.mark.parametrize(
    "pixels, azimuth",
    [
        (scene(135)[0], 315),  # shadows that would fall towards the Sun
        (scene(135, boxes=[])[0], 135),  # dark things alone
        (scene(135, boxes=[], lures=False)[0], 135),
        (scene(135, gain=np.array([2.0, 2.6, 3.4]))[0], 135),  # dark and redder than in sunlight
        (scene(135, gain=np.array([3.5, 3.5, 3.5]))[0], 135),  # dark and not bluer: tarmac beside walls, say
        (spots(), 135),
        (np.full((64, 64, 3), 90, np.uint8), 135),
        (np.random.default_rng(0).integers(0, 255, (64, 64, 3)).astype(np.uint8), 135),
        (np.zeros((1, 1, 3), np.uint8), 135),
        (np.zeros((1, 300, 3), np.uint8), 135),
    ],
    ids=["opposite", "no casters", "bare", "redder", "neutral", "spots", "flat", "noise", "one texel", "one row"],
)
def test_what_is_no_cast_shade_is_refused(pixels, azimuth):
    with pytest.raises(InputError, match=f"no shade that falls away from a Sun at azimuth {azimuth} degrees"):
        CastShade.of(texture(pixels), "made", fall(azimuth))


def test_the_photograph_without_shade_is_the_sunlit_one(tmp_path, write_image):
    pixels, lit, shaded = scene(135)
    relit = RelitTexture(tmp_path / write_image("cast.png", pixels), fall=fall(135))
    window, valid = relit.window(slice(0, SIZE), slice(0, SIZE))
    core = gaussian_filter(shaded.astype(float), 3) > 0.9
    before, after = (np.abs(values[core] - encoded(lit)[core].astype(float)).mean() for values in (pixels, window))
    assert core.sum() > 2000 and after < 0.35 * before and valid.all() and window.dtype == np.uint8


def test_tiles_meet_without_seams(tmp_path, write_image, monkeypatch):
    path = tmp_path / write_image("cast.png", scene(135)[0])
    whole = RelitTexture(path, fall=fall(135)).shade(slice(0, SIZE), slice(0, SIZE))
    monkeypatch.setattr(shade_module, "_TILE", 100)
    cut = RelitTexture(path, fall=fall(135))
    parts = [cut.shade(slice(top, top + 60), slice(0, SIZE)) for top in range(0, SIZE, 60)]
    assert np.abs(np.concatenate(parts) - whole).max() < 1e-5 and whole.max() > 0.9


def test_texels_without_data_are_in_no_shade_and_cast_none():
    pixels, _, shaded = scene(135)
    valid = np.ones((SIZE, SIZE), bool)
    valid[:, 300:] = False
    fraction = found_in(np.where(valid[..., np.newaxis], pixels, 0), 135, valid)[1]
    assert np.all(fraction[~valid] == 0)
    near = slice(None), slice(285, 300)
    assert (fraction[near] > 0.5)[~shaded[near]].mean() < 0.03
    assert (fraction > 0.5)[:, :280][shaded[:, :280]].mean() > 0.8


def test_an_image_without_data_is_refused():
    with pytest.raises(InputError, match="no shade that falls away"):
        found_in(np.zeros((64, 64, 3), np.uint8), 135, np.zeros((64, 64), bool))


def test_near_infrared_has_a_gain_of_its_own():
    pixels, lit, shaded = scene(135)
    infrared = lit.mean(axis=2) * np.where(shaded, 1 / 6.0, 1.0)
    four = np.concatenate([pixels, np.rint(255 * np.clip(infrared, 0, 1))[..., np.newaxis].astype(np.uint8)], axis=2)
    gain = found_in(four, 135)[0].gain
    assert len(gain) == 4 and gain[3] == pytest.approx(6.0, rel=0.15)


@pytest.mark.parametrize("hidden_by, stored", [(1.0, 1.0), (0.85, 0.85), (0.3, 0.0)])
def test_half_shade_counts_by_how_much_of_the_sun_is_hidden(hidden_by, stored):
    """A third of the Sun, as thin cloud and worn ground take too, is none."""
    pixels, _, shaded = scene(135, hidden_by=hidden_by)
    core = (gaussian_filter(shaded.astype(float), 3) > 0.9)[:160, :145]
    fraction = found_in(pixels, 135)[1][:160, :145]
    assert core.sum() > 300 and np.median(fraction[core]) == pytest.approx(stored, abs=0.06)


def test_part_of_the_sun_hidden_takes_part_of_its_light_back():
    found = CastShade(fall(0), (4.0, 3.0, 2.0), 0.0, (-3.0, 0.0), np.zeros((1, 1, 1), np.float32))
    lit = np.full((1, 1, 3), 0.4)
    for share in (0.0, 0.5, 1.0):
        dimmed = lit * (1 - share) + lit / np.array(found.gain) * share  # what a texel half in the shade shows
        assert found.relit(dimmed, np.full((1, 1), share)) == pytest.approx(lit)


def test_a_job_with_the_azimuth_stores_the_layer_and_the_material_beneath(tmp_path, write_image, build, library):
    pixels, _, shaded = scene(135, lures=False)
    write_image("cast.png", pixels)
    seeds = {
        "grass_green": [[[5, 5], [50, 5], [50, 50], [5, 50]]],
        "asphalt_road": [[[152, 5], [188, 5], [188, 50], [152, 50]]],
        "soil_sand": [[[232, 72], [298, 72], [298, 98], [232, 98]]],  # the roofs
    }
    common = {"image": "cast.png", "classifier": {"typicality_threshold": 1e-6}, "seeds": {"polygons": seeds}}
    built = build(TextureJob.model_validate({**common, "shade": {"sun_azimuth_deg": 135}}))
    with open_tmm(built.path) as file:
        stored, code = file.array("levels/0/shade"), file.array("levels/0/code")
    plain = build(TextureJob.model_validate(common), "plain.tmm.h5")
    core = gaussian_filter(shaded.astype(float), 2) > 0.9
    assert (stored > 127)[core].mean() > 0.8
    on_road = np.zeros_like(shaded)
    on_road[:, 150:190] = on_road[290:320] = True
    truth = np.where(on_road, library["asphalt_road"].code, library["grass_green"].code)
    assert (code == truth)[core].mean() > 0.95
    assert (code != 0).all() and np.median(plain.typicality[core]) <= np.median(built.typicality[core])


def test_the_layer_has_all_levels(tmp_path, write_image, build):
    write_image("cast.png", scene(135)[0])
    job = {"image": "cast.png", "material": "grass_green"}
    built = build(TextureJob.model_validate({**job, "shade": {"sun_azimuth_deg": 135}}))
    plain = build(TextureJob.model_validate(job), "plain.tmm.h5")
    with open_tmm(built.path) as file:
        assert file.has_shade and file.levels == 9
        whole = file.array("levels/0/shade").astype(float)
        for level in range(file.levels):
            rows, columns = file.size(level)
            blocks = whole[: rows << level, : columns << level]
            means = blocks.reshape(rows, 1 << level, columns, 1 << level).mean(axis=(1, 3))
            stored = file.array(f"levels/{level}/shade")
            # The last row and column of a level cover the rest, too.
            assert np.abs(stored[:-1, :-1] - means[:-1, :-1]).max(initial=0) <= 0.5 + 0.5 * level
        assert file.array("levels/8/shade")[0, 0] == pytest.approx(whole.mean(), abs=5)
    with open_tmm(plain.path) as file:
        assert not file.has_shade and file.shade(120.5, 80.5) == 0


def test_polygons_correct_the_shade(tmp_path, write_image, build):
    write_image("cast.png", scene(135)[0])
    job = {"image": "cast.png", "material": "grass_green"}

    def built(**drawn):
        return build(TextureJob.model_validate({**job, "shade": {"sun_azimuth_deg": 135, **drawn}})).path

    drawn = {
        "shaded": [[[10, 130], [40, 130], [40, 155], [10, 155]]],
        "sunlit": [[[0, 0], [420, 0], [420, 60], [0, 60]], [[30, 130], [40, 130], [40, 155], [30, 155]]],
    }
    with open_tmm(built(**drawn)) as file:
        assert file.shade(15.5, 140.5) == 1 and file.shade(35.5, 140.5) == 0
        assert not file.array("levels/0/shade")[:60].any() and file.array("levels/0/shade")[60:].any()
    with pytest.raises(InputError, match=r"a polygon of 'shade' has the vertex \[500, 5\]"):
        built(shaded=[[[0, 0], [500, 5], [5, 5]]])


def test_the_relit_photograph_and_the_shade_on_a_map_are_written(tmp_path, write_image, build, library):
    write_image("cast.png", scene(135)[0])
    (tmp_path / "cast.pgw").write_text("0.5 0 0 -0.5 100.25 199.75")
    job = {"image": "cast.png", "material": "grass_green"}
    built = build(TextureJob.model_validate({**job, "shade": {"sun_azimuth_deg": 135}}))
    (written,) = export(built.path, "relit", tmp_path / "out", library)
    window = RelitTexture(tmp_path / "cast.png", fall=fall(135)).window(slice(0, SIZE), slice(0, SIZE))[0]
    assert np.array_equal(tifffile.imread(written), window)
    shade = [path for path in export(built.path, "geotiff", tmp_path / "out", library) if "shade" in path.name]
    with open_tmm(built.path) as file:
        assert np.array_equal(tifffile.imread(shade[0]), file.array("levels/0/shade"))
    plain = build(TextureJob.model_validate(job), "plain.tmm.h5")
    with pytest.raises(InputError, match="has no layer of shade; classify the texture with 'shade'"):
        export(plain.path, "relit", tmp_path / "out", library)
