"""A texture database against a label image, or against answers at places drawn at random: accuracy, calibration."""

from __future__ import annotations

import os
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.documents import load_model, read_yaml
from skyshine.schemas.errors import InputError
from skyshine.tmm.database.reader import TmmFile, open_tmm
from skyshine.tmm.images.labels import Labels
from skyshine.tmm.inputs.answers import SKIP, read_answers
from skyshine.tmm.job.materials import UNKNOWN
from skyshine.tmm.job.model import LabelImage
from skyshine.tmm.quality.counts import Quality, Tally

BAND_TEXELS = 1 << 22  # texels compared at a time


@dataclass(frozen=True)
class Score:
    """What was found against what is labelled; texels without a label do not count.

    names : tuple of str; K materials, labelled or found, in the order of their codes.
    quality : Quality
    """

    names: tuple[str, ...]
    quality: Quality


def score(path: str | os.PathLike[str], labels: str | os.PathLike[str], library: MaterialLibrary) -> Score:
    """Compare a database with a label image.

    Raises InputError: a file cannot be read, the sizes differ, a material is unknown, or no texel has a label.

    Parameters
    ----------
    path : path
        The database.
    labels : path
        YAML file with the keys `image` (label image, relative to this file) and `palette` (colour: material).
    library : MaterialLibrary
    """
    labels = Path(labels)
    reference = load_model(labels, LabelImage, context={"materials": library.names})
    with open_tmm(path) as file:
        materials = {*reference.palette.values(), *file.materials.values()}
        names = tuple(sorted(materials, key=lambda name: library.code(name) if name in library else -1))
        truth = Labels(reference, labels.parent, names).fits(file.height, file.width)
        tally = Tally(len(names))
        for rows in _bands(file.height, file.width):
            labelled = truth.rows(rows.start, rows.stop)
            texels = np.nonzero(labelled != -1)
            assigned, confidence = _assigned(file, rows, names)
            tally.add(labelled[texels], assigned[texels], confidence[texels])
    if not tally.texels:
        raise InputError("labels no texel: none of the palette's colours occurs in it", file=truth.path)
    return Score(names, tally.quality())


@dataclass(frozen=True)
class Checked:
    """What was found at places drawn at random, against what somebody saw there.

    answered, right : int
        Places with an answer, and those whose material is that answer; `unknown` is right where nothing was found.
    skipped : int; places at which it could not be known, or was not yet.
    accuracy : float; share of the texels that have the right material.
    low, high : float; of its interval of 95 % confidence (Wilson 1927, J. Am. Stat. Assoc. 22:209-212).
    stated : float; mean confidence that the database states at the places answered.
    wrong : dict of (str, str) to int; how often what was seen was found as something else.
    """

    answered: int
    right: int
    skipped: int
    accuracy: float
    low: float
    high: float
    stated: float
    wrong: dict[tuple[str, str], int]


def check_answers(path: str | os.PathLike[str], answers: str | os.PathLike[str], library: MaterialLibrary) -> Checked:
    """Compare a database with the answers of a list that `tmm suggest --random` wrote.

    Raises InputError: a file cannot be read, a place lies beyond the image, a name is unknown, or nothing is answered
    yet.

    path : path; the database.
    answers : path
    library : MaterialLibrary
    """
    from scipy.stats import binomtest

    answers = Path(answers)
    with open_tmm(path) as file:
        listed = read_answers(answers, file, library.names)
        answered = [answer for answer in listed if answer.material not in (None, SKIP)]
        if not answered:
            raise InputError("has no answer yet; fill in what is there, or 'skip'", file=answers)
        pairs, stated = [], []
        for answer in answered:
            row = slice(answer.y, answer.y + 1)
            code = int(file.rows("code", row)[0, answer.x])
            stated.append(float(file.rows("confidence", row)[0, answer.x]))
            pairs.append((str(answer.material), file.materials.get(code, UNKNOWN)))
    right = sum(true == assigned for true, assigned in pairs)
    interval = binomtest(right, len(pairs)).proportion_ci(method="wilson")
    wrong = Counter(pair for pair in pairs if pair[0] != pair[1])
    skipped = len(listed) - len(answered)
    accuracy, mean = right / len(pairs), float(np.mean(stated))
    return Checked(len(pairs), right, skipped, accuracy, interval.low, interval.high, mean, dict(wrong.most_common()))


def is_list_of_answers(path: str | os.PathLike[str]) -> bool:
    """Whether a YAML file is such a list, rather than one that names a label image.

    Raises InputError: it is no YAML that can be read.
    """
    content = read_yaml(Path(path)).data
    return isinstance(content, dict) and "answers" in content


def _bands(height: int, width: int) -> list[slice]:
    step = max(BAND_TEXELS // width, 1)
    return [slice(top, min(top + step, height)) for top in range(0, height, step)]


def _assigned(file: TmmFile, rows: slice, names: tuple[str, ...]) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Index of the material assigned, that of `unknown` where it is among the names, else -1; and its confidence."""
    number = np.full(int(np.iinfo(np.uint16).max) + 1, names.index(UNKNOWN) if UNKNOWN in names else -1, np.int16)
    for code, name in file.materials.items():
        number[code] = names.index(name)
    return number[file.rows("code", rows)], file.rows("confidence", rows)
