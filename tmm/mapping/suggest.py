"""What to ask next about a texture, from what its seeds and its model know so far."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.errors import InputError
from skyshine.tmm.classify.graph import Survey, grid_step, seed_shares, survey
from skyshine.tmm.classify.model_file import model_path, read_model
from skyshine.tmm.classify.questions import choose, clearness, contest, doubt, middles, reach, strangeness
from skyshine.tmm.classify.trained import TrainedModel
from skyshine.tmm.classify.translation import and_unknown, class_groups, library_classes
from skyshine.tmm.images.texture import TextureFile
from skyshine.tmm.inputs.answers import Answer, read_answers
from skyshine.tmm.inputs.load import load_texture, open_texture
from skyshine.tmm.inputs.seeds import SeedTexels
from skyshine.tmm.job.materials import UNKNOWN
from skyshine.tmm.job.model import TextureJob
from skyshine.tmm.training.train import fit_seeds

RADIUS = 8  # radius of the disk that is asked about, in texels of the survey's grid, at most
SEEDED = 1 / 8  # share of a superpixel that must be seeds for it to be known
TRIES = 1000  # for a texel with data
WAYS = ("seeds", "model", "clusters")  # that answers are of use to


@dataclass(frozen=True)
class Question:
    """A place whose material is asked for.

    answer : Answer; to be filled in.
    gain : float or None; share of the texture's texels that it is expected to put right; None where it is to measure.
    now : str; the material that its superpixel has by what is known so far; empty where nothing is.
    """

    answer: Answer
    gain: float | None
    now: str


@dataclass(frozen=True)
class Suggestion:
    """What to ask about one texture.

    texture : TextureFile
    step : int; the texture was looked at in every `step`-th row and column.
    path : Path; of the list of answers; `kept` are those that it has already.
    named : bool; whether the job names this list.
    doubt : float or None
        Share of the texels that are expected to have a wrong material now; None where nothing is known yet.
    measures : bool; whether the places were drawn at random, to measure a map by.
    """

    job: TextureJob
    texture: TextureFile
    step: int
    path: Path
    named: bool
    answers: tuple[Answer, ...]
    questions: tuple[Question, ...]
    doubt: float | None
    measures: bool = False

    @property
    def kind(self) -> str:
        """What the names of its pictures end in."""
        return "check" if self.measures else "suggest"

    @property
    def gain(self) -> float:
        """Share of the texels that all answers together are expected to put right."""
        return sum(question.gain or 0.0 for question in self.questions)


@dataclass(frozen=True)
class Known:
    """What is known of superpixels.

    names : tuple of str; K materials; none where nothing is known.
    shares : (N, K) float64
    covered : (N,) float64; chance that a superpixel is of one of the materials.
    seeded : (N,) bool; whether it has seeds.
    vouched : bool; whether a library says something also of what looks like no seed.
    """

    names: tuple[str, ...]
    shares: npt.NDArray[np.float64]
    covered: npt.NDArray[np.float64]
    seeded: npt.NDArray[np.bool_]
    vouched: bool


def suggest(job: TextureJob, folder: Path, library: MaterialLibrary, count: int) -> Suggestion:
    """Find the patches of a texture whose labels improve the map most.

    Raises InputError: an image, its seeds or a list of answers is wrong; the job's materials do not come from seeds; or
    there is a list of answers that the job does not name, which would be lost.

    count : int; places to find; a small texture has fewer.
    """
    if job.way not in WAYS:
        raise InputError(
            f"'{job.name}' has its materials by {job.way}; allowed for suggestions: {', '.join(WAYS)}; give it 'seeds'"
        )
    suggested = job.seeds.suggested if job.seeds else None
    path = folder / (suggested or f"{job.name}.answers.yaml")
    if suggested is None and path.exists():
        raise InputError(
            f"exists, and '{job.name}' does not use it; add 'suggested: {path.name}' to its seeds, or move the file",
            file=path,
        )
    listed = read_answers(path, materials=library.names) if path.exists() else []
    answers = tuple(answer for answer in listed if answer.material is not None)
    texture, colours, _, seeds = load_texture(_with_seeds(job, answers), folder, library)
    model = None if job.model is None else read_model(model_path(job.model, folder))
    surveyed = survey(texture, colours, model)
    knowledge = _known(job, texture, surveyed, model, seeds, library)
    answered = [(answer.y, answer.x) for answer in answers]
    barren = [(answer.y, answer.x) for answer in answers if answer.seed is None or seeds is None]
    chosen, wrong = ask(surveyed, knowledge, answered, barren, count)
    number = max((answer.number for answer in answers), default=0) + 1
    questions = []
    for i, (superpixel, row, column, radius, gain) in enumerate(chosen):
        new_answer = Answer(number=number + i, x=column, y=row, radius=radius)
        now = knowledge.names[int(knowledge.shares[superpixel].argmax())] if knowledge.names else ""
        questions.append(Question(new_answer, gain, now))
    return Suggestion(
        job,
        texture,
        surveyed.step,
        path,
        suggested is not None,
        answers,
        tuple(questions),
        wrong if knowledge.names else None,
    )


def draw_at_random(job: TextureJob, folder: Path, library: MaterialLibrary, count: int) -> Suggestion:
    """Places of a texture drawn at random, whose answers measure a map of it without favour; they are no seeds.

    Every texel with data is as likely as any other. Places of the list that have no answer yet are asked again; new
    ones follow, by the job's random seed, so that a longer list is the shorter one with more.
    Raises InputError: the image or the list is wrong, or no texel has data.
    """
    texture = open_texture(job, folder)
    path = folder / f"{job.name}.check.yaml"
    listed = read_answers(path, texture, library.names) if path.exists() else []
    drawn = [answer for answer in listed if answer.material is None][:count]
    number = max((answer.number for answer in listed), default=0) + 1
    random = np.random.default_rng([job.held_out.random_seed, number])
    for _ in range(TRIES * count):
        if len(drawn) >= count:
            break
        row, column = int(random.integers(texture.height)), int(random.integers(texture.width))
        if texture.window(slice(row, row + 1), slice(column, column + 1))[1].all():
            drawn.append(Answer(number=number, x=column, y=row))
            number += 1
    if not drawn:
        raise InputError(
            "has hardly any texel with data; name another image, or say 'alpha: ignore'", file=texture.path
        )
    answers = tuple(answer for answer in listed if answer.material is not None)
    step = grid_step(texture)
    questions = tuple(Question(answer, None, "") for answer in drawn)
    return Suggestion(job, texture, step, path, True, answers, questions, None, measures=True)


def _with_seeds(job: TextureJob, answers: tuple[Answer, ...]) -> TextureJob:
    """The job without a list that has no seed yet, and without seeds where there are no others."""
    if (
        job.seeds is None
        or job.seeds.suggested is None
        or any(answer.seed not in (None, UNKNOWN) for answer in answers)
    ):
        return job
    others = job.seeds.model_copy(update={"suggested": None})
    drawn = others.polygons or others.file is not None or others.labels is not None
    return job.model_copy(update={"seeds": others if drawn else None})


def _known(
    job: TextureJob,
    texture: TextureFile,
    surveyed: Survey,
    model: TrainedModel | None,
    seeds: SeedTexels | None,
    library: MaterialLibrary,
) -> Known:
    """What is known by seeds, by a library model, by both or by neither."""
    superpixels = surveyed.superpixels
    number, covered = len(superpixels.size), np.ones(len(superpixels.size))
    if seeds is None:
        nowhere = np.zeros(number, bool)
        if model is None:
            return Known((), np.ones((number, 1)), np.zeros(number), nowhere, False)
        return Known(model.names, surveyed.library, covered, nowhere, True)
    fitted = fit_seeds(seeds, texture.encoding, job.classifier.prior)
    groups = class_groups(model, fitted.names, library)
    classes = library_classes(() if model is None else model.names, fitted.names, groups)
    # What the library knows and no answer names is to be asked about: it is no class of its own here.
    classes = and_unknown(classes, fitted.names)[:, : len(fitted.names)]
    drawn = seeds.drawn(fitted.names)
    shares = seed_shares(surveyed, fitted, classes, drawn)
    if len(classes) and (classes > 0).any(axis=0).all():
        covered = (surveyed.library @ classes).sum(axis=1)
    at = superpixels.label[drawn[0] // surveyed.step, drawn[1] // surveyed.step]
    seeded = np.bincount(at, minlength=number) * surveyed.step**-2.0 > SEEDED * superpixels.size
    return Known(fitted.names, shares, covered, seeded, bool(classes.any()))


def ask(
    surveyed: Survey, knowledge: Known, excluded: list[tuple[int, int]], barren: list[tuple[int, int]], count: int
) -> tuple[list[tuple[int, int, int, int, float]], float]:
    """Patches whose labels improve the map most.

    excluded : list of (int, int); rows and columns of the texture that are not asked about again.
    barren : list of (int, int); those where, and where it looks alike, nothing can be gained.

    Returns
    -------
    list of tuple
        Superpixel, row, column, radius and gain of each place.
    float
        Share of the texels that are expected to have a wrong material now.
    """
    superpixels, step = surveyed.superpixels, surveyed.step
    similarity = reach(superpixels.mean(surveyed.stack))
    texels = superpixels.mean(surveyed.valid[np.newaxis].astype(np.float64))[:, 0] * superpixels.size
    strange = strangeness(similarity, knowledge.seeded)
    wrong = doubt(knowledge.shares, knowledge.covered, knowledge.seeded, strange)
    now = float(wrong @ texels / max(texels.sum(), 1))
    rows, columns, depth = middles(superpixels, surveyed.valid)
    allowed = (depth >= 0) & ~knowledge.seeded
    allowed[[superpixels.label[row // step, column // step] for row, column in excluded]] = False
    for row, column in barren:
        wrong *= 1 - similarity[superpixels.label[row // step, column // step]]
    chosen = []
    unheard = np.zeros_like(strange) if knowledge.vouched else strange
    clear = clearness(superpixels, surveyed.stack[:3], allowed)
    contested = None
    if knowledge.vouched and knowledge.seeded.any() and len(knowledge.names) > 1:
        contested = contest(similarity, texels, knowledge.shares, knowledge.covered, knowledge.seeded)
        for row, column in barren:
            contested *= 1 - similarity[superpixels.label[row // step, column // step]]
    for candidate in choose(similarity, texels, wrong, knowledge.shares, clear, unheard, count, contested):
        i = candidate.superpixel
        radius = min(int(depth[i]), RADIUS) * step
        chosen.append((i, int(rows[i]) * step, int(columns[i]) * step, radius, candidate.gain))
    return chosen, now
