"""Ways to assign materials: whole texture, palette, rules, clusters, trained model; and overrides."""

import numpy as np
import pytest
from skimage.color import lab2rgb

from skyshine.schemas.errors import InputError
from skyshine.tmm.job.model import TextureJob
from skyshine.tmm.mapping import ways

GREEN, GREY, WATER, SOIL = "grass_green", "asphalt_road", "water_fresh", "soil_sand"


@pytest.fixture
def make(library, build):
    """Builds a texture that is assigned in a given way."""
    return lambda image, **way: build(TextureJob.model_validate({"image": image, **way}))


@pytest.fixture
def four(write_image):
    """Four columns of two texels: pure red, green, blue, and a red one off by 3."""
    colours = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [252, 0, 0]], np.uint8)
    return write_image("four.png", np.broadcast_to(colours, (2, 4, 3)).copy())


def test_whole_texture(make, two_halves, library):
    result = make(two_halves, material=GREEN)
    assert (result.code == library[GREEN].code).all() and (result.confidence == 1).all()
    assert result.written.usage.tolist() == [1.0]


def test_exact_palette(make, four, library):
    palette = {"#FF0000": SOIL, "#00FF00": GREEN, "#0000FF": WATER}
    result = make(four, palette={"colours": palette})
    assert result.code[0].tolist() == [library[name].code for name in (SOIL, GREEN, WATER)] + [0]
    assert result.confidence[0].tolist() == [1, 1, 1, 0]


def test_nearest_palette_gives_two_colours_one_material(make, four, library):
    palette = {"#FF0000": SOIL, "#00FF00": GREEN, "#0000FF": SOIL}
    result = make(four, palette={"colours": palette, "match": "nearest"})
    assert result.code[0].tolist() == [library[name].code for name in (SOIL, GREEN, SOIL, SOIL)]
    ((_, _, _, found),) = result.map.windows()
    assert found.typicality[0, 0] == 1 and 0 < found.typicality[0, 3] < 1


def test_palette_of_sixteen_bit_grey(make, write_image, library):
    image = write_image("deep.tif", np.array([[[300], [40000], [5]]], np.uint16), "uint16")
    result = make(image, palette={"colours": {"300": SOIL, "40000": GREEN}})
    assert result.code[0].tolist() == [library[SOIL].code, library[GREEN].code, 0]


def test_palette_beyond_the_type(make, four):
    with pytest.raises(InputError, match="values to 255; the palette's grey level 300"):
        make(four, palette={"colours": {"300": SOIL}})


def test_a_palette_names_no_near_infrared(make, write_image):
    image = write_image("infrared.tif", np.full((2, 2, 4), 100, np.uint8))
    with pytest.raises(InputError, match="has near infrared, which a palette does not name"):
        make(image, near_infrared="4", palette={"colours": {"#646464": SOIL}, "match": "nearest"})


def test_rules_take_the_first_that_holds(make, write_image, library):
    lab = np.array([[20.0, 0, -20], [60, 0, 0], [60, -40, 30], [90, 0, 0]])
    image = write_image("lab.png", np.rint(255 * lab2rgb(lab[np.newaxis])).astype(np.uint8))
    rules = [
        {"material": WATER, "when": {"lightness": {"below": 30}, "b": {"below": -5}}},
        {"material": GREEN, "when": {"hue": {"at_least": 120, "below": 180}, "chroma": {"at_least": 20}}},
        {"material": GREY, "when": {"lightness": {"below": 80}}},
    ]
    result = make(image, rules={"rules": rules})
    assert result.code[0].tolist() == [library[name].code for name in (WATER, GREY, GREEN)] + [0]


def test_rules_on_height_and_ndvi(make, write_image, library):
    values = np.full((1, 4, 4), 100, np.uint8)
    values[0, :, 3] = 100, 250, 250, 250
    image = write_image("infrared.tif", values)
    height = write_image("height.tif", np.array([[[5.0], [0.5], [9.0], [np.nan]]], np.float32), "float")
    rules = [
        {"material": "deciduous", "when": {"ndvi": {"at_least": 0.3}, "height": {"at_least": 2}}},
        {"material": GREEN, "when": {"ndvi": {"at_least": 0.3}, "height": {"below": 2}}},
        {"material": GREY, "when": {"ndvi": {"below": 0.3}}},
    ]
    result = make(image, near_infrared="4", rules={"rules": rules, "layers": {"height": height}})
    assert result.code[0].tolist() == [library[name].code for name in (GREY, GREEN, "deciduous")] + [0]
    with pytest.raises(InputError, match="ask for ndvi; say which channel"):
        make(image, rules={"rules": rules, "layers": {"height": height}})


def test_layer_of_another_size(make, four, write_image):
    height = write_image("height.png", np.zeros((3, 4, 1), np.uint8))
    rules = [{"material": GREY, "when": {"height": {"below": 2}}}]
    with pytest.raises(InputError, match="the layer is 4 x 3; allowed: the texture's 4 x 2"):
        make(four, rules={"rules": rules, "layers": {"height": height}})


@pytest.mark.parametrize(
    "way, message",
    [
        ({}, "found none of the ways"),
        ({"material": GREEN, "seeds": {"polygons": {GREY: [[[1, 1]]]}}}, "found material and seeds of the ways"),
        (
            {"rules": {"rules": [{"material": GREY, "when": {"hight": {"below": 1}}}]}},
            "did you mean 'lightness'|unknown quantity",
        ),
        ({"rules": {"rules": [{"material": GREY, "when": {"hue": {}}}]}}, "neither at_least nor below"),
        ({"rules": {"rules": [{"material": GREY, "when": {"hue": {"at_least": 9, "below": 3}}}]}}, "at_least < below"),
        ({"clusters": {"count": 2, "names": {3: GREY}}}, "cluster 3; allowed: 1 to 2"),
    ],
)
def test_wrong_ways(way, message):
    with pytest.raises(ValueError, match=message):
        TextureJob.model_validate({"image": "a.png", **way})


def test_clusters_are_numbered_from_the_darkest(make, write_image, library):
    values = np.repeat(np.array([200, 20, 110], np.uint8), 300).reshape(30, 30, 1)
    values = values + np.random.default_rng(3).integers(0, 5, (30, 30, 1), dtype=np.uint8)
    image = write_image("three.png", values)
    result = make(image, clusters={"count": 3, "names": {1: WATER, 3: SOIL}}, classifier={"radius": 0})
    found = np.where(values[..., 0] < 50, library[WATER].code, np.where(values[..., 0] > 150, library[SOIL].code, 0))
    np.testing.assert_array_equal(result.code, found)


def test_clusters_are_found_from_a_sample_of_bounded_size(make, write_image, monkeypatch):
    """Each of 60 x 200 texels is drawn with a chance of 1 in 12: 1,000, with a standard deviation of 30."""
    sizes = []
    fitted = ways.fit
    monkeypatch.setattr(ways, "CLUSTER_SAMPLE", 1000)
    monkeypatch.setattr(ways, "fit", lambda colours, *others: sizes.append(len(colours)) or fitted(colours, *others))
    values = np.random.default_rng(4).integers(0, 255, (60, 200, 3), dtype=np.uint8)
    make(write_image("wide.png", values), clusters={"count": 2, "names": {1: WATER}})
    assert sizes == [pytest.approx(1000, abs=120)]


def test_more_clusters_than_colours(make, write_image, library):
    result = make(write_image("flat.png", np.full((4, 4, 3), 80, np.uint8)), clusters={"count": 5, "names": {1: GREY}})
    assert (result.code == library[GREY].code).all()


def test_clusters_without_names_are_refused(make, write_image):
    """Their colours are looked at before: no database is without a material."""
    values = np.repeat(np.array([200, 20], np.uint8), 128).reshape(16, 16, 1)
    with pytest.raises(InputError, match="names no material; allowed: one or more.*'tmm check' shows their colours"):
        make(write_image("two.png", values), clusters={"count": 2})


def test_overrides_win_and_later_polygons_win(make, two_halves, write_image, library):
    labels = np.zeros((20, 40, 1), np.uint8)
    labels[10:, :20] = 7
    overrides = {
        "polygons": {WATER: [[[0, 0], [4, 0], [4, 20], [0, 20]]], SOIL: [[[0, 0], [2, 0], [2, 2], [0, 2]], [[40, 20]]]},
        "labels": {"image": write_image("mask.png", labels), "palette": {"7": GREY}},
    }
    result = make(two_halves, material=GREEN, overrides=overrides)
    expected = np.full((20, 40), library[GREEN].code)
    expected[10:, :20], expected[:, :4], expected[:2, :2], expected[19, 39] = (
        library[name].code for name in (GREY, WATER, SOIL, SOIL)
    )
    # The outer vertices of a polygon stand in texels of their own.
    expected[0, 4], expected[19, 4], expected[0, 2], expected[2, 2], expected[2, 0] = (
        library[name].code for name in (WATER, WATER, SOIL, SOIL, SOIL)
    )
    np.testing.assert_array_equal(result.code, expected)


def test_overrides_across_windows(make, two_halves, library, monkeypatch):
    overrides = {"polygons": {WATER: [[[3, 3], [37, 5], [20, 19]]], GREY: [[[30.2, 12.7]]]}}
    whole = make(two_halves, material=GREEN, overrides=overrides).code
    sizes = {"mapping.texture_map.BAND": 4, "mapping.texture_map.STRIP": 6}
    for name, size in (sizes | {"database.layout.CHUNK": 2, "mapping.write.CHUNK": 2}).items():
        monkeypatch.setattr(f"skyshine.tmm.{name}", size)
    np.testing.assert_array_equal(make(two_halves, material=GREEN, overrides=overrides).code, whole)
