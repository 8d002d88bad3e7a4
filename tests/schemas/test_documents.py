"""YAML documents: the traps of the language, places of errors, limits."""

from pathlib import Path
from typing import Literal

import pytest
import yaml
from pydantic import Field

from skyshine import examples, materials
from skyshine.schemas import documents
from skyshine.schemas.documents import StrictModel, load_model, read_yaml
from skyshine.schemas.errors import InputError


class Item(StrictModel):
    altitude_km: float = Field(ge=0)
    start: str = ""


class Sheet(StrictModel):
    items: list[Item]
    count: int = 1


def write(tmp_path, text):
    file = tmp_path / "job.yaml"
    file.write_text(text, encoding="utf-8")
    return file


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("08:30", "08:30"),
        ("12:30", "12:30"),
        ("1e-3", 1e-3),
        ("1.5E+2", 150.0),
        (".5", 0.5),
        ("0o17", 15),
        ("017", 17),
        ("on", "on"),
        ("no", "no"),
        ("true", True),
        ("~", None),
        ("2026-06-21", "2026-06-21"),
        ("'1e3'", "1e3"),
        ("1_000", "1_000"),
    ],
)
def test_scalars_follow_yaml_1_2(tmp_path, text, value):
    read = read_yaml(write(tmp_path, f"key: {text}\n")).data["key"]
    assert read == value and type(read) is type(value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("items:\n  - altitud_km: 3\n", "2:5: items.0: unknown key 'altitud_km'; did you mean 'altitude_km'?"),
        ("items:\n  - altitude_km: high\n", "2:18: items.0.altitude_km: found 'high'; input should be a valid number"),
        ("items:\n  - {altitude_km: -1}\n", "2:19: items.0.altitude_km: found -1; input should be greater than"),
        ("items: []\ncount: 1\ncount: 2\n", "3:1: key 'count' occurs twice (first at line 2)"),
        ("count: 2\n", "1:1: the key 'items' is missing; add it"),
        ("items: [\n", "is not valid YAML"),
        ("", "is empty; write at least one key"),
        ("items: !!python/object/apply:os.system [ls]\n", "1:8: found the tag"),
        ("items: !custom {}\n", "1:8: found the tag '!custom'"),
        ("? [a, b]\n: 1\n", "found a list or mapping as a key"),
        ("items: .nan\n", "items: found nan"),
        ("items:\n  - altitude_km: .inf\n", "2:18: items.0.altitude_km: found inf"),
    ],
)
def test_bad_documents_give_one_line_with_its_place(tmp_path, text, message):
    file = write(tmp_path, text)
    with pytest.raises(InputError) as caught:
        load_model(file, Sheet)
    line = str(caught.value)
    assert line.startswith(str(file)) and message in line and "\n" not in line


def test_an_alias_bomb_is_refused(tmp_path):
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 9)]
    with pytest.raises(InputError, match="aliases"):
        read_yaml(write(tmp_path, "\n".join(lines)))


def test_a_document_that_contains_itself_is_refused(tmp_path):
    with pytest.raises(InputError, match="aliases"):
        read_yaml(write(tmp_path, "a: &a\n  b: *a\n"))


def test_deep_nesting_is_refused(tmp_path):
    with pytest.raises(InputError):
        read_yaml(write(tmp_path, "[" * 5000 + "]" * 5000))


def test_a_missing_file_and_bytes_that_are_not_text(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        read_yaml(tmp_path / "none.yaml")
    (tmp_path / "b.yaml").write_bytes(b"a: \xff\xfe\n")
    with pytest.raises(InputError, match="UTF-8"):
        read_yaml(tmp_path / "b.yaml")


def test_libyaml_reads_what_pyyaml_reads():
    """Values and their places, of every document that comes with the package and of what is written in odd ways."""
    odd = "a: [1, {b: 'x', c: 2}]\n? d\n: |\n  text\n\n  more\n"
    odd += "'e\u00e9\U0001f600': >-\n  folded\n  line\nf: &x {y: 08:30}\n"
    files = [*Path(examples.__file__).parent.rglob("*.yaml"), *materials.path().rglob("*.yaml")]
    assert len(files) > 100
    for text in (odd, *(file.read_text(encoding="utf-8") for file in files)):
        fast, slow = (
            yaml.compose(text, Loader=loader) for loader in (documents._FastCoreLoader, documents._CoreLoader)
        )
        read = [documents._Builder(Path("x")) for _ in range(2)]
        assert read[0].build(fast, ()) == read[1].build(slow, ())
        assert read[0].places == read[1].places


class Weighted(StrictModel):
    weights: Literal["equal"] | dict[str, float] = "equal"


def test_a_wrong_value_in_a_mapping_that_may_be_a_word_is_found_inside_the_mapping(tmp_path):
    file = write(tmp_path, "weights: {sand: 1, soil: wet}")
    with pytest.raises(InputError, match=r"job.yaml:1:26: weights.soil: found 'wet'"):
        load_model(file, Weighted)


def test_the_lines_of_other_mistakes_are_named_beside_the_first(tmp_path):
    file = write(tmp_path, "items:\n  - altitud_km: 3\n  - altitude_km: high\n  - {altitude_km: 1}\n  - lat: 3\n")
    with pytest.raises(InputError, match=r"2:5: .* \(wrong too: lines 3, 5\)$"):
        load_model(file, Sheet)
