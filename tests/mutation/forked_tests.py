"""Tests of one changed module, run in a fork of a process that has the libraries already, until one fails.

The fork imports the module anew, with the changed text in the place of its own, and all modules that import it, however
far. The first few files of tests are collected alone, for most changes fail there. Quick tests run first where their
times are known. A test that takes longer than `LONGEST_TEST` is left, and all
end after a given processor time. Processes that a test starts read the module as it is, so that they notice nothing.
"""

from __future__ import annotations

import ast
import importlib
import itertools
import json
import os
import resource
import signal
import sys
import tempfile
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from importlib.machinery import SourceFileLoader
from pathlib import Path
from typing import Any

LONGEST_TEST = 8.0  # s of processor time
STAGES = (3, 8)  # numbers of files of tests that are collected together, before all others
LIBRARIES = (
    *("numpy", "scipy.interpolate", "scipy.ndimage", "scipy.optimize", "scipy.spatial.transform", "scipy.sparse"),
    *("scipy.integrate", "scipy.special", "pandas", "pydantic", "h5py", "yaml", "PIL.Image", "filelock", "pvlib"),
    *("skimage.segmentation", "matplotlib.pyplot", "astronomy", "pytest", "hypothesis"),
)
PACKAGE = ("skyshine.mat.builder.build", "skyshine.mat.products.channel_tables", "skyshine.tmm", "skyshine.mat")


@dataclass
class Outcome:
    """What became of the tests of a change.

    Attributes
    ----------
    failed : str
        The first test that failed; empty where none did.
    ended : bool
        Whether all tests ran, but for those that take too long.
    seconds : dict of str to float
        Processor time of each test that ran.
    """

    failed: str = ""
    ended: bool = False
    seconds: dict[str, float] = field(default_factory=dict)


def load_libraries() -> None:
    """Import what the tests of most modules need."""
    for name in (*LIBRARIES, *PACKAGE):
        with suppress(ImportError):
            importlib.import_module(name)


def _importers(module: Path) -> set[str]:
    """Names of the loaded modules of the package that import a file, however far, and of itself."""
    loaded = {name: each for name, each in sys.modules.items() if name.partition(".")[0] == "skyshine"}
    text = {
        name: Path(each.__file__).read_text(encoding="utf-8")
        for name, each in loaded.items()
        if getattr(each, "__file__", None)
    }
    words = {name: _imported(source) for name, source in text.items()}
    changed = {name for name in text if Path(str(loaded[name].__file__)).resolve() == module}
    while more := {name for name, imports in words.items() if imports & changed} - changed:
        changed |= more
    return changed


@cache
def _imported(source: str) -> frozenset[str]:
    """Names of modules that a source imports, and of what it takes from them, which may be modules."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return frozenset(names)


def _forget(names: set[str]) -> None:
    """Have modules imported anew where they are needed next."""
    for name in names:
        sys.modules.pop(name, None)
        package, _, child = name.rpartition(".")
        vars(sys.modules.get(package, sys)).pop(child, None)


def outcome_of(
    module: Path, text: str, tests: list[str], checkout: Path, budget: float, known: dict[str, float]
) -> Outcome:
    """Run tests with another text of a module.

    Parameters
    ----------
    module : path
        File that the package imports.
    text : str
    tests : list of str
        Files or node ids, from the checkout; those that tell most come first.
    checkout : path
    budget : float
        Processor seconds of all tests.
    known : dict of str to float
        Processor seconds of tests by their node ids, of earlier runs.
    """
    with tempfile.TemporaryDirectory() as work:
        report = Path(work, "report.json")
        child = os.fork()
        if child == 0:
            try:
                _run(module.resolve(), text, tests, checkout, budget, known, report)
            finally:
                os._exit(1)
        os.waitpid(child, 0)
        return Outcome(**json.loads(report.read_text())) if report.is_file() else Outcome()


class _Watch:
    """Plugin of pytest that orders tests, leaves those that take too long and writes what it sees."""

    def __init__(self, tests: list[str], known: dict[str, float], report: Path):
        self.rank = {test.partition("::")[0]: -number for number, test in reversed([*enumerate(reversed(tests))])}
        self.known, self.report, self.outcome = known, report, Outcome()

    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        items[:] = [item for item in items if self.known.get(item.nodeid, 0.0) < LONGEST_TEST]
        items.sort(key=lambda item: (self.rank.get(item.nodeid.partition("::")[0], 0), self._cost(item)))

    def _cost(self, item: Any) -> float:
        return self.known.get(item.nodeid, 1.0)

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.begin = _processor_time()
        self.outcome.seconds[nodeid] = LONGEST_TEST  # should the process end within it
        self.write()
        signal.signal(signal.SIGPROF, _leave)
        signal.setitimer(signal.ITIMER_PROF, LONGEST_TEST)

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        signal.setitimer(signal.ITIMER_PROF, 0)
        self.outcome.seconds[nodeid] = _processor_time() - self.begin
        self.write()

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed and not self.outcome.failed:
            self.outcome.failed = report.nodeid
            self.write()

    def pytest_collectreport(self, report: Any) -> None:
        if report.failed and not self.outcome.failed:
            self.outcome.failed = report.nodeid
            self.write()

    def write(self) -> None:
        self.report.write_text(json.dumps(vars(self.outcome)))


def _run(
    module: Path, text: str, tests: list[str], checkout: Path, budget: float, known: dict[str, float], report: Path
) -> None:
    import pytest

    silence = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silence, 1)
    os.dup2(silence, 2)
    limit = int(_processor_time() + budget) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
    sys.dont_write_bytecode = True
    os.environ |= {"SKYSHINE_CACHE": "", "PYTHONDONTWRITEBYTECODE": "1"}
    os.chdir(checkout)
    own = SourceFileLoader.get_code

    def get_code(loader: SourceFileLoader, fullname: str) -> Any:
        if Path(loader.path).resolve() == module:
            return compile(text, loader.path, "exec", dont_inherit=True)
        return own(loader, fullname)

    SourceFileLoader.get_code = get_code  # type: ignore[method-assign]
    options = ["-x", "-q", "--tb=no", "-n", "0", "-p", "no:cacheprovider", f"--basetemp={report.parent}/pytest"]
    _forget(_importers(module))
    watch = _Watch(tests, known, report)
    for part in _stages(tests):
        pytest.main([*options, *part], plugins=[watch])
        if watch.outcome.failed:
            os._exit(0)
    watch.outcome.ended = True
    watch.write()
    os._exit(0)


def _stages(tests: list[str]) -> list[list[str]]:
    """Tests in groups, by their files."""
    files = list(dict.fromkeys(test.partition("::")[0] for test in tests))
    edges = [0, *itertools.accumulate(STAGES), len(files)]
    groups = [set(files[low:high]) for low, high in itertools.pairwise(edges)]
    return [part for group in groups if (part := [test for test in tests if test.partition("::")[0] in group])]


def _processor_time() -> float:
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def _leave(*_: Any) -> None:
    import pytest

    pytest.skip(f"takes longer than {LONGEST_TEST:g} s")
