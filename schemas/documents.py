"""YAML documents that know the line of each value, validated into typed models.

Scalars follow the YAML 1.2 core schema, so that ``1e-3`` is a number and ``08:30``, ``on`` and ``2026-06-21`` stay
the text that the model's own field type then reads. Loading never constructs anything but plain Python values.
"""

from __future__ import annotations

import datetime
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path, PurePath
from typing import Annotated, Any, TypeVar, cast

import pydantic
import yaml
from pydantic_core import CoreSchema, ErrorDetails, PydanticCustomError, core_schema

from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.paths import StrPath

Location = tuple[Any, ...]  # keys and list indices
Text = Annotated[str, pydantic.StringConstraints(strip_whitespace=True, min_length=1)]

NODE_LIMIT = 200_000  # nodes of a YAML document, against bombs of aliases
DEPTH_LIMIT = 64  # levels of nesting
BYTE_LIMIT = 20_000_000  # bytes
MAPPING = "<mapping>"  # represents the file of a document that is given as plain data


def _whole_number(value: Any) -> Any:
    if isinstance(value, bool | str):
        raise PydanticCustomError("int_type", "Input should be a valid integer")
    return value


def _not_truth(value: Any) -> Any:
    return _whole_number(value) if isinstance(value, bool) else value  # True equals 1


_DAY = re.compile(r"[0-9]{4}-[0-9]{2}-[0-9]{2}")


def _day(value: Any) -> Any:
    if not (isinstance(value, datetime.date) or (isinstance(value, str) and _DAY.fullmatch(value))):
        raise PydanticCustomError("date_type", "Input should be a valid date, such as 2026-06-21")
    return value


_BEFORE = {"int": _whole_number, "date": _day}


def _as_written(schema: Any) -> Any:
    """A core schema that takes numbers, true and false, and dates as YAML writes them, and converts no text.

    pydantic's own strict mode would refuse lists for tuples, and text for dates.
    """
    if isinstance(schema, list | tuple):
        return type(schema)(_as_written(part) for part in schema)
    if not isinstance(schema, dict):
        return schema
    kind = schema.get("type")
    if kind in ("float", "bool"):
        return schema | {"strict": True}
    if kind in ("int", "date"):
        return core_schema.no_info_before_validator_function(_BEFORE[kind], schema)
    if kind == "literal" and any(isinstance(value, int) for value in schema["expected"]):
        return core_schema.no_info_before_validator_function(_not_truth, schema)
    if kind == "function-before" and schema["function"]["function"] in (*_BEFORE.values(), _not_truth):
        return schema
    skipped = ("metadata", "function", "serialization", "default", "config") if isinstance(kind, str) else ()
    return {key: part if key in skipped else _as_written(part) for key, part in schema.items()}


class StrictModel(pydantic.BaseModel):
    """A frozen model that refuses keys it does not know and names the nearest one that it does.

    Numbers are numbers, not text or true or false; dates are text.
    """

    model_config = pydantic.ConfigDict(
        extra="forbid",
        frozen=True,
        allow_inf_nan=False,
        validate_default=True,
        defer_build=True,  # a part of a job is built within the job, not by itself as well
    )

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: pydantic.GetCoreSchemaHandler) -> CoreSchema:
        return cast(CoreSchema, _as_written(handler(source)))

    @pydantic.model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:
        if isinstance(data, dict):
            allowed = [info.alias or name for name, info in cls.model_fields.items()]
            for key in data:
                if key not in allowed:
                    raise PydanticCustomError(
                        "unknown_key",
                        "unknown key '{key}'; {allowed}",
                        {"key": str(key), "allowed": nearest(key, allowed)},
                    )
        return data


Model = TypeVar("Model", bound=pydantic.BaseModel)


@dataclass(frozen=True)
class Document:
    """Plain data of a YAML file with the place of each key and value.

    Attributes
    ----------
    data : dict, list or scalar
    places : dict of path tuple to (line, column)
        Paths are tuples of keys and list indices; lines and columns count from 1.
    """

    data: Any
    file: Path
    places: Mapping[Location, tuple[int | None, int | None]] = field(repr=False)

    def where(self, location: Location) -> tuple[int | None, int | None]:
        """Line and column of the value at `location`, or of its nearest parent that the file contains."""
        return self.places[self.written(location)]

    def written(self, location: Location) -> Location:
        """The parts of a location that are in the file, without the names of a model's alternatives."""
        path: Location = ()
        for part in location:
            path += (part,) if (*path, part) in self.places else ()
        return path

    def error(self, location: Location, message: str) -> InputError:
        """An `InputError` at the place of `location`."""
        line, column = self.where(location)
        return InputError(message, file=self.file, line=line, column=column)


class _CoreLoader(yaml.SafeLoader):
    """PyYAML's safe loader with the scalars of YAML 1.2."""


class _FastCoreLoader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]  # chosen at run time
    """The same by libyaml, where PyYAML was built with it: a tenth of the time."""


_CoreLoader.yaml_implicit_resolvers = {}
for _tag, _pattern, _first in (
    ("null", r"~|null|Null|NULL|", "~nN"),
    ("bool", r"true|True|TRUE|false|False|FALSE", "tTfF"),
    ("int", r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+", "-+0123456789"),
    (
        "float",
        r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
        "-+.0123456789",
    ),
):
    _CoreLoader.add_implicit_resolver(
        f"tag:yaml.org,2002:{_tag}", re.compile(f"^(?:{_pattern})$"), list(_first) + ([""] if _tag == "null" else [])
    )
_FastCoreLoader.yaml_implicit_resolvers = _CoreLoader.yaml_implicit_resolvers

_TAG = "tag:yaml.org,2002:"


def _scalar(node: yaml.ScalarNode, file: Path) -> Any:
    text, tag = node.value, node.tag.removeprefix(_TAG)
    if tag == "str":
        return text
    if tag == "null":
        return None
    if tag == "bool":
        return text.lower() == "true"
    try:
        if tag == "int":
            base = {"0o": 8, "0x": 16}.get(text[:2].lower(), 10)
            return int(text, base)
        if tag == "float":
            return float(text.lower().replace(".inf", "inf").replace(".nan", "nan"))
    except ValueError as error:
        raise _at(node, file, f"found '{text[:40]}', which is not a number: {error}") from None
    raise _at(node, file, f"found the tag '{node.tag}'; allowed: plain values without tags; remove the tag")


def _at(node: yaml.Node, file: Path, message: str) -> InputError:
    mark = node.start_mark
    return InputError(message, file=file, line=mark.line + 1, column=mark.column + 1)


class _Builder:
    """Turns YAML nodes into plain data and notes the place of each value."""

    def __init__(self, file: Path) -> None:
        self.file, self.count = file, 0
        self.places: dict[Location, tuple[int, int]] = {}

    def build(self, node: yaml.Node, path: Location) -> Any:
        self.count += 1
        if self.count > NODE_LIMIT or len(path) > DEPTH_LIMIT:
            raise _at(
                node,
                self.file,
                f"the document has more than {NODE_LIMIT} values or {DEPTH_LIMIT} levels once its aliases are "
                "expanded; write it without nested aliases",
            )
        self.places[path] = (node.start_mark.line + 1, node.start_mark.column + 1)
        if isinstance(node, yaml.ScalarNode):
            return _scalar(node, self.file)
        if isinstance(node, yaml.SequenceNode):
            self._plain_tag(node, "seq")
            return [self.build(child, (*path, i)) for i, child in enumerate(node.value)]
        assert isinstance(node, yaml.MappingNode)
        self._plain_tag(node, "map")
        return self._mapping(node, path)

    def _plain_tag(self, node: yaml.Node, kind: str) -> None:
        if node.tag != _TAG + kind:
            raise _at(node, self.file, f"found the tag '{node.tag}'; allowed: plain values without tags; remove it")

    def _mapping(self, node: yaml.MappingNode, path: Location) -> dict[Any, Any]:
        data: dict[Any, Any] = {}
        for key_node, value_node in node.value:
            if not isinstance(key_node, yaml.ScalarNode):
                raise _at(key_node, self.file, "found a list or mapping as a key; allowed: plain text keys")
            key = _scalar(key_node, self.file)
            if key in data:
                earlier = self.places[(*path, key)]
                raise _at(
                    key_node,
                    self.file,
                    f"key '{key}' occurs twice (first at line {earlier[0]}); allowed: each key once; remove one",
                )
            data[key] = self.build(value_node, (*path, key))
            mark = (key_node.start_mark.line + 1, key_node.start_mark.column + 1)
            self.places[(*path, key, KEY)] = mark
            if not isinstance(value_node, yaml.ScalarNode):
                self.places[(*path, key)] = mark
        return data


KEY = "\0key"  # path suffix under which the place of a key, rather than of its value, is kept


def read_yaml(file: StrPath) -> Document:
    """Read a YAML file into plain data with positions.

    Raises
    ------
    InputError
        The file is missing, is not UTF-8 or YAML, is empty, repeats a key, uses tags, or is unreasonably large.
    """
    file = Path(file)
    try:
        if file.exists() and not (file.is_file() or file.is_dir()):
            raise InputError("is a pipe, socket or device; allowed: a regular file; name one", file=file)
        if file.stat().st_size > BYTE_LIMIT:
            raise InputError(f"found {file.stat().st_size} bytes; allowed: at most {BYTE_LIMIT}", file=file)
        text = file.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}; check the path", file=file) from None
    except UnicodeDecodeError as error:
        raise InputError(f"is not UTF-8 text (byte {error.start}); save it as UTF-8", file=file) from None
    except ValueError:
        raise InputError("is no path: it contains a null character", file=repr(str(file))) from None
    return document_of(text, file)


def read_document(source: StrPath | Mapping[str, Any], folder: Path | None = None) -> Document:
    """Read a YAML file, or the same content as plain data.

    Parameters
    ----------
    source : path or mapping
    folder : Path, optional
        Folder to which the paths in a mapping are relative; by default the working directory.

    Raises
    ------
    InputError
        Those of `read_yaml` and `mapping_document`.
    """
    return mapping_document(source, folder or Path.cwd()) if isinstance(source, Mapping) else read_yaml(source)


def mapping_document(data: Mapping[str, Any], folder: StrPath) -> Document:
    """A document whose content is given as plain data; its paths are relative to a folder, its errors name no line.

    Numbers and arrays of numpy, paths, tuples and mappings of any kind are read as plain values.

    Raises
    ------
    InputError
        The data contain what YAML cannot, or too much of it.

    Examples
    --------
    >>> import numpy as np
    >>> mapping_document({"range_km": np.linspace(0, 1, 3), "slope_deg": np.int64(90)}, ".").data
    {'range_km': [0.0, 0.5, 1.0], 'slope_deg': 90}
    """
    file = Path(folder) / MAPPING
    try:
        text = yaml.dump(data, Dumper=_plain_dumper(), sort_keys=False, allow_unicode=True)
    except (yaml.YAMLError, RecursionError, TypeError, ValueError) as error:
        raise InputError(
            f"contains what YAML does not: {error}; give plain numbers, texts, lists and mappings"
        ) from None
    if len(text) > BYTE_LIMIT:
        raise InputError(f"found {len(text)} characters; allowed: at most {BYTE_LIMIT}", file=file)
    document = document_of(text, file)
    return replace(document, places=dict.fromkeys(document.places, (None, None)))


@cache
def _plain_dumper() -> type[yaml.SafeDumper]:
    """A dumper of YAML that also takes containers of plain values: of numpy, paths, tuples, mappings."""
    import numpy as np  # not by the commands, which read files

    class PlainDumper(yaml.SafeDumper):
        """With representers of its own."""

    def plain(kind: type[Any], convert: Callable[[Any], Any]) -> None:
        PlainDumper.add_multi_representer(kind, lambda dumper, value: dumper.represent_data(convert(value)))

    plain(np.generic, lambda value: value.item())
    plain(np.ndarray, lambda value: value.tolist())
    plain(PurePath, str)
    plain(tuple, list)
    plain(Mapping, dict)
    return PlainDumper


def plain_value(text: str, file: StrPath, line: int) -> Any:
    """The plain value that a text is in YAML, for a cell of a table.

    Raises
    ------
    InputError
        It is not a plain YAML value.
    """
    try:
        return document_of(text, Path(file)).data if text else None
    except InputError as error:
        raise InputError(error.message, file=file, line=line) from None


def _composed(text: str) -> yaml.Node | None:
    try:
        return yaml.compose(text, Loader=_FastCoreLoader)
    except (yaml.YAMLError, UnicodeError):
        # What is wrong is said in the words of PyYAML, which are the same wherever this runs.
        return yaml.compose(text, Loader=_CoreLoader)


def document_of(text: str, file: Path) -> Document:
    """The document that a text in YAML or JSON writes.

    Raises
    ------
    InputError
        As `read_yaml`.
    """
    try:
        node = _composed(text)
    except (yaml.YAMLError, RecursionError) as error:
        mark = getattr(error, "problem_mark", None)
        problem = getattr(error, "problem", None) or str(error) or "too deeply nested"
        raise InputError(
            f"is not valid YAML: {problem}; correct the syntax here",
            file=file,
            line=mark.line + 1 if mark else None,
            column=mark.column + 1 if mark else None,
        ) from None
    if node is None:
        raise InputError("is empty; write at least one key", file=file)
    builder = _Builder(file)
    data = builder.build(node, ())
    return Document(data=data, file=file, places=dict(builder.places))


def parse_model(document: Document, model: type[Model], context: Any = None) -> Model:
    """Validate a document into a typed model.

    Raises
    ------
    InputError
        At the file:line:column of the first value that does not fit.
    """
    try:
        return model.model_validate(document.data, context=context)
    except pydantic.ValidationError as error:
        problems = error.errors(include_url=False)
        raise _located(document, _telling(problems), problems) from None


def _telling(problems: list[ErrorDetails]) -> ErrorDetails:
    """The first problem; of a mapping in the place of a word, the first inside it."""
    if problems[0]["type"] == "literal_error" and isinstance(problems[0]["input"], dict):
        where = problems[0]["loc"][:-1]
        inside = (problem for problem in problems[1:] if problem["loc"][: len(where)] == where)
        return next((problem for problem in inside if len(problem["loc"]) > len(where) + 1), problems[0])
    return problems[0]


def _located(document: Document, problem: ErrorDetails, problems: list[ErrorDetails]) -> InputError:
    """The error of a problem, with the other lines that have one."""
    location = _place(problem)
    name = ".".join(str(part) for part in document.written(problem["loc"]))
    places = {document.where(_place(other))[0] for other in problems} - {None, document.where(location)[0]}
    lines = [str(line) for line in sorted(filter(None, places))]
    more = f" (wrong too: line{'s' * (len(lines) > 1)} {', '.join(lines)})" if lines else ""
    return document.error(location, (f"{name}: " if name else "") + problem_text(problem) + more)


def _place(problem: ErrorDetails) -> Location:
    """Location of a problem: of an unknown key, that of the key itself."""
    key = (problem["ctx"]["key"], KEY) if problem["type"] == "unknown_key" else ()
    return (*problem["loc"], *key)


def problem_text(problem: ErrorDetails) -> str:
    """What was found and what is allowed, of a problem of a typed model, without its place."""
    text = problem["msg"].removeprefix("Value error, ")
    if problem["type"] == "missing":
        return f"the key '{problem['loc'][-1]}' is missing; add it"
    if problem["type"] in ("unknown_key", "value_error"):
        return text
    return f"found {_shown(problem['input'])}; {text[0].lower()}{text[1:]}"


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def load_model(file: StrPath, model: type[Model], context: Any = None) -> Model:
    """Read a YAML file and validate it into a typed model; see `read_yaml` and `parse_model` for what they raise."""
    return parse_model(read_yaml(file), model, context)
