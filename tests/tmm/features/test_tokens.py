"""Features of image encoders in ONNX: small ones with known weights, made here, and what is refused."""

import sys

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from skyshine.schemas.errors import InputError
from skyshine.tmm.cli import main
from skyshine.tmm.features.tokens import TILE, Encoder, TokenFeatures
from skyshine.tmm.images.texture import TextureFile

onnx = pytest.importorskip("onnx")
pytest.importorskip("onnxruntime")

OPSET, IR = 13, 8  # of onnxruntime 1.18 and later
MEAN, DEVIATION = np.array([0.485, 0.456, 0.406]), np.array([0.229, 0.224, 0.225])


@pytest.fixture
def encoder(tmp_path):
    """Saves a model of nodes, as of `onnx.helper.make_node`, from `image` to `tokens`, and returns its file name."""

    def make(nodes, weights, size=("h", "w"), name="encoder.onnx", channels=3, kind="FLOAT", inputs=("image",)):
        helper, kinds = onnx.helper, onnx.TensorProto
        values = [helper.make_tensor_value_info(i, kinds.DataType.Value(kind), [1, channels, *size]) for i in inputs]
        graph = helper.make_graph(
            [helper.make_node(kind, list(of), list(to), **settings) for kind, of, to, settings in nodes],
            "encoder",
            values,
            [helper.make_tensor_value_info("tokens", kinds.FLOAT, None)],
            [onnx.numpy_helper.from_array(np.asarray(value), key) for key, value in weights.items()],
        )
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR)
        onnx.save(model, tmp_path / name)
        return name

    return make


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
    assert result.exit_code == 2 and message in line and "with seeds alone and method: textured" in line


def test_a_trained_file_keeps_no_encoder(encoder, write_image, tmp_path):
    pytest.importorskip("sklearn")
    image = write_image("a.png", stripes(np.random.default_rng(1)))
    job = write_job(tmp_path, image, method="textured", features=encoder(*slopes()))
    result = CliRunner().invoke(main, ["train", job, "--out", str(tmp_path / "m.tmm-model.h5")])
    (line,) = result.stderr.strip().splitlines()
    assert result.exit_code == 2 and "'a' has classifier.features, which a model's file does not keep" in line
