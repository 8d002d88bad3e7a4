"""The whole corpus of bad and unusual files in the package and in the C library, under sanitizers; and random ones.

Prints a table of counts: run with ``-s``.
"""

import json
import sys
from collections import Counter
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "fuzz"))
import good_databases
import hostile_cases
import hostile_corpus
import hostile_random
import runtime_loaders

pytestmark = pytest.mark.validation
CORPUS = hostile_corpus.cases()
LOADERS = ("library", *runtime_loaders.PREPARED)
RANDOM_FILES = 2000


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    return good_databases.write_all(tmp_path_factory.mktemp("good"))


@pytest.fixture(scope="module")
def load(tmp_path_factory):
    """A loader by its name or its language; that in C with sanitizers."""

    def make(name: str) -> runtime_loaders.Loader:
        if name == "library":
            return runtime_loaders.library()
        if missing := runtime_loaders.missing_tools(name):
            pytest.skip(f"{', '.join(missing)} not installed")
        folder = tmp_path_factory.mktemp(name)
        if name == "c":
            command = runtime_loaders.prepared(folder, runtime_loaders.SANITIZED)
            return runtime_loaders.program(command, runtime_loaders.SANITIZERS)
        return runtime_loaders.program(runtime_loaders.PREPARED[name](folder))

    return make


@pytest.mark.parametrize("name", LOADERS)
def test_every_file_of_the_corpus_is_refused_or_read_alike(name, load, good, tmp_path):
    counts: Counter[tuple[str, str]] = Counter()
    wrong = runtime_loaders.wrong_answers(load(name), CORPUS, good, tmp_path, counts, textures=name == "library")
    for verdict in hostile_cases.VERDICTS:
        found = ", ".join(f"{counts[verdict, how]} {how}" for how in ("refused", "equal", "wrong"))
        print(f"\n{name}: must {verdict}: {found}", end="")
    assert not wrong, json.dumps(wrong, indent=1)


def test_random_files_are_refused_or_read_alike(load, tmp_path):
    loaders = {name: load(name) for name in ("library", "c")}
    counts, findings = hostile_random.compare(RANDOM_FILES, 0, loaders, tmp_path)
    print(f"\n{RANDOM_FILES} random files: {dict(counts)}, {len(findings)} findings", end="")
    assert not findings, "\n".join(findings)
    assert counts["refused"] > RANDOM_FILES / 10 and counts["read alike"] > RANDOM_FILES / 20
