"""Imports point downwards: from the commands to the formats, folder by folder, and no module stands in a circle."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from functools import cache
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[2]
PREFIX = "skyshine."
TOP = ("mat", "tmm", "materials", "atmospheres", "schemas", "examples")

# The floors of the project, the highest first. Folders of one floor do not import each other.
FLOORS = (
    ("mat.maintain",),  # regenerates data and pages from all of the project; no folder imports it
    ("mat.cli",),
    ("mat.commands",),
    ("mat",),
    ("mat.api",),
    ("mat.gpu", "mat.exchange"),
    ("mat.bench",),
    ("mat.budget",),
    ("mat.builder",),
    ("mat.products",),
    ("mat.plan",),
    ("mat.scene",),
    ("mat.render",),
    ("mat.job",),
    ("tmm.cli",),
    ("tmm.commands",),
    ("tmm",),
    ("tmm.report", "tmm.exchange"),
    ("tmm.mapping",),
    ("tmm.training",),
    ("tmm.quality",),
    ("tmm.inputs",),
    ("tmm.classify",),
    ("tmm.features",),
    ("tmm.database",),
    ("tmm.images",),
    ("tmm.job",),
    ("mat.measure",),
    ("mat.runtime",),
    ("mat.tables",),
    ("mat.quantities",),
    ("mat.spectroscopy",),
    ("mat.atmosphere",),
    ("mat.surface",),
    ("mat.radiometry",),
    ("mat.kernel",),
    ("mat.threads",),
    ("materials", "atmospheres", "examples"),
    ("schemas",),
)
FLOOR = {folder: number for number, folders in enumerate(FLOORS) for folder in folders}
LOOSE = {"mat.cli", "mat.threads", "tmm.cli"}  # modules beside the folders; the packages themselves are the public API
TABLES_OF_TMM = ("mat.tables", "mat.runtime")  # what tmm may read of mat, and where the Sun stands
SUN = "mat.atmosphere.sources.ephemeris"
TERMINAL = {"click", "rich"}

KNOWS_TERMINAL = ("mat.cli", "mat.commands", "tmm.cli", "tmm.commands", "mat.maintain", "schemas.commands")


@dataclass(frozen=True)
class Import:
    """One import of a module: both ends and the line that makes it."""

    source: str
    target: str
    file: Path
    line: int

    def __str__(self) -> str:
        return f"{self.file.relative_to(CHECKOUT)}:{self.line}: {self.source} imports {self.target}"


def module_name(file: Path) -> str:
    parts = file.relative_to(CHECKOUT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


# The example runtimes are programs of their own, outside the package.
RUNTIMES = CHECKOUT / "examples" / "runtimes"
MODULES = {
    module_name(file): file
    for top in TOP
    for file in sorted((CHECKOUT / top).rglob("*.py"))
    if not file.is_relative_to(RUNTIMES)
}


def imports_of(module: str, file: Path) -> list[tuple[str, int]]:
    """Full names that a module imports, of the project and of others, with their lines."""
    found = []
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found += [(alias.name, node.lineno) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}:{node.lineno}: relative import; imports are written in full"
            found += [(f"{node.module}.{alias.name}", node.lineno) for alias in node.names]
    return found


@cache
def project_imports() -> list[Import]:
    found = []
    for module, file in MODULES.items():
        for name, line in imports_of(module, file):
            if name.startswith((PREFIX, "mat.maintain")):
                target = name.removeprefix(PREFIX)
                target = target if target in MODULES else target.rpartition(".")[0]
                if target in MODULES:
                    found.append(Import(module, target, file, line))
    return found


def folder(module: str) -> str:
    first, *rest = module.split(".")
    return f"{first}.{rest[0]}" if first in ("mat", "tmm") and rest else first


def test_every_module_stands_on_a_floor():
    assert {module for module in MODULES if folder(module) not in FLOOR} == set()


def test_imports_point_downwards():
    upward = [
        str(found)
        for found in project_imports()
        if (ends := (folder(found.source), folder(found.target)))[0] != ends[1] and FLOOR[ends[0]] >= FLOOR[ends[1]]
    ]
    assert not upward, "\n".join(upward)


def test_no_module_stands_in_a_circle():
    below: dict[str, set[str]] = {module: set() for module in MODULES}
    for found in project_imports():
        if found.source != found.target:
            below[found.source].add(found.target)
    try:
        TopologicalSorter(below).prepare()
    except CycleError as error:
        circle = error.args[1]
        lines = [
            str(found)
            for after, before in pairwise(circle)
            for found in project_imports()
            if {found.source, found.target} == {after, before}
        ]
        pytest.fail("\n".join(lines))


def test_no_module_lies_loose_beside_the_folders():
    loose = {
        name
        for name in MODULES
        if name.count(".") == 1 and name.startswith(("mat.", "tmm.")) and MODULES[name].stem != "__init__"
    }
    assert loose == LOOSE


def test_textures_read_only_the_tables_of_mat_and_the_sun():
    wrong = [
        str(found)
        for found in project_imports()
        if found.source.startswith("tmm")
        and folder(found.target).startswith("mat.")
        and folder(found.target) not in TABLES_OF_TMM
        and found.target != SUN
    ]
    assert not wrong, "\n".join(wrong)


def test_only_commands_know_the_terminal():
    wrong = [
        f"{file.relative_to(CHECKOUT)}:{line}: imports {name}"
        for module, file in MODULES.items()
        if not module.startswith(KNOWS_TERMINAL)
        for name, line in imports_of(module, file)
        if name.split(".")[0] in TERMINAL or name.startswith(f"{PREFIX}schemas.commands")
    ]
    assert not wrong, "\n".join(wrong)
