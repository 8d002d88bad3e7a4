"""Faults that change the form of an expression: a term or factor less, operands or an index exchanged, any for all."""

from __future__ import annotations

import ast
from collections.abc import Iterator

_EXCHANGED = {"any": "all", "all": "any"}


def rewrites(source: str) -> list[tuple[int, str]]:
    """Every such fault of a module: its line, and the whole text with it.

    Only expressions of one line are changed, and none within messages, texts and assertions.

    Examples
    --------
    >>> [text for _, text in rewrites("y = a - b\\n")]
    ['y = a\\n', 'y = b - a\\n']
    >>> [text for _, text in rewrites("y = x[0] ** 2\\n")]
    ['y = x[0]\\n', 'y = x[1] ** 2\\n']
    """
    tree = ast.parse(source)
    lines = source.splitlines(keepends=True)
    passed_over = _lines_of(tree, ast.Raise, ast.JoinedStr, ast.Import, ast.ImportFrom, ast.Assert)
    found = []
    for node in ast.walk(tree):
        if not isinstance(node, ast.expr) or node.lineno != node.end_lineno or node.lineno in passed_over:
            continue
        line = lines[node.lineno - 1].encode()
        for new in _replacements(node, source):
            text = (line[: node.col_offset] + new.encode() + line[node.end_col_offset :]).decode()
            changed = "".join([*lines[: node.lineno - 1], text, *lines[node.lineno :]])
            if text != lines[node.lineno - 1] and _is_python(changed):
                found.append((node.lineno, changed))
    return found


def _replacements(node: ast.expr, source: str) -> Iterator[str]:
    """What may stand in the place of an expression."""
    if isinstance(node, ast.BinOp):
        left, right = (_bracketed(each, source) for each in (node.left, node.right))
        if isinstance(node.op, ast.Add):
            yield left
            yield right
        elif isinstance(node.op, ast.Sub):
            yield left
            yield f"{right} - {left}"
        elif isinstance(node.op, ast.Mult):
            yield left
            yield right
        elif isinstance(node.op, ast.Div):
            yield left
            yield f"{right} / {left}"
        elif isinstance(node.op, ast.Pow):
            yield left
    elif isinstance(node, ast.Call):
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if name in _EXCHANGED:
            whole = ast.get_source_segment(source, node) or ""
            called = ast.get_source_segment(source, node.func) or ""
            yield called.removesuffix(name) + _EXCHANGED[name] + whole.removeprefix(called)
    elif isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Load):
        index = node.slice
        if isinstance(index, ast.Constant) and type(index.value) is int:
            yield f"{ast.get_source_segment(source, node.value)}[{index.value + 1}]"


def _bracketed(node: ast.expr, source: str) -> str:
    text = ast.get_source_segment(source, node) or ""
    return f"({text})" if isinstance(node, ast.BinOp | ast.IfExp | ast.Compare | ast.BoolOp | ast.UnaryOp) else text


def _lines_of(tree: ast.AST, *kinds: type[ast.AST]) -> set[int]:
    return {
        number
        for node in ast.walk(tree)
        if isinstance(node, kinds)
        for number in range(node.lineno, node.end_lineno + 1)  # type: ignore[attr-defined]
    }


def _is_python(text: str) -> bool:
    try:
        compile(text, "changed", "exec")
    except SyntaxError:
        return False
    return True
