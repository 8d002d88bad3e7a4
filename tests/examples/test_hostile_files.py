"""The package and the C library refuse bad files in one line, and read unusual ones as the original: a sample.

All files and the sanitizers: tests/validation/test_runtimes_hostile.py.
"""

import json
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "fuzz"))
import good_databases
import hostile_cases
import hostile_corpus
import hostile_wavelengths
import runtime_loaders

from skyshine.mat.tables.verify import problems

CORPUS = hostile_corpus.cases()
FOUND_FIRST = {  # those that overran memory or were read without a word
    "surface-filetype-an-array-of-texts",
    "band-filetype-an-array-of-fixed-texts",
    "surface-azimuth-period-an-array-of-5000",
    "band-names-more-than-codes",
    "band-axis-two-nodes",
    "atmosphere-scales-of-numbers",
    "band-pipe",
    "atmosphere-without-stated-ground_emissivity",
    "atmosphere-ground_temperature-nan",
    "atmosphere-ground_radiance-a-text",
    "atmosphere-ground_radiance-negative",
}
BY_WAVELENGTH = {case.name for k, case in enumerate(hostile_wavelengths.cases()) if k % 108 == 0}
SAMPLE = [case for k, case in enumerate(CORPUS) if k % 390 == 0 or case.name in FOUND_FIRST | BY_WAVELENGTH]


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    return good_databases.write_all(tmp_path_factory.mktemp("good"))


def test_the_corpus_is_large_and_its_names_are_unlike():
    judged = [case for case in CORPUS if case.verdict != hostile_cases.UNJUDGED]
    assert len(judged) >= 120 and len({case.name for case in CORPUS}) == len(CORPUS)
    assert {case.verdict for case in SAMPLE} >= {hostile_cases.REFUSE, hostile_cases.EQUAL}


def test_the_files_that_it_is_made_from_have_nothing_wrong(good):
    assert {kind: problems(path) for kind, path in good.items()} == {kind: [] for kind in good}


def test_the_c_library_refuses_bad_files_and_reads_unusual_ones_alike(c_program, good, tmp_path):
    load = runtime_loaders.program(c_program)
    wrong = runtime_loaders.wrong_answers(load, SAMPLE, good, tmp_path, textures=False)
    assert not wrong, json.dumps(wrong, indent=1)


def test_the_library_refuses_bad_files_and_reads_unusual_ones_alike(good, tmp_path):
    wrong = runtime_loaders.wrong_answers(runtime_loaders.library(), SAMPLE, good, tmp_path)
    assert not wrong, json.dumps(wrong, indent=1)
