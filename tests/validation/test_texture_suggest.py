"""Few clicks on sheets that the library has not seen: at random against where `tmm suggest` asks."""

import time

import numpy as np
import pytest
import test_texture_orthophotos as orthophotos

from skyshine.tmm.classify.combined import CombinedMapper, library_classes, seed_shares, survey
from skyshine.tmm.classify.gaussian import fit
from skyshine.tmm.classify.trained import TrainedModel
from skyshine.tmm.features.colour import DistinctColours, to_coordinates
from skyshine.tmm.images.texture import TextureFile
from skyshine.tmm.mapping.suggest import Known, ask, known_by_library, known_by_seeds
from skyshine.tmm.quality.counts import Tally

pytestmark = [pytest.mark.shared_data, pytest.mark.validation]

RANDOM_SEED = orthophotos.RANDOM_SEED
NAMES = list(orthophotos.PALETTES["orthophoto"].values())
SMALLEST, RADIUS = 400, 8  # texels of a class that is clicked; of a click at random
ROUNDS = (1, 2, 6)
SCORED = 2  # every second row and column
EVERY = 5  # image of each part


class Clicks:
    """Texels of a sheet that were clicked."""

    def __init__(self, truth: np.ndarray) -> None:
        self.truth, self.drawn, self.middles = truth, np.full(truth.shape, -1), []

    def add(self, row: int, column: int, radius: int, material: int | None = None) -> None:
        """Click a disk: those of its texels that are of a material, or all, named by what most of it is."""
        rows, columns = np.ogrid[: self.truth.shape[0], : self.truth.shape[1]]
        top, left = max(row - radius, 0), max(column - radius, 0)
        part = slice(top, row + radius + 1), slice(left, column + radius + 1)
        disk = (rows[part[0]] - row) ** 2 + (columns[:, part[1]] - column) ** 2 <= radius**2
        inside = self.truth[part]
        self.middles.append((row, column))
        if material is not None:
            self.drawn[part][disk & (inside == material)] = material
            return
        known = inside[disk & (inside >= 0)]
        if 2 * len(known) >= disk.sum():  # else it cannot be told
            self.drawn[part][disk] = np.bincount(known).argmax()

    def at_random(self, random: np.random.Generator) -> int:
        """Click every class once, and count them."""
        count = 0
        for k in range(len(NAMES)):
            texels = np.flatnonzero(self.truth == k)
            if len(texels) >= SMALLEST:
                self.add(*(int(at) for at in divmod(random.choice(texels), self.truth.shape[1])), RADIUS, k)
                count += 1
        return count


class Sheet:
    """An unseen sheet and all that is known of it before the first click."""

    def __init__(self, image, truth, library) -> None:
        self.truth, self.library, self.texture = truth, library, TextureFile(image)
        self.colours = DistinctColours(self.texture)
        self.surveyed = survey(self.texture, self.colours, library)
        self.pixels, _ = self.texture.window(slice(0, self.texture.height), slice(0, self.texture.width))

    def _seeds(self, clicks):
        at = clicks.drawn >= 0
        present, material = np.unique(clicks.drawn[at], return_inverse=True)
        names = tuple(NAMES[k] for k in present)
        model = TrainedModel(names, fit(to_coordinates(self.pixels[at], "srgb"), material, names), None)
        return (
            present,
            model,
            library_classes(self.library.names, names, {n: n for n in NAMES}),
            (*np.nonzero(at), material),
        )

    def ask(self, clicks, count) -> float:
        """Click where it asks; the share of texels that this is expected to put right."""
        known: Known = known_by_library(self.surveyed, self.library)
        if (clicks.drawn >= 0).any():
            _, model, classes, seeds = self._seeds(clicks)
            known = known_by_seeds(
                self.surveyed, seed_shares(self.surveyed, model, classes, seeds), model.names, classes, seeds
            )
        gain = 0.0
        for _, row, column, radius, each in ask(self.surveyed, known, clicks.middles, [], count)[0]:
            clicks.add(row, column, radius)
            gain += each
        return gain

    def score(self, clicks, tally: Tally) -> float:
        """Map the sheet, add to the tally what is found of texels without clicks, and give the accuracy."""
        present, model, classes, seeds = self._seeds(clicks)
        mapper = CombinedMapper(self.texture, self.colours, self.surveyed, model, classes, seeds)
        found = mapper.window(0, self.texture.height, 0, self.texture.width)
        scored = np.zeros(self.truth.shape, bool)
        scored[::SCORED, ::SCORED] = True
        scored &= (self.truth >= 0) & (clicks.drawn < 0)
        assigned = present[found.material[scored]]
        tally.add(self.truth[scored], assigned, found.confidence[scored])
        return float((assigned == self.truth[scored]).mean())


def judge(sheets, report=print):
    """Tallies by way and clicks a class, of (image, truth, library model) of unseen sheets."""
    tallies, gains = {}, []
    for number, (image, truth, library) in enumerate(sheets):
        start, sheet = time.perf_counter(), Sheet(image, truth.astype(int), library)
        random = np.random.default_rng([RANDOM_SEED, number])
        drawn, asked, mixed = (Clicks(sheet.truth) for _ in range(3))
        for clicks in range(1, max(ROUNDS) + 1):
            count = drawn.at_random(random)
            if count < 2:
                break
            if clicks == 1:
                mixed.drawn[:], mixed.middles = drawn.drawn, list(drawn.middles)
            else:
                stated = sheet.ask(mixed, count)
            sheet.ask(asked, count)
            if clicks not in ROUNDS:
                continue
            for way, placed in (("random", drawn), ("one at random, then asked", mixed), ("asked", asked)):
                accuracy = sheet.score(placed, tallies.setdefault((way, clicks), Tally(len(NAMES))))
                if way.startswith("one") and clicks == 1:
                    before = accuracy
                elif way.startswith("one") and clicks == 2:
                    gains.append((stated, accuracy - before))
        report(f"{number + 1}: {image.name}, {time.perf_counter() - start:.0f} s")
    for (way, clicks), tally in sorted(tallies.items(), key=str):
        quality = tally.quality()
        report(
            f"{way}, {clicks} a class: mean IoU {quality.mean_iou:.3f}, accuracy {quality.overall_accuracy:.3f}, "
            f"calibration error {quality.calibration_error:.3f}"
        )
    report("gain of a second click a class, stated and true: {:.3f} {:.3f}".format(*np.mean(gains, axis=0)))
    return tallies, gains


def test_asked_clicks_are_worth_more_than_random_ones(shared_data, tmp_path, record_property):
    pytest.importorskip("sklearn")
    parts = orthophotos.unseen_sheets(shared_data, tmp_path)
    tallies, _ = judge((sheet.image, sheet.truth, model) for unseen, model in parts for sheet in unseen[::EVERY])
    for (way, clicks), tally in tallies.items():
        record_property(f"{way}, {clicks}", tally.quality().mean_iou)
    random, asked = (tallies[way, 2].quality() for way in ("random", "one at random, then asked"))
    assert asked.mean_iou > random.mean_iou and asked.overall_accuracy > random.overall_accuracy
