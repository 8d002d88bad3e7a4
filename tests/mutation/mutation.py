"""Plants single faults in the formulas of the project and reports which tests notice.

A fault is one operator or one constant changed, by the operators of Cosmic Ray and by factors of 0.8 and 1.25, or the
form of an expression: a term, factor or square less, operands or an index exchanged, any for all (rewrites.py).
Tolerances, guards against division by zero and nodes of interpolation are passed over (numerical_choices.py): a fifth
more or less changes cost, not the result. Faults are drawn at random, so many of each folder; each is planted in a fork
of its own (forked_tests.py), where the tests that know the module run until one fails: those of the mirrored folder,
then those that import the module; with `--lines`, before them the tests that run the line (line_tests.py records
them). Where the tests do not end within their budget of processor time, the fault has "no time". A fault that no test
notices survives; survivors are listed with their line.

    python tests/mutation/mutation.py --count 50                         # of each folder
    python tests/mutation/mutation.py --folder mat/surface --count 20 --seed 3 --out faults.json
    python tests/mutation/line_tests.py lines.coverage && python tests/mutation/mutation.py --lines lines.coverage

It needs the package ``cosmic-ray`` of the extra ``mutation``. Exit status 1 where fewer than
`--least` of the faults were caught.
"""

from __future__ import annotations

import argparse
import ast
import concurrent.futures
import difflib
import json
import os
import sys
import tokenize
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import parso
from cosmic_ray.ast import is_number
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Operator
from cosmic_ray.plugins import get_operator, operator_names
from forked_tests import load_libraries, outcome_of
from line_tests import LineTests
from numerical_choices import is_numerical_choice
from rewrites import rewrites

CHECKOUT = Path(__file__).parents[2]
FOLDERS = (
    "mat/atmosphere",
    "mat/surface",
    "mat/quantities",
    "mat/radiometry",
    "mat/tables",
    "mat/runtime",
    "mat/measure",
)
FOLDERS += ("mat/job", "mat/render", "schemas", "tmm")
# Modules without formulas: what reads, writes or draws is tested by other means.
PASSED_OVER = (
    "commands",
    "exchange",
    "__init__.py",
    "cli.py",
    "pictures.py",
    "preview.py",
    "bench.py",
    "stress.py",
    "oracle.py",
)
ARITHMETIC = {"Add", "Sub", "Mul", "Div", "Pow"}
TURNED = {("Lt", "Gt"), ("Gt", "Lt"), ("LtE", "GtE"), ("GtE", "LtE"), ("Lt", "GtE"), ("Gt", "LtE")}
REWRITTEN = 0.5  # share of the faults that change the form of an expression
TESTS_OF_LINE, FILES_BESIDE = 80, 6  # at most, where the tests of each line are known


class ScaledNumber(Operator):
    """A constant with a decimal point times 0.8, or times 1.25; whole numbers count and index."""

    factors = (0.8, 1.25)

    def mutation_positions(self, node):
        if not is_number(node) or not isinstance(eval(node.value), float) or eval(node.value) in (0.0, 1.0):
            return
        if not is_numerical_choice(node):
            for _ in self.factors:
                yield node.start_pos, node.end_pos

    def mutate(self, node, index):
        return parso.python.tree.Number(f" {eval(node.value) * self.factors[index]!r}", node.start_pos)

    @classmethod
    def examples(cls):
        return ()


@dataclass(frozen=True)
class Fault:
    """A planted fault and what became of it.

    Attributes
    ----------
    module : str
        File, from the checkout.
    line : int
    before, after : str
        The line.
    caught_by : str
        The first test that failed; empty where all passed, or did not end.
    ended : bool
        Whether all tests ran within their time.
    """

    module: str
    line: int
    before: str
    after: str
    caught_by: str = ""
    ended: bool = False


def operators() -> list[Operator]:
    """The operators that change a formula: arithmetic, comparison, sign and constants."""
    names = ["core/ReplaceUnaryOperator_USub_UAdd"]
    for name in operator_names():
        kind, _, pair = name.removeprefix("core/").partition("_")
        replaced = tuple(pair.split("_"))
        arithmetic = kind == "ReplaceBinaryOperator" and set(replaced) <= ARITHMETIC
        if arithmetic or (kind == "ReplaceComparisonOperator" and replaced in TURNED):
            names.append(name)
    return [ScaledNumber(), *(get_operator(name)() for name in names)]


def formula_lines(source: str) -> set[int]:
    """Lines that hold arithmetic or a constant: not those of annotations, defaults, imports, texts or messages."""
    lines: set[int] = set()
    left_out: set[int] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.BinOp | ast.UnaryOp | ast.Compare | ast.Assign):
            lines.update(range(node.lineno, node.end_lineno + 1))
        if isinstance(node, ast.Raise | ast.JoinedStr | ast.Import | ast.ImportFrom | ast.Assert):
            left_out.update(range(node.lineno, node.end_lineno + 1))
        if isinstance(node, ast.arg | ast.AnnAssign) and node.annotation is not None:
            left_out.update(range(node.annotation.lineno, node.annotation.end_lineno + 1))
    return lines - left_out


def drawn_faults(folder: str, count: int, seed: int) -> list[tuple[Fault, str]]:
    """Faults of a folder, drawn at random, each with the whole text of its module; at most one of a line."""
    generator = np.random.default_rng([seed, FOLDERS.index(folder) if folder in FOLDERS else len(FOLDERS)])
    files = [
        file
        for file in sorted((CHECKOUT / folder).rglob("*.py"))
        if not set(file.relative_to(CHECKOUT).parts) & set(PASSED_OVER)
    ]
    available = operators()
    faults: dict[tuple[Path, int], tuple[Fault, str]] = {}
    sizes = np.array([len(formula_lines(file.read_text(encoding="utf-8"))) for file in files], float)
    for _ in range(200 * count):
        if len(faults) == count or not sizes.sum():
            break
        file = files[generator.choice(len(files), p=sizes / sizes.sum())]
        with tokenize.open(file) as stream:
            source = stream.read()
        if generator.random() < REWRITTEN:
            forms = rewrites(source)
            line, changed = forms[generator.integers(len(forms))] if forms else (0, source)
            pairs = list(zip(source.splitlines(), changed.splitlines(), strict=False))
            if line and (file, line) not in faults:
                old, new = pairs[line - 1]
                fault = Fault(file.relative_to(CHECKOUT).as_posix(), line, old.strip(), new.strip())
                faults[file, line] = fault, changed
            continue
        operator = available[0] if generator.random() < 0.3 else available[generator.integers(len(available))]
        # The occurrences of an operator are few: one more than there are gives nothing.
        changed = mutate_code(source, operator, int(generator.integers(60)))
        if changed is None:
            continue
        pairs = list(zip(source.splitlines(), changed.splitlines(), strict=False))
        line = next((number for number, (old, new) in enumerate(pairs, 1) if old != new), None)
        if line is None or line not in formula_lines(source) or (file, line) in faults:
            continue
        old, new = pairs[line - 1]
        module = file.relative_to(CHECKOUT).as_posix()
        faults[file, line] = Fault(module, line, old.strip(), new.strip()), changed
    return list(faults.values())


def tests_of(module: str) -> list[str]:
    """Test files of a module: of the mirrored folder, those that name it first; then those that import it or its
    folder.
    """
    path = Path(module)
    dotted = "skyshine." + ".".join(path.with_suffix("").parts)
    files = sorted((CHECKOUT / "tests" / path.parent).glob("test_*.py"))
    files.sort(key=lambda file: (path.stem not in file.stem, dotted not in file.read_text(encoding="utf-8")))
    for file in sorted((CHECKOUT / "tests").rglob("test_*.py")):
        if "validation" not in file.parts and "packaging" not in file.parts and file not in files:
            text = file.read_text(encoding="utf-8")
            if dotted in text or f"from {dotted.rpartition('.')[0]} import {path.stem}" in text:
                files.append(file)
    for upper in path.parents[1:-1]:  # the tests of the folders above, nearest first
        files += [file for file in sorted((CHECKOUT / "tests" / upper).rglob("test_*.py")) if file not in files]
        if upper.parts[:1] == ("mat",) and len(upper.parts) == 1:
            break
    return [str(file.relative_to(CHECKOUT)) for file in files[:40]]


def planted(fault: Fault, text: str, budget: float, known: dict[str, float], lines: LineTests | None = None) -> Fault:
    """Run the tests of a fault; `known` gains their times."""
    tests = tests_of(fault.module)
    if lines is not None and (nodes := lines.of(fault.module, fault.line, TESTS_OF_LINE)):
        tests = [*nodes, *tests[:FILES_BESIDE]]
    outcome = outcome_of(CHECKOUT / fault.module, text, tests, CHECKOUT, budget, known)
    if not outcome.seconds and not outcome.failed:
        raise RuntimeError(f"the tests of {fault.module} did not run")
    known.update({} if outcome.failed else outcome.seconds)
    return replace(fault, caught_by=outcome.failed, ended=outcome.ended)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", action="append", help="Of the checkout; several may be given. Default: all.")
    parser.add_argument("--count", type=int, default=40, help="Faults of each folder.")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="Faults at a time.")
    parser.add_argument("--budget", type=float, default=60.0, help="Processor seconds for the tests of a fault.")
    parser.add_argument("--least", type=float, default=0.0, help="Share to be caught, for the exit status.")
    parser.add_argument("--out", type=Path, help="JSON file of all faults.")
    parser.add_argument("--lines", type=Path, help="File of line_tests.py.")
    given = parser.parse_args()
    lines = None if given.lines is None else LineTests(given.lines)
    faults = [fault for folder in given.folder or FOLDERS for fault in drawn_faults(folder, given.count, given.seed)]
    results: list[Fault] = []
    known: dict[str, float] = {}
    load_libraries()
    with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
        for fault in pool.map(lambda pair: planted(*pair, given.budget, known, lines), faults):
            results.append(fault)
            word = "caught  " if fault.caught_by else "SURVIVED" if fault.ended else "no time "
            print(f"{word} {fault.module}:{fault.line} {fault.caught_by}", flush=True)
            if given.out:
                given.out.write_text(json.dumps([asdict(fault) for fault in results], indent=1), encoding="utf-8")
    for folder in given.folder or FOLDERS:
        of_folder = [fault for fault in results if fault.module.startswith(folder)]
        caught = sum(bool(fault.caught_by) for fault in of_folder)
        print(f"{folder}: {caught} of {len(of_folder)} caught")
    for fault in results:
        if not fault.caught_by:
            print(
                f"{fault.module}:{fault.line}{'' if fault.ended else ' (the tests did not end)'}\n"
                + "\n".join(difflib.ndiff([fault.before], [fault.after]))
            )
    caught = sum(bool(fault.caught_by) for fault in results)
    print(f"{caught} of {len(results)} caught")
    return int(caught < given.least * len(results))


if __name__ == "__main__":
    sys.exit(main())
