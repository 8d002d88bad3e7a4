"""Few clicks on sheets that the library has not seen, by default settings: at random and where `tmm suggest` asks.

Every figure is scored from the database that was written, threshold and all; so are those of unknown materials, where
one material at a time has no click by its name. `texture_results.json` beside this module has what was reached last;
documents quote it. Run by itself the module writes it: ``python test_texture_suggest.py DATA EVERY``.
"""

import json
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
import test_texture_orthophotos as orthophotos
import tifffile

from skyshine.materials.library import load_library
from skyshine.tmm import map_texture, open_tmm, write_texture
from skyshine.tmm.classify.model_file import write_model
from skyshine.tmm.features.colour import to_coordinates
from skyshine.tmm.images.texture import TextureFile
from skyshine.tmm.inputs.answers import to_text
from skyshine.tmm.job.model import TextureJob
from skyshine.tmm.mapping.suggest import suggest
from skyshine.tmm.quality.counts import Tally

pytest.importorskip("sklearn")
from sklearn.discriminant_analysis import QuadraticDiscriminantAnalysis
from sklearn.ensemble import RandomForestClassifier

pytestmark = [pytest.mark.shared_data, pytest.mark.validation]

RANDOM_SEED = orthophotos.RANDOM_SEED
NAMES = list(orthophotos.PALETTES["orthophoto"].values())
SMALLEST, RADIUS = 400, 8  # texels of a class that is clicked; of a click at random
ROUNDS = (1, 2, 6)
SCORED = 2  # every second row and column
EVERY = 5  # image of each part
MODEL = "model.tmm-model.h5"
WAYS = {"default": {}, "speed fast": {"classifier": {"speed": "fast"}}}
RESULTS = Path(__file__).with_name("texture_results.json")
PEERS = {
    "scikit-learn QDA": lambda: QuadraticDiscriminantAnalysis(reg_param=0.01),
    "scikit-learn forest": lambda: RandomForestClassifier(100, min_samples_leaf=5, random_state=0),
}


@dataclass
class Row:
    """What one way reached over all sheets with so many clicks a class."""

    tally: Tally = field(default_factory=lambda: Tally(len(NAMES)))
    stated: list = field(default_factory=list)  # expected accuracy less the true one, of each sheet
    seconds: list = field(default_factory=list)  # of a processor
    unknown: list = field(default_factory=lambda: [0, 0])  # known texels that became unknown, of all
    found: list = field(default_factory=lambda: [0, 0])  # texels of a material left out that became unknown, of all

    def report(self) -> dict:
        quality = self.tally.quality()
        values = {"sheets": len(self.seconds), "mean_iou": quality.mean_iou, "accuracy": quality.overall_accuracy}
        values |= {"calibration_error": quality.calibration_error, "false_unknown": self.unknown[0] / self.unknown[1]}
        if self.stated:
            values["stated_less_true"] = float(np.mean(self.stated))
        if self.found[1]:
            values["found_unknown"] = self.found[0] / self.found[1]
        return {key: round(value, 4) for key, value in values.items()} | {"s": round(float(np.mean(self.seconds)), 2)}


class Sheet:
    """An unseen sheet in a folder of its own, its truth and its clicks, which are the answers of a list."""

    def __init__(self, image, truth, folder):
        self.image, self.truth, self.folder, self.library = image, truth.astype(int), folder, load_library(None)

    def random_click(self, random, clicks, left_out=None):
        """One more disk of each class, of its texels alone."""
        for k in range(len(NAMES)):
            texels = np.flatnonzero(self.truth == k)
            if len(texels) >= SMALLEST and k != left_out:
                row, column = divmod(int(random.choice(texels)), self.truth.shape[1])
                rows, columns = np.ogrid[: self.truth.shape[0], : self.truth.shape[1]]
                disk = (rows - row) ** 2 + (columns - column) ** 2 <= RADIUS**2
                clicks[disk & (self.truth == k)] = k

    def ask(self, answers, count, model, left_out=None):
        """Answer what is asked by what most of each disk is; a class left out is unknown."""
        path = self.folder / "answers.yaml"
        path.unlink(missing_ok=True)
        if answers:
            path.write_text(to_text(answers, {}, "sheet"))
        seeds = {"suggested": "answers.yaml"}
        job = TextureJob.model_validate(
            {"image": str(self.image), "seeds": seeds, **({"model": MODEL} if model else {})}
        )
        rows, columns = np.ogrid[: self.truth.shape[0], : self.truth.shape[1]]
        for question in suggest(job, self.folder, self.library, count).questions:
            answer = question.answer
            inside = self.truth[(rows - answer.y) ** 2 + (columns - answer.x) ** 2 <= answer.radius**2]
            known = inside[inside >= 0]
            most = int(np.bincount(known).argmax()) if 2 * len(known) >= len(inside) else None
            name = "skip" if most is None else "unknown" if most == left_out else NAMES[most]
            answers.append(answer.model_copy(update={"material": name}))

    def disks(self, answers):
        """Classes of the texels (h, w) whose material the answers name; -1 elsewhere."""
        clicks = np.full(self.truth.shape, -1)
        rows, columns = np.ogrid[: self.truth.shape[0], : self.truth.shape[1]]
        for answer in answers:
            if answer.seed in NAMES:
                disk = (rows - answer.y) ** 2 + (columns - answer.x) ** 2 <= answer.radius**2
                clicks[disk] = NAMES.index(answer.seed)
        return clicks

    def painted(self, clicks):
        labels = self.folder / "labels.tif"
        tifffile.imwrite(labels, (clicks + 1).astype(np.uint8))
        return {
            "labels": {"image": "labels.tif", "palette": {str(k + 1): NAMES[k] for k in np.unique(clicks[clicks >= 0])}}
        }

    def score(self, row, seeds, seeded, left_out=None, **settings):
        """Map and write by default settings, and score the file."""
        job = TextureJob.model_validate({"image": str(self.image), "seeds": seeds, **settings})
        start = time.process_time()
        mapped = map_texture(job, self.folder, self.library)
        write_texture(mapped, self.folder / "sheet.tmm.h5")
        row.seconds.append(time.process_time() - start)
        with open_tmm(self.folder / "sheet.tmm.h5") as file:
            code, confidence = file.array("levels/0/code"), file.array("levels/0/confidence")
            number = {code: NAMES.index(name) for code, name in file.materials.items()} | {0: -1}
            expected = float(file.group_attributes("quality")["expected_accuracy"])
        scored = np.zeros(self.truth.shape, bool)
        scored[::SCORED, ::SCORED] = True
        scored &= (self.truth >= 0) & ~seeded
        known = scored & (self.truth != left_out) if left_out is not None else scored
        found = np.vectorize(number.get)(code[known])
        row.tally.add(self.truth[known], found, confidence[known])
        row.stated.append(expected - float((found == self.truth[known])[found >= 0].mean()))
        row.unknown[0] += int((found < 0).sum())
        row.unknown[1] += len(found)
        if left_out is not None:
            out = scored & (self.truth == left_out)
            row.found[0] += int((code[out] == 0).sum())
            row.found[1] += int(out.sum())


def _peer(sheet, row, clicks, learner):
    texture = TextureFile(sheet.image)
    pixels, _ = texture.window(slice(0, texture.height), slice(0, texture.width))
    at = clicks >= 0
    start = time.process_time()
    learner.fit(to_coordinates(pixels[at], "srgb"), clicks[at])
    scored = np.zeros(at.shape, bool)
    scored[::SCORED, ::SCORED] = True
    scored &= (sheet.truth >= 0) & ~at
    posterior = learner.predict_proba(to_coordinates(pixels[scored], "srgb"))
    row.seconds.append(time.process_time() - start)
    row.tally.add(
        sheet.truth[scored], learner.classes_[posterior.argmax(axis=1)], posterior.max(axis=1).astype(np.float32)
    )
    row.unknown[1] += int(scored.sum())


def judge(parts, folder, every, report=print):
    """Rows by way and clicks a class, over every so many sheets of parts (photographs, model of the others)."""
    rows = {}
    for part, (photographs, model) in enumerate(parts):
        write_model(model, folder / MODEL, "job", "1", {})
        for number, photograph in enumerate(photographs[::every]):
            sheet = Sheet(photograph.image, photograph.truth, folder)
            present = np.bincount(sheet.truth[sheet.truth >= 0], minlength=len(NAMES))
            count = int((present >= SMALLEST).sum())
            if count >= 2:
                _judge_random(sheet, rows, np.random.default_rng([RANDOM_SEED, part, number]))
                for model_used in (False, True):
                    _judge_asked(sheet, rows, count, model_used)
            if count >= 3:
                rare = np.where(present >= SMALLEST, present, present.max()).argmin()
                left_out = int(rare if number % 2 else present.argmax())
                _judge_left_out(sheet, rows, count, left_out, np.random.default_rng([RANDOM_SEED, part, number, 1]))
            report(photograph.image.name, flush=True)
    return {key: value.report() for key, value in sorted(rows.items())}


def _row(rows, *key):
    return rows.setdefault(", ".join(map(str, key)), Row())


def _judge_random(sheet, rows, random):
    clicks = np.full(sheet.truth.shape, -1)
    for round_ in range(1, max(ROUNDS) + 1):
        sheet.random_click(random, clicks)
        if round_ in ROUNDS:
            seeds, seeded = sheet.painted(clicks), clicks >= 0
            for name, settings in (*WAYS.items(), ("default with model", {"model": MODEL})):
                sheet.score(_row(rows, name, "random", round_), seeds, seeded, **settings)
            for name, learner in PEERS.items():
                _peer(sheet, _row(rows, name, "random", round_), clicks, learner())


def _judge_asked(sheet, rows, count, model):
    answers, how = [], "asked by a model" if model else "asked from nothing"
    for round_ in range(1, max(ROUNDS) + 1):
        sheet.ask(answers, count, model)
        clicks = sheet.disks(answers)
        if round_ in ROUNDS and len(np.unique(clicks)) > 2:
            (sheet.folder / "answers.yaml").write_text(to_text(answers, {}, "sheet"))
            seeds, ways = {"suggested": "answers.yaml"}, dict(WAYS)
            if model:
                ways["default with model"] = {"model": MODEL}
            for name, settings in ways.items():
                sheet.score(_row(rows, name, how, round_), seeds, clicks >= 0, **settings)
            for name, learner in PEERS.items():
                _peer(sheet, _row(rows, name, how, round_), clicks, learner())


def _judge_left_out(sheet, rows, count, left_out, random):
    clicks = np.full(sheet.truth.shape, -1)
    for _ in range(max(ROUNDS)):
        sheet.random_click(random, clicks, left_out)
    for name, settings in (("one left out", {}), ("one left out with model", {"model": MODEL})):
        sheet.score(_row(rows, name, "random", 6), sheet.painted(clicks), clicks >= 0, left_out, **settings)
    for model in (False, True):
        answers = []
        for _ in range(max(ROUNDS)):
            sheet.ask(answers, count, model, left_out)
        (sheet.folder / "answers.yaml").write_text(to_text(answers, {}, "sheet"))
        key, settings = ("asked by a model", {"model": MODEL}) if model else ("asked from nothing", {})
        seeds, seeded = {"suggested": "answers.yaml"}, sheet.disks(answers) >= 0
        if len({answer.seed for answer in answers} - {None, "unknown"}) > 1:
            sheet.score(_row(rows, "one left out", key, 6), seeds, seeded, left_out, **settings)


def test_by_default_settings(shared_data, tmp_path):
    rows = judge(orthophotos.unseen_sheets(shared_data, tmp_path), tmp_path, EVERY)
    print(json.dumps(rows, indent=1))
    for clicks in ROUNDS:
        default, fast = rows[f"default, random, {clicks}"], rows[f"speed fast, random, {clicks}"]
        assert default["accuracy"] > fast["accuracy"]
        assert default["accuracy"] > rows[f"scikit-learn QDA, random, {clicks}"]["accuracy"]
        assert rows[f"default, random, {clicks}"]["false_unknown"] <= 0.01
    assert rows["default with model, asked by a model, 6"]["accuracy"] >= 0.95


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as name:
        unseen = orthophotos.unseen_sheets(Path(sys.argv[1]), Path(name))
        RESULTS.write_text(json.dumps(judge(unseen, Path(name), int(sys.argv[2])), indent=1) + "\n")
