"""Seeds: polygons, GeoJSON, label images, and what is wrong with them."""

import json
import tracemalloc

import numpy as np
import pytest

from skyshine.schemas.errors import InputError
from skyshine.tmm.inputs.load import load_texture
from skyshine.tmm.inputs.named_materials import job_materials
from skyshine.tmm.inputs.seeds import Claims, unlabelled
from skyshine.tmm.mapping.texture_map import map_texture

GREEN, GREY = "grass_green", "asphalt_road"


def _texels(job, folder, library, name):
    *_, seeds = load_texture(job, folder, library)
    mine = seeds.material == seeds.names.index(name)
    return set(zip(seeds.columns[mine].tolist(), seeds.rows[mine].tolist(), strict=True))


def test_a_rectangle_holds_the_texels_whose_centres_it_holds(job, two_halves, tmp_path, library):
    square = [[2.2, 3.2], [5.8, 3.2], [5.8, 4.9], [2.2, 4.9]]
    found = _texels(job(two_halves, {GREEN: [square], GREY: [[[30, 5]]]}), tmp_path, library, GREEN)
    assert found == {(x, y) for x in range(2, 6) for y in (3, 4)}


def test_a_vertex_alone_and_one_on_the_far_edge(job, two_halves, tmp_path, library):
    seeds = job(two_halves, {GREEN: [[[0, 0]], [[3.9, 7.1]]], GREY: [[[40, 20]]]})
    assert _texels(seeds, tmp_path, library, GREEN) == {(0, 0), (3, 7)}
    assert _texels(seeds, tmp_path, library, GREY) == {(39, 19)}


def _feature(kind, coordinates, name):
    return {"type": "Feature", "properties": {"material": name}, "geometry": {"type": kind, "coordinates": coordinates}}


def test_geojson_with_a_hole(job, two_halves, tmp_path, library):
    outer = [[2, 2], [10, 2], [10, 10], [2, 10], [2, 2]]
    hole = [[4, 4], [8, 4], [8, 8], [4, 8], [4, 4]]
    features = [_feature("Polygon", [outer, hole], GREEN), _feature("Point", [30, 5], GREY)]
    features.append(_feature("MultiPolygon", [[[[31, 2], [34, 2], [34, 4], [31, 4]]]], GREY))
    (tmp_path / "seeds.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    mapped = job(two_halves, seeds={"file": "seeds.geojson"})
    green = _texels(mapped, tmp_path, library, GREEN)
    assert (5, 5) not in green and (3, 3) in green and len(green - {(10, 2), (10, 10), (2, 10)}) == 64 - 16
    assert job_materials(mapped, tmp_path) == (GREY, GREEN)
    assert len(_texels(mapped, tmp_path, library, GREY)) >= 7


@pytest.mark.parametrize(
    "content, message",
    [
        ("{", "not valid YAML"),
        ('{"type": "FeatureCollection"}', "'features' is missing"),
        (json.dumps({"type": "FeatureCollection", "features": [_feature("LineString", [[0, 0]], GREEN)]}), "Polygon"),
    ],
)
def test_bad_geojson(job, two_halves, tmp_path, library, content, message):
    (tmp_path / "seeds.geojson").write_text(content)
    with pytest.raises(InputError, match=message):
        map_texture(job(two_halves, seeds={"file": "seeds.geojson"}), tmp_path, library)


def _labels(image, palette):
    return {"labels": {"image": image, "palette": palette}}


def test_colour_labels(job, two_halves, write_image, tmp_path, library):
    values = np.zeros((20, 40, 3), np.uint8)
    values[:, :10], values[:, 30:] = (0x32, 0xFF, 0xA7), (0x6D, 0x32, 0xFF)
    image = write_image("labels.png", values)
    mapped = job(two_halves, seeds=_labels(image, {"#32FFA7": GREEN, "#6d32ff": GREY}))
    result = map_texture(mapped, tmp_path, library)
    assert (result.seeds.material == result.names.index(GREEN)).sum() == 200
    assert result.quality.quality.tested == 0  # each material has one place
    assert result.files.keys() == {"labels.png"}


def test_grey_labels(job, two_halves, write_image, tmp_path, library):
    values = np.zeros((20, 40, 1), np.uint8)
    values[:, :10], values[:, 30:] = 40, 80
    mapped = job(two_halves, seeds=_labels(write_image("labels.png", values), {40: GREEN, "80": GREY}))
    assert len(_texels(mapped, tmp_path, library, GREY)) == 200


@pytest.mark.parametrize("blocks", [4096, 5])
def test_what_is_painted_in_one_piece_is_one_place(job, write_image, tmp_path, library, monkeypatch, blocks):
    """Also where few of its blocks of 32 texels are drawn; a polygon that touches it belongs to it."""
    monkeypatch.setattr("skyshine.tmm.inputs.seeds.BLOCKS", blocks)
    image = write_image("large.png", np.zeros((300, 420, 3), np.uint8))
    values = np.zeros((300, 420, 1), np.uint8)
    values[:, :160], values[:, 240:400], values[100:130, 200:210], values[0, 200:202] = 7, 7, 9, 9
    seeds = _labels(write_image("labels.png", values), {7: GREEN, 9: GREY})
    seeds |= {"polygons": {GREEN: [[[158, 5], [170, 5], [170, 9], [158, 9]]], GREY: [[[209.5, 130.5]]]}}
    *_, read = load_texture(job(image, seeds=seeds), tmp_path, library)
    # Of grass two fields, one with its polygon; of asphalt a square, to which the lone texel belongs, and two texels.
    places = dict(zip(read.names, read.separate_places.tolist(), strict=True))
    assert places == {GREEN: 2 if blocks == 4096 else 3, GREY: 2}


def test_labels_of_another_size(job, two_halves, write_image, tmp_path, library):
    image = write_image("labels.png", np.zeros((20, 41, 3), np.uint8))
    with pytest.raises(InputError, match="label image is 41 x 20; allowed: the texture's 40 x 20"):
        map_texture(job(two_halves, seeds=_labels(image, {"#000000": GREEN})), tmp_path, library)


def test_a_shared_palette_may_have_more_materials_than_a_texture(job, two_halves, write_image, tmp_path, library):
    image = write_image("labels.png", np.zeros((20, 40, 3), np.uint8))
    mapped = job(two_halves, seeds=_labels(image, {"#000000": GREEN, "#FFFFFF": GREY}))
    *_, seeds = load_texture(mapped, tmp_path, library)
    assert seeds.names == (GREEN,) and not seeds.material.any() and unlabelled(mapped, seeds) == (GREY,)


def test_the_materials_left_keep_their_texels(job, two_halves, write_image, tmp_path, library):
    labels = np.zeros((20, 40, 3), np.uint8)
    labels[:, 20:] = 255
    image = write_image("labels.png", labels)
    palette = {"#000000": GREEN, "#808080": "concrete", "#FFFFFF": GREY}
    mapped = job(two_halves, seeds=_labels(image, palette), classifier={"radius": 0})
    *_, seeds = load_texture(mapped, tmp_path, library)
    assert unlabelled(mapped, seeds) == ("concrete",) and {*seeds.names} == {GREEN, GREY}
    assert (seeds.columns[seeds.material == seeds.names.index(GREY)] >= 20).all()
    found = map_texture(mapped, tmp_path, library)
    code = next(found.windows())[2].code
    assert code[0, 0] == library[GREEN].code and code[0, -1] == library[GREY].code


def test_labels_of_no_material_at_all(job, two_halves, write_image, tmp_path, library):
    image = write_image("labels.png", np.full((20, 40, 3), 7, np.uint8))
    with pytest.raises(InputError, match="'asphalt_road' of 'halves' has no seed texel left"):
        map_texture(job(two_halves, seeds=_labels(image, {"#000000": GREEN, "#FFFFFF": GREY})), tmp_path, library)


def test_overlap_is_left_out_and_counted(job, two_halves, tmp_path, library):
    left, right = [[2, 2], [12, 2], [12, 8], [2, 8]], [[9, 2], [30, 2], [30, 8], [9, 8]]
    *_, seeds = load_texture(job(two_halves, {GREEN: [left], GREY: [right]}), tmp_path, library)
    assert seeds.conflicting >= 18
    both = np.isin(seeds.columns, (9, 10, 11)) & (seeds.rows >= 2) & (seeds.rows < 8)
    assert not both.any()


def test_complete_overlap(job, two_halves, tmp_path, library):
    square = [[2, 2], [12, 2], [12, 8], [2, 8]]
    with pytest.raises(InputError, match="no seed texel left"):
        map_texture(job(two_halves, {GREEN: [square], GREY: [square]}), tmp_path, library)


def test_beyond_the_image(job, two_halves, tmp_path, library):
    with pytest.raises(InputError, match=r"vertex \[41, 3\]; allowed: pixel coordinates within the image of 40 x 20"):
        map_texture(job(two_halves, {GREEN: [[[1, 1], [41, 3], [5, 5]]]}), tmp_path, library)


def test_unknown_material(job, two_halves, tmp_path, library):
    with pytest.raises(InputError, match="unknown material 'gras_green'; did you mean 'grass_green'"):
        map_texture(job(two_halves, {"gras_green": [[[1, 1]]]}), tmp_path, library)


def test_prior_of_a_material_without_seeds(job, two_halves, tmp_path, library):
    with pytest.raises(InputError, match="prior for 'concrete', which has no seeds"):
        map_texture(job(two_halves, classifier={"prior": {"concrete": 2}}), tmp_path, library)


def test_merged_claims_do_not_depend_on_when_they_are_merged(monkeypatch):
    random = np.random.default_rng(4)
    claimed = [(random.integers(0, 60, 25), material, shape) for shape, material in enumerate((0, 1, 0, 2, 1))]

    def merged(limit: int):
        monkeypatch.setattr("skyshine.tmm.inputs.seeds.MERGED_CLAIMS", limit)
        claims = Claims()
        for texels, material, shape in claimed:
            claims.add(texels, np.full_like(texels, material), np.full_like(texels, shape), shape == 3)
        return claims.merged()

    expected = {}
    for texels, material, shape in claimed:
        for texel in texels.tolist():
            low, high, first, asked = expected.get(texel, (material, material, shape, 1))
            expected[texel] = min(low, material), max(high, material), first, min(asked, int(shape == 3))
    for limit in (1, 40, 1 << 22):
        assert {texel: tuple(rest) for texel, *rest in merged(limit).T.tolist()} == expected


def test_polygons_on_top_of_each_other_take_no_more_memory_than_one(monkeypatch):
    monkeypatch.setattr("skyshine.tmm.inputs.seeds.MERGED_CLAIMS", 1 << 18)
    texels, claims = np.arange(120_000), Claims()
    tracemalloc.start()
    for region in range(60):
        claims.add(texels, np.zeros_like(texels), np.full_like(texels, region))
    assert claims.merged().shape == (5, 120_000) and not claims.merged()[3].any()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 75e6  # 60 x 120,000 claims of 40 bytes take 290 MB, and as much again while they are sorted
