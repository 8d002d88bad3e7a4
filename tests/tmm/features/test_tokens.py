"""Features of image encoders in ONNX: small ones with known weights, made here, and what is refused."""

import hashlib
import json
import sys
from dataclasses import replace

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from skyshine.mat.tables.verify import problems as mat_problems
from skyshine.schemas.errors import InputError
from skyshine.tmm.classify.gaussian import GaussianModel
from skyshine.tmm.classify.model_file import read_model, write_model
from skyshine.tmm.classify.trained import Network, TrainedModel
from skyshine.tmm.cli import main
from skyshine.tmm.features.textured import names
from skyshine.tmm.features.token_basis import EncoderIdentity, TokenBasis
from skyshine.tmm.features.tokens import TILE, Encoder, TokenFeatures
from skyshine.tmm.images.texture import TextureFile
from skyshine.tmm.job.model import TextureJob, TmmJob
from skyshine.tmm.mapping.run import check
from skyshine.tmm.mapping.suggest import suggest
from skyshine.tmm.mapping.texture_map import map_texture
from skyshine.tmm.training.library import library_tokens

MEAN, DEVIATION = np.array([0.485, 0.456, 0.406]), np.array([0.229, 0.224, 0.225])


def patches(weight):
    """A patch embedding: a convolution (C, 3, side, side) whose step is its side."""
    side = weight.shape[-1]
    return [("Conv", ("image", "w"), ("tokens",), {"strides": [side, side]})], {"w": weight.astype(np.float32)}


def averages(side):
    """Mean of red, and of green, over patches."""
    weight = np.zeros((2, 3, side, side))
    weight[0, 0] = weight[1, 1] = 1 / side**2
    return patches(weight)


@pytest.fixture
def ramp(write_image, tmp_path):
    """16 bit sRGB, red rising to the right and green downwards, 600 x 900."""
    rows, columns = np.mgrid[:600, :900]
    values = np.stack([columns / 900, rows / 600, np.full(rows.shape, 0.4)], axis=-1)
    write_image("ramp.png", np.rint(values * 65535).astype(np.uint16), "uint16")
    return TextureFile(tmp_path / "ramp.png"), values


@pytest.mark.parametrize("size", [("h", "w"), (112, 112), (112, "w")])
def test_a_convolution_of_known_weights_at_each_texel(encoder, ramp, tmp_path, size):
    """Luminance of standardised sRGB: one feature, its mean and spread over the texture taken away."""
    weight = np.array([2.0, 7.0, 1.0]).reshape(1, 3, 1, 1)
    model = Encoder(tmp_path / encoder(*patches(weight), size))
    assert model.side == (TILE if size[0] == "h" else 112)
    texture, values = ramp
    tokens = TokenFeatures(texture, model)
    assert tokens.count == 1
    found = tokens.window(slice(0, 600), slice(0, 900))[0]
    exact = ((values - MEAN) / DEVIATION) @ weight.ravel()
    slope, offset = np.polyfit(exact.ravel(), found.ravel().astype(float), 1)
    np.testing.assert_allclose(found, slope * exact + offset, atol=2e-3)
    assert slope > 0 and found.std() == pytest.approx(1, abs=0.2)  # it is 1 in the sample of the components


@pytest.mark.parametrize("side", [14, 16])
def test_patches_are_linear_between_their_middles(encoder, ramp, tmp_path, side):
    """Means of a ramp over patches are the ramp in their middles, and linear between them: the ramp itself."""
    texture, values = ramp
    tokens = TokenFeatures(texture, Encoder(tmp_path / encoder(*averages(side))))
    assert tokens.count == 2
    found = tokens.window(slice(0, 600), slice(0, 900)).reshape(2, -1).T
    exact = np.column_stack([values[..., :2].reshape(-1, 2), np.ones(600 * 900)])
    inner = np.zeros((600, 900), bool)
    inner[side:-side, side:-side] = True  # beyond the edge the texture is mirrored
    inner = inner.ravel()
    fitted = exact @ np.linalg.lstsq(exact[inner], found[inner], rcond=None)[0]
    np.testing.assert_allclose(found[inner], fitted[inner], atol=0.01)
    assert found[inner].std(axis=0).min() > 0.5


@pytest.mark.parametrize("leading", [0, 1, 5])
def test_tokens_are_those_of_a_map(encoder, ramp, tmp_path, leading):
    """(1, N, C) with tokens of the class and registers before it."""
    nodes, weights = averages(16)
    nodes[0] = (nodes[0][0], nodes[0][1], ("map",), nodes[0][3])
    nodes += [
        ("Reshape", ("map", "shape"), ("flat",), {}),
        ("Transpose", ("flat",), ("rows",), {"perm": [0, 2, 1]}),
        ("Concat", ("first", "rows"), ("tokens",), {"axis": 1}),
    ]
    weights |= {"shape": np.array([1, 2, -1]), "first": np.full((1, leading, 2), 1e6, np.float32)}
    texture, _ = ramp
    plain = TokenFeatures(texture, Encoder(tmp_path / encoder(*averages(16))))
    tokens = TokenFeatures(texture, Encoder(tmp_path / encoder(nodes, weights, name="tokens.onnx")))
    window = slice(100, 400), slice(200, 700)
    np.testing.assert_allclose(tokens.window(*window), plain.window(*window), atol=1e-5)


def test_windows_are_parts_of_the_whole(encoder, ramp, tmp_path, monkeypatch):
    texture, _ = ramp
    name = encoder(*averages(14))
    whole = TokenFeatures(texture, Encoder(tmp_path / name)).window(slice(0, 600), slice(0, 900))
    monkeypatch.setattr("skyshine.tmm.features.tokens._CACHE_BYTES", 1)  # one tile is kept
    tokens = TokenFeatures(texture, Encoder(tmp_path / name))
    for rows, columns in ((slice(0, 1), slice(899, 900)), (slice(330, 341), slice(0, 900)), (slice(599, 600),) * 2):
        np.testing.assert_allclose(tokens.window(rows, columns), whole[:, rows, columns], atol=1e-6)
    assert len(tokens._kept) == 1


@pytest.mark.parametrize("shape", [(1, 1), (3, 2000), (447, 449)])
def test_textures_of_any_size_and_flat_ones(encoder, write_image, tmp_path, shape):
    name = write_image("flat.png", np.full((*shape, 3), 90, np.uint8))
    tokens = TokenFeatures(TextureFile(tmp_path / name), Encoder(tmp_path / encoder(*averages(14))))
    found = tokens.window(slice(0, shape[0]), slice(0, shape[1]))
    assert found.shape == (1, *shape) and (found == 0).all()


def test_texels_without_data_have_the_mean_colour(encoder, write_image, tmp_path):
    values = np.full((64, 64, 4), 200, np.uint8)
    values[..., 3] = 255
    values[:, 32:] = (255, 0, 0, 0)
    values[:8, :8, :3] = 30
    name = write_image("hole.png", values)
    tokens = TokenFeatures(TextureFile(tmp_path / name), Encoder(tmp_path / encoder(*patches(np.ones((1, 3, 1, 1))))))
    found = tokens.window(slice(0, 64), slice(0, 64))[0]
    mean, bright, dark = found[40, 40], found[40, 0], found[0, 0]
    # Sums of standardised colours: 0 of the mean; and of grey (g - mean) / deviation over the channels.
    sums = [((grey / 255 - MEAN) / DEVIATION).sum() for grey in (200, 30)]
    assert (bright - mean) / (dark - mean) == pytest.approx(sums[0] / sums[1], rel=1e-4)
    assert np.ptp(found[:, 32:]) < 1e-6


def stripes(random, size=224):
    """Noise along one diagonal on the left, and along the other on the right: the same but mirrored."""
    rows, columns = np.mgrid[:size, :size]
    values = np.empty((size, size))
    along = np.where(columns < size // 2, rows + columns, rows - columns + size)
    values = random.normal(0, 25, 2 * size)[along] + 120
    return np.clip(np.repeat(values[..., np.newaxis], 3, axis=2), 0, 255).astype(np.uint8)


def slopes():
    """Encoder that tells the diagonals: mean absolute differences along each, over patches of 14."""
    weight = np.zeros((2, 3, 2, 2), np.float32)
    weight[0, 0] = [[1, 0], [0, -1]]
    weight[1, 0] = [[0, 1], [-1, 0]]
    nodes = [
        ("Conv", ("image", "w"), ("steps",), {"pads": [0, 0, 1, 1]}),
        ("Abs", ("steps",), ("size",), {}),
        ("AveragePool", ("size",), ("tokens",), {"kernel_shape": [14, 14], "strides": [14, 14]}),
    ]
    return nodes, {"w": weight}


def write_job(folder, image, **classifier):
    polygons = {
        "grass_green": [[[20, 20], [80, 20], [80, 90], [20, 90]], [[30, 150], [80, 150], [80, 190], [30, 190]]],
        "soil_sand": [[[140, 20], [200, 20], [200, 90], [140, 90]], [[140, 150], [190, 150], [190, 190], [140, 190]]],
    }
    held_out = {"folds": 2}  # each is a training
    texture = {"image": image, "seeds": {"polygons": polygons}, "classifier": classifier, "held_out": held_out}
    (folder / "tmm.yaml").write_text(yaml.safe_dump({"textures": [texture]}))
    return str(folder / "tmm.yaml")


def right(path, library):
    from skyshine.tmm import open_tmm

    with open_tmm(path) as file:
        code = file.array("levels/0/code")
    left, other = (library[name].code for name in ("grass_green", "soil_sand"))
    return ((code[:, :98] == left).mean() + (code[:, 126:] == other).mean()) / 2  # a patch beside the border is both


def test_an_encoder_tells_what_texture_features_do_not(encoder, write_image, tmp_path, library):
    """Mirrored stripes have the same colours, gradients and coherence; the encoder knows their direction."""
    pytest.importorskip("sklearn")
    image = write_image("stripes.png", stripes(np.random.default_rng(1)))
    run = CliRunner()
    found = {}
    for name, settings in (("plain", {}), ("tokens", {"features": encoder(*slopes())})):
        job = write_job(tmp_path, image, method="textured", radius=4, **settings)
        assert run.invoke(main, ["check", job]).exit_code == 0
        result = run.invoke(main, ["classify", job, "--out", str(tmp_path / name)])
        assert result.exit_code == 0, result.output
        found[name] = right(tmp_path / name / "stripes.tmm.h5", library)
    assert found["tokens"] > 0.97 > 0.85 > found["plain"]
    # The same job gives the same bytes; another encoder makes the database anew.
    first = (tmp_path / "tokens/stripes.tmm.h5").read_bytes()
    run.invoke(main, ["classify", job, "--out", str(tmp_path / "again")])
    assert (tmp_path / "again/stripes.tmm.h5").read_bytes() == first
    assert "kept" in run.invoke(main, ["classify", job, "--out", str(tmp_path / "again"), "--json"]).stdout
    nodes, weights = slopes()
    encoder(nodes, {"w": 2 * weights["w"][::-1]})
    assert "written" in run.invoke(main, ["classify", job, "--out", str(tmp_path / "again"), "--json"]).stdout


def vector(encoder):
    nodes = [
        ("GlobalAveragePool", ("image",), ("pooled",), {}),
        ("Flatten", ("pooled",), ("tokens",), {}),
    ]
    return encoder(nodes, {})


def other_size(encoder):
    nodes, weights = averages(16)
    nodes[0] = (nodes[0][0], nodes[0][1], ("map",), nodes[0][3])
    return encoder([*nodes, ("Reshape", ("map", "shape"), ("tokens",), {})], weights | {"shape": [1, 2, 14, 14]})


def nan(encoder):
    nodes, weights = averages(16)
    return encoder(nodes, {"w": weights["w"] * np.float32(np.nan)})


def infinite(encoder):
    nodes, weights = averages(16)
    return encoder(nodes, {"w": weights["w"] * np.float32(3e38) * 10})


def no_model(encoder):
    name = encoder(*averages(16))
    return name, lambda folder: (folder / name).write_bytes(b"not a model")


BROKEN = {
    "absent": (lambda _: "absent.onnx", "absent.onnx: is no file that can be read"),
    "no model": (no_model, "is no ONNX model that can be run"),
    "empty": (lambda e: (e(*averages(16)), lambda f: (f / "encoder.onnx").write_bytes(b"")), "is no ONNX model"),
    "vector": (vector, "gives float32 (1, 3) as its first output; allowed: a map of floats (1, C, rows, columns)"),
    "tokens of no square": (
        lambda e: e([("Reshape", ("image", "shape"), ("tokens",), {})], {"shape": [1, 48, -1]}, size=(80, 80)),
        "allowed: a map of floats",
    ),
    "map larger than the image": (
        lambda e: e([("Pad", ("image", "pads"), ("tokens",), {})], {"pads": [0, 0, 1, 1, 0, 0, 1, 1]}),
        "gives float32 (1, 3, 450, 450)",
    ),
    "other size": (other_size, "fails on an image of 448 x 448 texels"),
    "nan": (nan, "gives values that are not finite"),
    "infinite": (infinite, "gives values that are not finite"),
    "grey": (
        lambda e: e(*patches(np.ones((1, 1, 4, 4))), channels=1),
        "takes image tensor(float) [1, 1, 'h', 'w']; allowed: one input of float images",
    ),
    "doubles": (lambda e: e([("Cast", ("image",), ("tokens",), {"to": 1})], {}, kind="DOUBLE"), "tensor(double)"),
    "oblong": (lambda e: e(*averages(16), size=(224, 448)), "h and w alike or free"),
    "tiny": (lambda e: e(*patches(np.ones((1, 3, 1, 1))), size=(4, 4)), "takes images"),
    "two inputs": (
        lambda e: e([("Add", ("image", "other"), ("tokens",), {})], {}, inputs=("image", "other")),
        "allowed: one input of float images",
    ),
}


@pytest.mark.parametrize("command", ["check", "classify"])
@pytest.mark.parametrize("what", BROKEN)
def test_what_is_no_encoder_is_one_line(encoder, write_image, tmp_path, what, command):
    pytest.importorskip("sklearn")
    make, message = BROKEN[what]
    name = make(encoder)
    if isinstance(name, tuple):
        name, damage = name
        damage(tmp_path)
    job = write_job(tmp_path, write_image("a.png", stripes(np.random.default_rng(1))), method="textured", features=name)
    result = CliRunner().invoke(main, [command, job, *(["--out", str(tmp_path)] if command == "classify" else [])])
    lines = [line for line in result.stderr.strip().splitlines() if name in line]
    assert result.exit_code == 2 and len(lines) == 1 and message in lines[0], result.stderr


def test_without_the_extra(encoder, tmp_path, monkeypatch):
    name = encoder(*averages(16))
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    with pytest.raises(InputError, match=r'needs onnxruntime; run: pip install "skyshine\[onnx\]"'):
        Encoder(tmp_path / name)


@pytest.mark.parametrize(
    "change, message",
    [
        ({"classifier": {"features": "e.onnx"}}, "found classifier.features beside seeds and method colour"),
        ({"model": "library"}, "found classifier.features beside seeds and model and method textured"),
        ({"seeds": None, "material": "tar"}, "found classifier.features beside material and method textured"),
    ],
)
def test_where_features_do_not_go(write_image, tmp_path, change, message):
    image = write_image("a.png", stripes(np.random.default_rng(1)))
    path = write_job(tmp_path, image, method="textured", features="e.onnx")
    job = yaml.safe_load((tmp_path / "tmm.yaml").read_text())
    job["textures"][0] = {k: v for k, v in (job["textures"][0] | change).items() if v is not None}
    (tmp_path / "tmm.yaml").write_text(yaml.safe_dump(job))
    result = CliRunner().invoke(main, ["check", path])
    (line,) = result.stderr.strip().splitlines()
    assert (
        result.exit_code == 2
        and message in line
        and "with seeds alone and method: textured, or with a model alone" in line
    )


SHEETS = {"a.png": 1, "b.png": 2, "c.png": 3}  # with the seed of the noise of each


@pytest.fixture
def sheets(encoder, write_image, tmp_path):
    """Sheets of mirrored stripes, an encoder that tells them, and what writes and runs a job of some of the sheets."""
    pytest.importorskip("sklearn")
    for image, seed in SHEETS.items():
        write_image(image, stripes(np.random.default_rng(seed)))
    encoder(*slopes())

    def run(command, images, *options, file="tmm.yaml", **settings):
        write_job(tmp_path, images[0], method="textured", radius=4)
        (entry,) = yaml.safe_load((tmp_path / "tmm.yaml").read_text())["textures"]
        del entry["classifier"]
        if "model" in settings and "seeds" not in settings:
            del entry["seeds"], entry["held_out"]
        settings.pop("seeds", None)
        entries = [{**entry, "image": image, **settings} for image in images]
        (tmp_path / file).write_text(yaml.safe_dump({"textures": entries}, sort_keys=False))
        return CliRunner().invoke(main, [command, str(tmp_path / file), *options])

    return run


TEXTURED = {"method": "textured", "radius": 4}
WITH_TOKENS = TEXTURED | {"features": "encoder.onnx"}


@pytest.fixture(scope="module")
def models():
    """The files of `trained` by their names, once they are trained."""
    return {}


@pytest.fixture
def trained(sheets, models, tmp_path):
    """A model of two sheets with the encoder's features, and one without."""
    for name, settings in (("with", WITH_TOKENS), ("without", TEXTURED)):
        path = tmp_path / f"{name}.tmm-model.h5"
        if name not in models:
            result = sheets("train", ["a.png", "b.png"], "--out", str(path), classifier=settings)
            assert result.exit_code == 0, result.output
            models[name] = path.read_bytes()
        path.write_bytes(models[name])
    return tmp_path


def test_a_model_tells_on_another_sheet_what_texture_features_do_not(sheets, trained, library):
    found = {}
    for name, settings in (("with", {"features": "encoder.onnx", "radius": 4}), ("without", {"radius": 4})):
        job = {"model": f"{name}.tmm-model.h5", "classifier": settings}
        for command, options in (("check", ()), ("classify", ("--out", str(trained / name)))):
            result = sheets(command, ["c.png"], *options, **job)
            assert result.exit_code == 0, result.output
        found[name] = right(trained / name / "c.tmm.h5", library)
    assert found["with"] > 0.97 > 0.85 > found["without"]
    assert mat_problems(trained / "with.tmm-model.h5") == []


def test_a_model_says_what_encoder_it_was_trained_with(sheets, trained):
    digest = hashlib.sha256((trained / "encoder.onnx").read_bytes()).hexdigest()
    identity = read_model(trained / "with.tmm-model.h5").tokens.encoder
    assert (identity.sha256, identity.side, identity.output) == (digest, TILE, "tokens")
    assert (identity.rows, identity.columns) == (32, 32)  # patches of 14 texels
    np.testing.assert_allclose([identity.mean, identity.deviation], [MEAN, DEVIATION], rtol=1e-6)
    shown = CliRunner().invoke(main, ["info", str(trained / "with.tmm-model.h5")]).stdout
    assert digest in shown and "32 x 32 tokens of 448 x 448 texels, 2 components" in shown
    plain, own = (
        json.loads(CliRunner().invoke(main, ["info", "--json", str(trained / f"{name}.tmm-model.h5")]).stdout)
        for name in ("without", "with")
    )
    assert own["encoder"]["sha256"] == digest and own["encoder"]["components"] == 2 and plain["encoder"] is None
    # Trained again, it is the same to the byte.
    first = (trained / "with.tmm-model.h5").read_bytes()
    sheets("train", ["a.png", "b.png"], "--out", str(trained / "again.tmm-model.h5"), classifier=WITH_TOKENS)
    assert (trained / "again.tmm-model.h5").read_bytes() == first


def test_the_basis_is_that_of_all_sheets_in_any_order(encoder, write_image, tmp_path, monkeypatch):
    """Against scikit-learn's components of all tokens; sheets of unlike size and brightness, which have another mean
    and other components each. They are added up in an order of their own, so that rounding is the same too.
    """
    decomposition = pytest.importorskip("sklearn.decomposition")
    random = np.random.default_rng(5)
    weight = random.normal(size=(5, 3, 16, 16)) / 16
    name = encoder(*patches(weight))
    sizes = {"dark.png": (64, 80, 40), "light.png": (300, 500, 180), "flat.png": (30, 30, 120)}
    for image, (height, width, grey) in sizes.items():
        noise = random.normal(0, 0 if image == "flat.png" else 25, (height, width, 3))
        write_image(image, np.clip(noise + grey, 0, 255).astype(np.uint8))
    settings = {"seeds": {"polygons": {"tar": [[[1, 1], [9, 1], [9, 9]]]}}}
    settings["classifier"] = {"method": "textured", "features": name}
    textures = [TextureJob.model_validate({"image": image, **settings}) for image in sizes]
    taken, sample = [], Encoder.sample
    monkeypatch.setattr(Encoder, "sample", lambda own, of: taken.append(of.path.name) or sample(own, of))
    found = [library_tokens(TmmJob(textures=order), tmp_path).basis for order in (textures, textures[::-1])]
    assert taken[:3] == taken[3:] and sorted(taken[:3]) == sorted(sizes)
    np.testing.assert_array_equal(found[0].components, found[1].components)
    np.testing.assert_array_equal(found[0].mean, found[1].mean)
    model = Encoder(tmp_path / name)
    tokens = np.concatenate([model.sample(TextureFile(tmp_path / image)) for image in sizes])
    peer = decomposition.PCA(whiten=True).fit(tokens)
    np.testing.assert_allclose(found[0].mean, peer.mean_, rtol=1e-5, atol=1e-6)
    features = found[0].features(tokens.T[:, np.newaxis])[:, 0].T
    spread = np.sqrt(len(tokens) / (len(tokens) - 1))  # theirs divides by one less
    np.testing.assert_allclose(features.mean(axis=0), 0, atol=1e-3)
    np.testing.assert_allclose(np.abs(features), np.abs(peer.transform(tokens)) * spread, atol=2e-3)


def alone(model, features):
    return {"model": model, "classifier": {"features": features}}


WITH, WITHOUT = "with.tmm-model.h5", "without.tmm-model.h5"
REFUSED = {
    "not named": ({"model": WITH}, "tmm.yaml:3:10: the model takes features of an image encoder; name the ONNX file"),
    "another": (alone(WITH, "other.onnx"), "tmm.yaml:5:15: 'other.onnx' has the SHA-256 "),
    "absent": (alone(WITH, "no.onnx"), "tmm.yaml:5:15: 'no.onnx' is no file that can be read; name the ONNX file"),
    "not asked for": (alone(WITHOUT, "encoder.onnx"), "tmm.yaml:5:15: the model takes no image encoder; leave"),
    "of the package": (alone("library", "encoder.onnx"), "tmm.yaml:5:15: the model takes no image encoder; leave"),
    "beside seeds": ({"model": WITH, "seeds": True}, "allowed beside seeds: a model without"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_another_encoder_than_the_model_had_is_refused(encoder, sheets, trained, what):
    nodes, weights = slopes()
    encoder(nodes, {"w": 2 * weights["w"]}, name="other.onnx")
    settings, message = REFUSED[what]
    for command, options in (("check", ()), ("classify", ("--out", str(trained / "out")))):
        result = sheets(command, ["c.png"], *options, **settings)
        lines = [line for line in result.stderr.strip().splitlines() if message in line]
        assert result.exit_code == 2 and len(lines) == 1, result.stderr
    assert not list(trained.glob("out/*.h5"))


def test_python_refuses_another_encoder_too(trained, library):
    job = TextureJob.model_validate({"image": "c.png", "model": "with.tmm-model.h5"})
    for call in (map_texture, check):
        with pytest.raises(InputError, match="'c': the model takes features of an image encoder"):
            call(job, trained, library)
    with pytest.raises(InputError, match="allowed for suggestions: a model without"):
        suggest(job, trained, library, 3)


def test_without_the_extra_other_models_are_applied(sheets, trained, monkeypatch):
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    plain = sheets("classify", ["c.png"], "--out", str(trained / "plain"), model=WITHOUT)
    assert plain.exit_code == 0, plain.output
    for command in ("check", "classify"):
        result = sheets(command, ["c.png"], **alone(WITH, "encoder.onnx"))
        assert result.exit_code == 2 and 'needs onnxruntime; run: pip install "skyshine[onnx]"' in result.stderr


def test_sheets_of_a_model_have_one_encoder(sheets, tmp_path):
    texture = {"image": "a.png", "seeds": {"polygons": {"tar": [[[1, 1], [9, 1], [9, 9]]]}}}
    textures = [{**texture, "classifier": WITH_TOKENS}, {**texture, "image": "b.png", "classifier": TEXTURED}]
    (tmp_path / "tmm.yaml").write_text(yaml.safe_dump({"textures": textures}))
    result = CliRunner().invoke(main, ["train", str(tmp_path / "tmm.yaml"), "--out", str(tmp_path / "m.h5")])
    (line,) = result.stderr.strip().splitlines()
    assert result.exit_code == 2 and not (tmp_path / "m.h5").exists()
    assert "'b' has classifier.features none and 'a' encoder.onnx; allowed: the same file for all textures" in line


@pytest.mark.parametrize(
    "change, encoder, message",
    [
        ({"components": np.float32([[np.nan] * 2] * 3)}, {}, "is damaged (tokens/basis is not finite)"),
        ({"mean": np.float32([0, np.inf, 0])}, {}, "is damaged (tokens/mean is not finite)"),
        ({"mean": np.zeros(4, "f4"), "components": np.ones((4, 5), "f4")}, {}, "have a mean (4,) and a basis (4, 5)"),
        ({}, {"sha256": "0" * 63}, "its encoder has the SHA-256"),
        ({}, {"side": 0}, "its encoder takes images and gives maps of (0, 32, 32)"),
        ({}, {"rows": 449}, "its encoder takes images and gives maps of (448, 449, 32)"),
    ],
)
def test_a_damaged_basis_is_refused(tmp_path, change, encoder, message):
    identity = EncoderIdentity("0" * 64, 448, 32, 32, "tokens", (0.5, 0.5, 0.5), (0.2, 0.2, 0.2))
    whole = TokenBasis(np.zeros(3, np.float32), np.ones((3, 2), np.float32), identity)

    def read(basis):
        size = len(names()) + basis.count
        flat = [np.zeros(shape, np.float32) for shape in ((size, 2), (2,), (2, 1), (1,))]
        network = Network(np.zeros(size, np.float32), np.ones(size, np.float32), *flat)
        model = TrainedModel(("tar",), GaussianModel(("tar",), np.zeros((1, 3)), np.eye(3)[None], np.zeros(1)), network)
        write_model(replace(model, tokens=basis), tmp_path / "a.tmm-model.h5", "job", "1", {})
        return read_model(tmp_path / "a.tmm-model.h5").tokens

    assert read(whole).encoder == identity
    with pytest.raises(InputError) as raised:
        read(replace(whole, **change, encoder=replace(identity, **encoder)))
    assert message in str(raised.value)
