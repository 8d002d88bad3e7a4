"""Plain words in the code: no vague variable names, and docstring entries that begin with a noun."""

import ast
import io
import itertools
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
VAGUE = re.compile(  # words that name no quantity of the field
    "_*("
    "all|any|asked|around|cool|done|each|every|few|first|found|free|given|grounded|had|held|kept|known|last|"
    "least|left|lit|made|met|missed|most|none|one|other|own|parted|place|placed|places|rest|said|same|seen|"
    "shared|shown|some|taken|tied|told|tried|turned|under|used|wanted|warm|whole|worst|written"
    ")_*"
)
PREPOSITION = re.compile(
    "(As|At|Behind|Beside|Between|By|For|From|In|Of|On|Over|Than|That|Through|To|Under|Until|Where|Which|Whose|With)\\b"
)
NAMES, ENTRIES = 0.01, 0.05  # largest shares; codebases of the field have 0.001 to 0.007 and 0 to 0.02
UNEXPLAINED = 0.05  # largest share of numeric constants without a comment
PLAIN = [  # all folders of the package
    *("tmm", "schemas", "materials"),
    *(f"mat/{folder.name}" for folder in sorted((ROOT / "mat").iterdir()) if any(folder.glob("*.py"))),
]
ZERO = re.compile(r"(?:^|(?<=[\s(|/~<>=±`]))-?\.\d(?!sc)", re.M)  # ".9 K" without its zero
DIALECT = re.compile(  # a stand of leaves and days that are held out are the field's words
    r"\b(holds?(?! out|`| :| the last day out| is 0)|stood|told (?:by|apart|from)|is worth|left out of|buys|"
    r"stands? (?:above|alone|at|before|between|for|here|higher|in|lower|on|still|there|through|up))\b",
    re.I,
)
TEXTS = [".md", ".c", ".h", ".rs", ".js", ".ts", ".ipynb", ".yaml"]  # beside comments and strings of Python
DOCUMENTED = ast.Module, ast.ClassDef, ast.FunctionDef


def names(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Line and name of each variable and parameter that a module binds."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.id
        elif isinstance(node, ast.arg) and node.arg not in ("self", "cls"):
            yield node.lineno, node.arg


def entries(tree: ast.AST) -> Iterator[str]:
    """First line of each description below Parameters and Attributes."""
    for node in ast.walk(tree):
        if isinstance(node, DOCUMENTED) and (text := ast.get_docstring(node)):
            for section in re.split(r"(?m)^(?=\w[\w ]*\n-+$)", text):
                if re.match("(Parameters|Attributes)\n", section):
                    yield from re.findall(r"(?m)^\S.*:.*\n\s+(\S.*)$", section)


def read(folder: str) -> tuple[list[str], list[str], int, int]:
    """Vague names with their places, entries without a noun, and the numbers of all names and entries."""
    vague, bare, bound, described = [], [], 0, 0
    for file in sorted((ROOT / folder).rglob("*.py")):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        bindings, texts = list(names(tree)), list(entries(tree))
        vague += [f"{file.relative_to(ROOT)}:{line} {name}" for line, name in bindings if VAGUE.fullmatch(name)]
        bare += [f"{file.relative_to(ROOT)} {text}" for text in texts if PREPOSITION.match(text)]
        bound, described = bound + len(bindings), described + len(texts)
    return vague, bare, bound, described


def sentences(file: Path) -> str:
    """Text of a page or of sources in another language; strings and comments of Python."""
    text = file.read_text(encoding="utf-8")
    if file.suffix != ".py":
        return text if file.suffix in TEXTS else ""
    if not ZERO.search(text):  # tokens take long
        return ""
    words = tokenize.generate_tokens(io.StringIO(text).readline)
    return "\n".join(word.string.strip("\"'#") for word in words if word.type in (tokenize.STRING, tokenize.COMMENT))


def is_number(node: ast.AST) -> bool:
    """Whether a value is a number, a tuple of numbers, or arithmetic with one."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int | float) and not isinstance(node.value, bool)
    if isinstance(node, ast.Tuple | ast.List):
        return bool(node.elts) and all(map(is_number, node.elts))
    if isinstance(node, ast.UnaryOp):
        return is_number(node.operand)
    sides = [node.left, node.right] if isinstance(node, ast.BinOp) else []
    return any(map(is_number, sides)) and all(is_number(side) or isinstance(side, ast.Name) for side in sides)


def constants(text: str) -> Iterator[tuple[int, bool]]:
    """Line of each numeric constant of a module; whether it, or its paragraph above it, has a comment."""
    lines = text.splitlines()
    for node in ast.parse(text).body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None and is_number(node.value):
            target = ast.unparse(node.targets[0] if isinstance(node, ast.Assign) else node.target)
            if target == target.upper():
                paragraph = itertools.takewhile(str.strip, reversed(lines[: node.end_lineno]))
                code = itertools.takewhile(
                    lambda line: not line.startswith(("import", "from", "def", "class")), paragraph
                )
                yield node.lineno, any("#" in line for line in code)


def test_constants_have_a_unit_and_a_reason() -> None:
    found = {
        f"{file.relative_to(ROOT)}:{line}": explained
        for folder in ("mat", "tmm", "schemas", "materials")
        for file in sorted((ROOT / folder).rglob("*.py"))
        for line, explained in constants(file.read_text(encoding="utf-8"))
    }
    bare = [place for place, explained in found.items() if not explained]
    assert len(found) > 1000 and len(bare) <= UNEXPLAINED * len(found), f"say unit and reason: {'; '.join(bare)}"


@pytest.mark.parametrize("folder", ["atmospheres", "examples", "mat", "materials", "schemas", "tmm"])
def test_numbers_have_their_zero(folder: str) -> None:
    files = [*(ROOT / folder).rglob("*.*"), *ROOT.glob("*.md")]
    lacking = [
        f"{file.relative_to(ROOT)}: {' '.join(line.split())[:80]}"
        for file in files
        if file.suffix in (".py", *TEXTS) and not {"node_modules", "target", "build"} & {*file.parts}
        for line in sentences(file).splitlines()
        if ZERO.search(line) and not re.search(r"\drem|\dmm;|0-9|fortran", line)
    ]
    assert not lacking, "write 0.9, not .9: " + "; ".join(lacking[:20])


@pytest.mark.parametrize("folder", PLAIN)
def test_names_and_entries_are_plain(folder: str) -> None:
    vague, bare, bound, described = read(folder)
    # `left` beside `top` and `right` is the side of a window in tmm, a word of the field.
    assert len(vague) <= NAMES * bound, "name these by the field's noun: " + "; ".join(vague)
    assert len(bare) <= ENTRIES * described, "begin these with a noun: " + "; ".join(bare)


def test_counts_notice_vague_words() -> None:
    tree = ast.parse(
        'def f(found, path):\n    """F.\n\n    Parameters\n    ----------\n    path : str\n        Of x.\n    """'
    )
    assert [name for _, name in names(tree) if VAGUE.fullmatch(name)] == ["found"]
    assert list(entries(tree)) == ["Of x."] and PREPOSITION.match("Of x.")
    assert list(constants("A = 1\n\nB = 2  # [K]\n\n# Of both.\nC, D = 3, 4\n")) == [(1, False), (3, True), (6, True)]
    assert [bool(ZERO.search(text)) for text in ("errs by .9 K", "(-.5)", "0.9 K", "v1.2 and .md")] == [1, 1, 0, 0]
    assert CLIPPED.match("# of a day") and not CLIPPED.match("# steps of a day")
    assert [bool(DIALECT.search(text)) for text in ("it holds so", "cannot be told apart", "days held out")] == [
        1,
        1,
        0,
    ]


CLIPPED = re.compile(r"#\s*of\b", re.I)  # a comment that begins without its noun


def said(file: Path) -> Iterator[str]:
    """Sentences of a page; strings, docstrings and comments of a module."""
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".md":
        yield text
    elif DIALECT.search(text) or CLIPPED.search(text):  # tokens take long
        after = 0  # line after that of the last comment, which a comment there goes on
        for word in tokenize.generate_tokens(io.StringIO(text).readline):
            if word.type in (tokenize.STRING, tokenize.COMMENT):
                yield word.string.lstrip("# ") if word.start[0] == after else word.string
            if word.type == tokenize.COMMENT:
                after = word.start[0] + 1


def test_sentences_are_plain() -> None:
    """Help, errors, docstrings, comments, pages; comments begin with a noun or a verb's subject."""
    folders = ("mat", "tmm", "schemas", "materials", "atmospheres", "examples")
    files = [*ROOT.glob("*.md"), *(file for folder in folders for file in (ROOT / folder).rglob("*.*"))]
    dialect = [
        f"{file.relative_to(ROOT)}: {text[max(0, found.start() - 40) : found.end() + 20]!r}"
        for file in files
        if file.suffix in (".py", ".md") and not {"maintain", "node_modules", "target"} & {*file.parts}
        for text in said(file)
        for found in [*DIALECT.finditer(text), *[match for match in [CLIPPED.match(text)] if match]]
    ]
    assert not dialect, "\n".join(dialect)
