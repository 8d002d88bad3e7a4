"""Faults in the form of expressions: what they are, and that they are Python."""

import importlib.util
from pathlib import Path

import pytest

_spec = importlib.util.spec_from_file_location("rewrites", Path(__file__).with_name("rewrites.py"))
rewrites = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(rewrites)


@pytest.mark.parametrize(
    ("source", "texts"),
    [
        ("y = a + b", {"y = a", "y = b"}),
        ("y = a - b", {"y = a", "y = b - a"}),
        ("y = a / (b + c)", {"y = a", "y = (b + c) / a", "y = a / (b)", "y = a / (c)"}),
        ("y = (r + 1) ** 2", {"y = (r + 1)", "y = (r) ** 2", "y = (1) ** 2"}),
        ("if np.all(x): pass", {"if np.any(x): pass"}),
        ("if any(x): pass", {"if all(x): pass"}),
        ("y = x[0]", {"y = x[1]"}),
        ("assert a + b == c", set()),
        ("z = f'{a + b}'", set()),
    ],
)
def test_forms(source, texts):
    assert {text.strip() for _, text in rewrites.rewrites(source + "\n")} == texts


def test_a_fault_is_on_its_line_alone():
    source = "a = 1\n\u00b5 = b * c  # micro\nd = 2\n"
    assert {(line, text.splitlines()[1]) for line, text in rewrites.rewrites(source)} == {
        (2, "\u00b5 = b  # micro"),
        (2, "\u00b5 = c  # micro"),
    }
