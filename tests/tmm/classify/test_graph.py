"""Seeds, alone and with a library: superpixels, their graph, the share of each, and what is found at full size."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.tmm.classify import graph
from skyshine.tmm.classify.gaussian import fit
from skyshine.tmm.classify.graph import TYPICAL_RADIUS, GraphMapper, clicks, seed_shares, survey
from skyshine.tmm.classify.model_file import write_model
from skyshine.tmm.classify.superpixels import STIFFNESS, Superpixels, find_superpixels
from skyshine.tmm.classify.trained import Network, TrainedModel
from skyshine.tmm.classify.translation import and_unknown, library_classes, translated
from skyshine.tmm.classify.typicality import Boxes, Typicality, fit_boxes
from skyshine.tmm.features.colour import DistinctColours, to_coordinates
from skyshine.tmm.features.textured import features, light_planes, names
from skyshine.tmm.images.texture import Texture

GREEN, GREY = "grass_green", "asphalt_road"
# Seeds of one texel of each of two materials, none of them asked for.
TWO = np.array([9, 80]), np.array([40, 40]), np.array([0, 1]), np.zeros(2, bool)


def _chain(weight=1.0):
    """Three superpixels of one texel, in a row."""
    pairs = np.array([[0, 1], [1, 2]])
    return Superpixels(np.arange(3).reshape(1, 3), np.ones(3), pairs, np.full(2, weight))


def test_spread_solves_the_least_squares():
    """Against the minimum of the squares themselves, by their dense normal equations."""
    random = np.random.default_rng(0)
    first = random.dirichlet((1, 1), 3)
    known, hold, weight = np.array([[1.0, 0], [0, 0], [0, 1]]), np.array([50.0, 0, 10]), 0.7
    rows = [np.eye(3), np.sqrt(hold)[:, np.newaxis] * np.eye(3), np.sqrt(weight) * np.array([[1, -1, 0], [0, 1, -1]])]
    right = [first, np.sqrt(hold)[:, np.newaxis] * known, np.zeros((2, 2))]
    least = np.linalg.lstsq(np.concatenate(rows), np.concatenate(right), rcond=None)[0]
    np.testing.assert_allclose(_chain(weight).spread(first, known, hold), least, rtol=1e-9)


def test_without_edges_and_seeds_nothing_changes():
    first = np.array([[0.2, 0.8], [0.5, 0.5], [1, 0]])
    alone = Superpixels(np.arange(3).reshape(1, 3), np.ones(3), np.empty((2, 0), int), np.empty(0))
    np.testing.assert_allclose(alone.spread(first, np.zeros((3, 2)), np.zeros(3)), first)


@pytest.mark.parametrize("size", [(1, 1), (1, 40), (7, 3), (64, 64)])
def test_superpixels_cover_any_size(size):
    lab = np.random.default_rng(1).normal(50, 20, (3, *size)).astype(np.float32)
    found = find_superpixels(lab, lab)
    assert found.label.shape == size and found.size.sum() == lab[0].size
    assert set(np.unique(found.label)) == set(range(len(found.size)))
    assert ((found.weight > 0) & (found.weight <= STIFFNESS)).all() and (found.pairs[0] < found.pairs[1]).all()
    np.testing.assert_allclose(found.size @ found.mean(lab), lab.sum(axis=(1, 2)), rtol=1e-5)


def test_clicks_are_counted_by_place():
    drawn = np.full((9, 9), -1)
    drawn[0:2, 0:2], drawn[5:7, 5:7], drawn[8, 0:3] = 0, 0, 1
    assert clicks(drawn, 3).tolist() == [2, 1, 0]


@pytest.mark.parametrize("step", [2, 3])
def test_features_of_every_few_texels_are_those_of_all(step):
    pixels = np.random.default_rng(2).integers(0, 255, (50, 60, 3), dtype=np.uint8)
    planes = [part.reshape(3, 50, 60) for part in light_planes(pixels.reshape(-1, 3), "srgb")]
    valid = np.ones((50, 60), bool)
    whole = features(*(part.copy() for part in planes), valid)
    np.testing.assert_allclose(features(*planes, valid, step), whole[:, ::step, ::step], rtol=1e-4, atol=1e-3)


@pytest.mark.parametrize("columns", [17, 70, 1000])
@pytest.mark.parametrize("step", [1, 3])
def test_survey_in_bands_is_that_of_the_whole(monkeypatch, step, columns):
    """With bands far lower than the texture, and a grid whose steps do not divide it."""
    pixels = np.random.default_rng(3).integers(0, 255, (100, 70, 3), dtype=np.uint8)
    texture = Texture(pixels, np.ones((100, 70), bool), "srgb")
    model = _model(pixels[:2, 0])
    monkeypatch.setattr(graph, "GRID_TEXELS", 7000 / step**2)
    whole = survey(texture, DistinctColours(texture), model)
    monkeypatch.setattr(graph, "BAND_TEXELS", 70 * 20)
    monkeypatch.setattr(graph, "BAND_COLUMNS", columns)
    parts = survey(texture, DistinctColours(texture), model)
    assert whole.step == parts.step == step
    np.testing.assert_allclose(parts.stack, whole.stack, rtol=1e-3, atol=2e-2)
    np.testing.assert_array_equal(parts.coordinates, whole.coordinates)


def _colours(colours, materials=(GREEN, GREY)):
    return fit(to_coordinates(colours, "srgb"), np.arange(len(materials)), materials)


def _model(colours, materials=(GREEN, GREY)):
    """A library model that tells two colours apart by the plane between them."""
    first, second = to_coordinates(colours, "srgb")
    normal = (second - first) / np.linalg.norm(second - first)
    inner = np.zeros((len(names()), 2), np.float32)
    inner[:3] = np.stack([normal, -normal], axis=1)
    middle = normal @ (first + second) / 2
    outer = np.array([[-0.2, 0.2], [0.2, -0.2]], np.float32)
    centred = np.zeros(len(names()), np.float32), np.ones(len(names()), np.float32)
    network = Network(*centred, inner, np.array([-middle, middle], np.float32), outer, np.zeros(2, np.float32))
    return TrainedModel(materials, _colours(colours, materials), network)


def _mapper(texture, surveyed, model, classes, seeds):
    """Seeds of two materials, whose boxes are told apart by nothing."""
    boxes = Boxes(texture, DistinctColours(texture), TYPICAL_RADIUS)
    typical = Typicality(boxes, fit_boxes(np.zeros((2, boxes.dimensions)), np.arange(2), np.arange(2)))
    return GraphMapper(texture, DistinctColours(texture), surveyed, model.colour, classes, seeds, typical)


@pytest.fixture
def halves():
    """Green above, grey below, 96 x 80 with noise, and a library that knows both."""
    random = np.random.default_rng(4)
    values = np.empty((96, 80, 3))
    values[:48], values[48:] = (70, 130, 60), (120, 120, 125)
    pixels = np.clip(values + random.normal(0, 12, values.shape), 0, 255).astype(np.uint8)
    return Texture(pixels, np.ones((96, 80), bool), "srgb"), _model(
        np.array([[70, 130, 60], [120, 120, 125]], np.uint8)
    )


@pytest.mark.parametrize("grid", [1 << 20, 1000])
def test_one_texel_a_material_finds_both_halves(halves, monkeypatch, grid):
    texture, model = halves
    monkeypatch.setattr(graph, "GRID_TEXELS", grid)
    seeds = TWO
    mapper = _mapper(texture, survey(texture, DistinctColours(texture), model), model, np.eye(2), seeds)
    found = mapper.window(0, 96, 0, 80)
    edge = 10
    assert (found.material[: 48 - edge] == 0).all() and (found.material[48 + edge :] == 1).all()
    assert ((found.confidence >= 0.5) & (found.confidence <= 1)).all()
    part = mapper.window(30, 61, 7, 50)
    np.testing.assert_array_equal(part.material, found.material[30:61, 7:50])
    np.testing.assert_allclose(part.confidence, found.confidence[30:61, 7:50], atol=1e-6)


def test_seeds_win_over_a_library_that_is_wrong(halves):
    """A library that takes each for the other gives way where seeds are, and to many of them."""
    texture, model = halves
    rows, columns = np.mgrid[4:92:8, 4:76:8].reshape(2, -1)
    block = np.stack([rows, columns])[:, :, np.newaxis] + np.mgrid[-1:2, -1:2].reshape(2, 1, 9)
    rows, columns = block.reshape(2, -1)
    seeds = rows, columns, (rows >= 48).astype(int), np.zeros(len(rows), bool)
    surveyed = survey(texture, DistinctColours(texture), model)
    mapper = _mapper(texture, surveyed, model, np.eye(2)[::-1], seeds)
    assert (mapper.window(0, 96, 0, 80).material[rows, columns] == seeds[2]).mean() > 0.95


def test_shares_without_edges_by_hand(halves):
    """Of a superpixel far from seeds: posteriors to the powers of their shares, as sure as they are right."""
    texture, model = halves
    surveyed = survey(texture, DistinctColours(texture), model)
    label = surveyed.superpixels.label
    bare = Superpixels(label, surveyed.superpixels.size, np.empty((2, 0), int), np.empty(0))
    alone, seeds = replace(surveyed, superpixels=bare), TWO
    heard = surveyed.library[label[seeds[0], seeds[1]]]
    word = translated(surveyed.library, np.eye(2), heard, np.ones(2))
    drawn = np.full(label.shape, -1)
    drawn[seeds[0], seeds[1]] = seeds[2]
    textured = graph._textured(surveyed, drawn, model.colour.log_prior, 1.0)
    both = np.sqrt(np.maximum(surveyed.posterior(model.colour), 0.02) * np.maximum(textured, 0.02))
    both /= both.sum(axis=1, keepdims=True)
    odds = 0.3 * np.log(np.maximum(both, 0.1)) + 0.7 * np.log(word)
    odds = 2.5 * (odds[:, 0] - odds[:, 1])
    far = np.setdiff1d(label, label[seeds[0], seeds[1]])
    found = seed_shares(alone, model.colour, np.eye(2), seeds)
    np.testing.assert_allclose(found[far, 0], (1 / (1 + np.exp(-odds)))[far], rtol=1e-6)
    # Seeds by themselves are as sure as they say.
    own = np.maximum(both, 0.1)
    found = seed_shares(replace(alone, library=np.empty((label.max() + 1, 0))), model.colour, np.empty((0, 2)), seeds)
    np.testing.assert_allclose(found[far], (own / own.sum(axis=1, keepdims=True))[far], rtol=1e-6)


def test_large_materials_weigh_more_the_more_places_there_are(halves):
    """Nine of ten superpixels look like one material: where both are as likely by themselves, it is that one, by the
    power of (n - 1) / (n + 5); not where the places were asked for.
    """
    texture, model = halves
    surveyed = survey(texture, DistinctColours(texture), model)
    label = np.broadcast_to(np.arange(80) // 8, (96, 80))
    bare = Superpixels(label, np.full(10, 768.0), np.empty((2, 0), int), np.empty(0))
    alone = replace(surveyed, superpixels=bare, library=np.empty((10, 0)))
    rows, columns = np.array([5, 35, 65, 5, 35, 65]), np.array([0, 0, 0, 79, 79, 79])
    seeds = rows, columns, np.repeat([0, 1], 3)
    even = seed_shares(alone, model.colour, np.empty((0, 2)), (*seeds, np.ones(6, bool)))
    weighed = seed_shares(alone, model.colour, np.empty((0, 2)), (*seeds, np.zeros(6, bool)))
    extent = even[:, 0].mean(), even[:, 1].mean()
    odds = even[1:9, 0] / even[1:9, 1] * (extent[0] / extent[1]) ** (2 / 8)
    np.testing.assert_allclose((weighed[:, 0] / weighed[:, 1])[1:9], odds, rtol=0.02)


def test_what_a_library_knows_and_no_seed_names_is_unknown(halves):
    """The library tells grass from road; seeds of two kinds of grass leave the road to no material."""
    texture, model = halves
    surveyed = survey(texture, DistinctColours(texture), model)
    seeds = np.array([9, 30]), np.array([40, 10]), np.array([0, 1]), np.zeros(2, bool)
    materials = (GREEN, "grass_dry")
    classes = library_classes(model.names, materials, dict.fromkeys(materials, "vegetation"))
    classes = and_unknown(classes, materials)
    assert classes.tolist() == [[1, 0, 0], [0, 0, 1]]
    greens = _colours(np.array([[70, 130, 60], [75, 135, 60]], np.uint8), (GREEN, "grass_dry"))
    mapper = _mapper(texture, surveyed, replace(model, colour=greens), classes, seeds)
    assert mapper.names == (GREEN, "grass_dry", "unknown")
    found = mapper.window(0, 96, 0, 80).material
    assert (found[:38] != 2).all() and (found[58:] == 2).all()


def test_seeds_and_model_in_a_job(build, job, two_halves, tmp_path, library):
    colours = np.array([[60, 140, 50], [120, 120, 125]], np.uint8)
    write_model(_model(colours, ("grass_dry", GREY)), tmp_path / "library.h5", "job", "1", {})
    result = build(job(two_halves, model="library.h5"))
    assert result.map.job.way == "seeds" and set(result.map.names) == {GREEN, GREY}
    assert (result.code[:, :17] == library[GREEN].code).all() and (result.code[:, 23:] == library[GREY].code).all()
    assert "library.h5" in result.map.files


def test_seeds_alone_where_the_library_knows_none_of_their_materials(halves):
    """The posterior of the seeds then decides far from them, where no edge reaches."""
    texture, model = halves
    surveyed = survey(texture, DistinctColours(texture), model)
    bare = Superpixels(surveyed.superpixels.label, surveyed.superpixels.size, np.empty((2, 0), int), np.empty(0))
    alone = replace(surveyed, superpixels=bare)
    seeds = TWO
    mapper = _mapper(texture, alone, model, np.zeros((2, 2)), seeds)
    found = mapper.window(0, 96, 0, 80).material
    assert (found[:38] == 0).all() and (found[58:] == 1).all()
