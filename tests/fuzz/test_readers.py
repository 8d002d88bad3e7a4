"""Changed inputs make every reader of text answer or refuse with one line: never another exception, never a file."""

import importlib.util
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from skyshine.schemas.errors import InputError

_spec = importlib.util.spec_from_file_location("readers", Path(__file__).with_name("readers.py"))
readers = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(readers)

PIECES = st.one_of(
    st.binary(max_size=6),
    st.sampled_from(
        [
            b"-1",
            b"1e999",
            b"nan",
            b"9" * 30,
            b"[",
            b"{",
            b": ",
            b"\n",
            b",",
            b"\0",
            b"!!python/x",
            b"&a *a",
            b"../../x",
            b'"',
        ]
    ),
)
CHANGES = st.lists(st.tuples(st.floats(0, 1), st.integers(0, 40), PIECES), max_size=4)


@pytest.mark.parametrize("target", sorted({*readers.TEXTS, "material", "specular"}))
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture], derandomize=True)
@given(pick=st.integers(0, 100), changes=CHANGES)
def test_a_changed_input_is_read_or_refused_in_one_line(target, tmp_path, pick, changes):
    corpus = readers.seeds(target)
    data = corpus[pick % len(corpus)]
    for place, length, piece in changes:
        at = int(place * len(data))
        data = data[:at] + piece + data[at + length :]
    try:
        readers.read(target, data, tmp_path)
    except InputError as error:
        assert "\n" not in str(error)
    assert {path.stem for path in tmp_path.iterdir()} == {"in"}
