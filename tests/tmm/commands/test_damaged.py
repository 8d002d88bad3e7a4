"""Damaged databases and classifiers are refused with one line by every command that opens them."""

import json
import shutil

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

from skyshine.schemas.hdf5_digest import DIGEST, content_hash
from skyshine.tmm.cli import main

GREEN, GREY = "grass_green", "asphalt_road"


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def refused(result, what: str) -> bool:
    text = result.output
    return result.exit_code == 2 and text.count("\n") == 1 and "Traceback" not in text and what in text


def replace(file: h5py.File, name: str, values) -> None:
    """Put other values, of any shape and type, in the place of an array."""
    attributes = {k: v for k, v in file[name].attrs.items() if k in ("units", "long_name", "total")}
    del file[name]
    file.create_dataset(name, data=values).attrs.update(attributes)


def change(file: h5py.File, name: str, at, value) -> None:
    values = file[name][()]
    values[at] = value
    file[name][...] = values


# Arrays of another shape or type may be refused before their name is known: any one line will do for them ("").
DATABASE = {
    "no weights": (lambda f: f.__delitem__("levels/0/mix_weight"), "damaged"),
    "no confidence": (lambda f: f.__delitem__("levels/0/confidence"), "damaged"),
    "no materials": (lambda f: f.__delitem__("materials"), "damaged"),
    "no names": (lambda f: f.__delitem__("materials/name"), "damaged"),
    "no usage": (lambda f: f.__delitem__("usage"), "damaged"),
    "no quality": (lambda f: f.__delitem__("quality"), "damaged"),
    "no provenance": (lambda f: f.__delitem__("provenance"), "damaged"),
    "a level is missing": (lambda f: f.__delitem__("levels/2"), "levels 0 to"),
    "no digest of the image": (lambda f: f["provenance"].attrs.__delitem__("texture_sha256"), "texture_sha256"),
    "no job": (lambda f: f.attrs.__delitem__("job"), "'job'"),
    "no accuracy": (lambda f: f["quality"].attrs.__delitem__("overall_accuracy"), "overall_accuracy"),
    "accuracy not a number": (lambda f: f["quality"].attrs.__setitem__("mean_iou", np.nan), "mean_iou"),
    "share not a number": (lambda f: change(f, "usage/share", 0, np.nan), "shares"),
    "share above 1": (lambda f: change(f, "usage/share", 0, 1.5), "shares"),
    "code 0 a material": (lambda f: change(f, "materials/material", 0, 0), "ascend"),
    "codes of one level": (lambda f: replace(f, "levels/0/code", np.zeros((3, 3), np.uint16)), ""),
    "floats as codes": (lambda f: replace(f, "levels/0/code", np.zeros((20, 40))), ""),
    "two components": (lambda f: replace(f, "levels/0/mix_code", np.zeros((20, 40, 2), np.uint16)), ""),
    "another size": (lambda f: f["provenance"].attrs.__setitem__("width", 41), "levels/0/code"),
    "no size": (lambda f: f["provenance"].attrs.__setitem__("width", 0), "0 x 20"),
}
VALUES = {
    "an unknown code": ("levels/0/code", 65535, "code 65535", ("picture", "truth", "export")),
    "an unknown code in a mixture": ("levels/0/mix_code", 65535, "code 65535", ("export",)),
    "weights of another sum": ("levels/0/mix_weight", 1, "do not sum to 65535", ("export",)),
    "confidence not a number": ("levels/0/confidence", np.nan, "between 0 and 1", ("picture", "truth")),
    "confidence above 1": ("levels/0/confidence", 1.5, "between 0 and 1", ("picture", "truth")),
}


@pytest.fixture
def commands(job, two_halves, build, tmp_path, write_image):
    """A built database, and the commands that open it."""
    path = build(job(two_halves)).path
    labels = np.zeros((20, 40, 1), np.uint8)
    labels[:, 20:] = 1
    write_image("labels.png", labels)
    (tmp_path / "truth.yaml").write_text(json.dumps({"image": "labels.png", "palette": {"0": GREEN, "1": GREY}}))
    image = ("--image", tmp_path / two_halves)
    return path, {
        "content": ("preview", path),
        "content --json": ("preview", path, "--json"),
        "shares": ("preview", path, path),
        "truth": ("check", path, "--truth", tmp_path / "truth.yaml"),
        "picture": ("preview", path, "--out", tmp_path / "picture.png", *image),
        "export": ("export", path, "--to", "png", "--out", tmp_path / "out"),
    }


def test_commands_refuse_a_database_with_missing_or_impossible_parts(commands, tmp_path):
    path, every = commands
    sound = tmp_path / "sound.h5"
    shutil.copy(path, sound)
    for command in every.values():
        assert run(*command).exit_code == 0, command
    names = [*every]
    for number, (case, (damage, what)) in enumerate(DATABASE.items()):
        shutil.copy(sound, path)
        with h5py.File(path, "r+") as file:
            damage(file)
        # All open a database alike: two of them see each damage, and all see the first.
        for name in names if number == 0 else (names[number % len(names)], names[(number + 3) % len(names)]):
            command = every[name]
            result = run(*command)
            assert refused(result, what), (case, name, result.output, result.exception)


def test_commands_refuse_impossible_values_where_they_read_them(commands, tmp_path):
    path, every = commands
    sound = tmp_path / "sound.h5"
    shutil.copy(path, sound)
    for case, (name, value, what, readers) in VALUES.items():
        shutil.copy(sound, path)
        with h5py.File(path, "r+") as file:
            change(file, name, (3, 4), value)
        for reader in readers:
            result = run(*every[reader])
            assert refused(result, what), (case, reader, result.output, result.exception)


MODEL = {
    "zero covariance": (lambda f: change(f, "colour/covariance", 0, 0), "positive definite"),
    "negative covariance": (lambda f: change(f, "colour/covariance", 0, -np.eye(3)), "positive definite"),
    "singular covariance": (lambda f: change(f, "colour/covariance", 0, np.ones((3, 3))), "positive definite"),
    "covariance not a number": (
        lambda f: change(f, "colour/covariance", (1, 0, 0), np.nan),
        "covariance is not finite",
    ),
    "not symmetric": (lambda f: change(f, "colour/covariance", (0, 0, 1), 1e3), "symmetric"),
    "covariance of two": (lambda f: replace(f, "colour/covariance", np.ones((2, 2, 2), "f4")), ""),
    "one mean": (lambda f: replace(f, "colour/mean", np.ones(3, "f4")), ""),
    "no mean": (lambda f: f.__delitem__("colour/mean"), "lacks a part"),
    "two coordinates": (lambda f: replace(f, "colour/mean", np.ones((2, 2), "f4")), ""),
    "infinite mean": (lambda f: change(f, "colour/mean", (0, 0), np.inf), "mean is not finite"),
    "text as mean": (lambda f: replace(f, "colour/mean", np.array(["a", "b"], object)), ""),
    "prior beyond 1": (lambda f: change(f, "colour/log_prior", 0, 0.0), "sum to 1"),
    "no slope": (lambda f: f["calibration"].attrs.__delitem__("slope"), "lacks a part"),
    "negative slope": (lambda f: f["calibration"].attrs.__setitem__("slope", -1.0), "slope"),
    "slope not a number": (lambda f: f["calibration"].attrs.__setitem__("slope", np.nan), "slope"),
    "no materials": (lambda f: f.__delitem__("materials"), "lacks a part"),
    "one name twice": (lambda f: change(f, "materials/name", 0, f["materials/name"].asstr()[1]), "one name each"),
    "unknown material": (lambda f: change(f, "materials/name", 1, "zzz"), "unknown material 'zzz'"),
}
NETWORK = {
    "weights not a number": (lambda f: change(f, "network/inner_weight", (0, 0), np.nan), "inner_weight is not finite"),
    "zero scale": (lambda f: change(f, "network/scale", 0, 0), "scale of a feature"),
    "negative scale": (lambda f: change(f, "network/scale", 0, -1), "scale of a feature"),
    "another width": (lambda f: replace(f, "network/outer_weight", np.ones((3, 2), "f4")), ""),
    "no weights": (lambda f: f.__delitem__("network/outer_weight"), "lacks a part"),
}


def test_commands_refuse_a_classifier_that_no_training_gives(two_halves, tmp_path):
    pytest.importorskip("sklearn")
    box = [[[2, 2], [15, 2], [15, 15], [2, 15]]]
    polygons = {GREEN: box, GREY: [[[x + 20, y] for x, y in box[0]]]}
    texture = {"image": two_halves, "seeds": {"polygons": polygons}}
    (tmp_path / "train.yaml").write_text(json.dumps({"textures": [texture]}))
    (tmp_path / "job.yaml").write_text(json.dumps({"textures": [{"image": two_halves, "model": "a.h5"}]}))
    path, sound = tmp_path / "a.h5", tmp_path / "sound.h5"
    trained = run("train", tmp_path / "train.yaml", "--out", path)
    assert trained.exit_code == 0, trained.output
    shutil.copy(path, sound)
    assert run("classify", tmp_path / "job.yaml").exit_code == 0
    for number, (case, (damage, what)) in enumerate((MODEL | NETWORK).items()):
        shutil.copy(sound, path)
        with h5py.File(path, "r+") as file:
            damage(file)
        changed = run("check", tmp_path / "job.yaml")
        assert refused(changed, ""), (case, changed.output)
        with h5py.File(path, "r+") as file:  # as a forger would
            file.attrs[DIGEST] = content_hash(file)
        for command in ("check", "classify") if number % 6 == 0 else ("check",):
            result = run(command, tmp_path / "job.yaml")
            assert refused(result, what), (case, command, result.output, result.exception)
