"""Pages of all keys of a YAML file, from the JSON Schema that its model writes: ``schemas/keys`` of the checkout.

``python -m mat.maintain.job_schema schemas`` writes them beside the schemas.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

from skyshine import schemas

Schema = dict[str, Any]

TITLES = {
    "mat-job.schema.json": "Keys of a job of `mat`",
    "mat-scene.schema.json": "Keys of a scene",
    "mat-frame.schema.json": "Keys of a frame of another renderer",
    "tmm-job.schema.json": "Keys of a job of `tmm`",
    "material-index.schema.json": "Keys of `mat.yaml`, the index of materials",
    "material-ht.schema.json": "Keys of `ht/NAME.yaml`, the thermal stack of a material",
    "material-spec.schema.json": "Keys of `spec/NAME.yaml`, the specular lobe of a material",
}
# Units by the end of a key; the first that fits counts, so longer ends precede shorter ones.
UNITS = {
    "_w_m2_k": "W m^-2 K^-1",
    "_j_m2_k": "J m^-2 K^-1",
    "_w_m2": "W m^-2",
    "_g_m2": "g m^-2",
    "_mm_h": "mm/h",
    "_m_s": "m/s",
    "_gigabytes": "GB",
    "_percent": "%",
    "_days": "days",
    "_hpa": "hPa",
    "_ppm": "ppm",
    "_deg": "degree",
    "_cm": "cm^-1",
    "_mm": "mm",
    "_du": "DU",
    "_um": "um",
    "_km": "km",
    "_c": "Celsius",
    "_h": "h",
    "_k": "K",
    "_m": "m",
}
LONGEST_DEFAULT = 60  # characters that fit a cell; chosen


def page(name: str) -> str:
    """Text of the page of one schema.

    Parameters
    ----------
    name : str
        File name of the schema, such as ``mat-job.schema.json``.
    """
    root = json.loads(schemas.path(name).read_text(encoding="utf-8"))
    definitions = root.get("$defs", {})
    lines = [
        f"# {TITLES[name]}",
        "",
        f"Generated from `schemas/{name}`, by which files are checked. {root['description']}",
    ]
    sections = list(_sections(root, definitions))
    places = dict(zip((id(model) for _, model in sections), anchors([path for path, _ in sections]), strict=True))
    for path, model in sections:
        if path:
            lines += ["", f"## `{path}`", "", _one_line(model.get("description", ""))]
        lines += ["", "| key | value | default | what |", "|---|---|---|---|"]
        required = model.get("required", [])
        for key, rule in model["properties"].items():
            value = _cell(_value(rule, definitions, places) + _unit(key))
            lines.append(f"| `{key}` | {value} | {_default(key, rule, required)} | {_cell(rule['description'])} |")
    return "\n".join(lines) + "\n"


def file_name(name: str) -> str:
    """Name of the page of a schema, such as ``mat-job.md``."""
    return name.replace(".schema.json", ".md")


def anchors(paths: list[str]) -> list[str]:
    """Targets of links to headings such as ``states[].weather``, by the rule of GitHub, which the site follows.

    Examples
    --------
    >>> anchors(["bands", "bands[]", "states[].weather"])
    ['bands', 'bands-1', 'statesweather']
    """
    slugs = [re.sub(r"[^\w -]", "", path.lower()).replace(" ", "-") for path in paths]
    return [f"{slug}-{count}" if (count := slugs[:k].count(slug)) else slug for k, slug in enumerate(slugs)]


def _sections(root: Schema, definitions: Schema) -> Iterator[tuple[str, Schema]]:
    """Every model with its first path, in the order of the keys."""
    waiting, visited = [("", root)], {id(root)}
    while waiting:
        path, model = waiting.pop(0)
        yield path, model
        below: list[tuple[str, Schema]] = []
        for key, rule in model["properties"].items():
            for ends, part in _models(rule, definitions):
                if id(part) not in visited:
                    visited.add(id(part))
                    heading = f"{path}.{key}{ends}".lstrip(".")
                    duplicate = any(heading == existing for existing, _ in below)  # a value of two kinds
                    below.append((f"{heading} ({part['title']})" if duplicate else heading, part))
        waiting = below + waiting


def _models(rule: Schema, definitions: Schema) -> Iterator[tuple[str, Schema]]:
    """Models that a value may be, or a list or mapping of it may contain, with what then follows the key."""
    if "$ref" in rule:
        model = _resolved(rule, definitions)
        if _plain(model) is None:
            yield "", model
    for part in [*rule.get("anyOf", []), *rule.get("oneOf", [])]:
        yield from _models(part, definitions)
    inner = rule.get("items")
    if isinstance(inner, dict):
        yield from ((f"[]{more}", model) for more, model in _models(inner, definitions))
    by_name = _by_name(rule)
    if by_name is not None:
        yield from ((f".NAME{more}", model) for more, model in _models(by_name, definitions))


def _by_name(rule: Schema) -> Schema | None:
    """Rule of the values of a mapping whose keys are names."""
    parts = [rule.get("additionalProperties"), *rule.get("patternProperties", {}).values()]
    return next((part for part in parts if isinstance(part, dict)), None)


def _resolved(rule: Schema, definitions: Schema) -> Schema:
    definition: Schema = definitions[rule["$ref"].rpartition("/")[2]]
    return definition


def _plain(model: Schema) -> Schema | None:
    """Rule of the value of a model that only adds a source to it, which a plain value may replace; else None."""
    for part in model.get("anyOf", []):
        if set(part.get("properties", {})) == {"value", "source"}:
            value: Schema = part["properties"]["value"]
            return value
    return None


def _value(rule: Schema, definitions: Schema, places: dict[int, str]) -> str:
    """What a value may be, in words; links lead to the places of models on the page."""
    if "$ref" in rule:
        model = _resolved(rule, definitions)
        plain = _plain(model)
        if plain is not None:
            return f"{_value(plain, definitions, places)}; or `value` with `source`"
        return f"[keys](#{places[id(model)]})" if id(model) in places else "keys"
    several = [part for part in [*rule.get("anyOf", []), *rule.get("oneOf", [])] if part.get("type") != "null"]
    if several:
        return " or ".join(dict.fromkeys(_value(part, definitions, places) for part in several))
    if "const" in rule or "enum" in rule:
        return ", ".join(f"`{value}`" for value in rule.get("enum", [rule.get("const")]))
    kind = rule.get("type", "value")
    if kind == "array":
        if "prefixItems" in rule:
            items = [_value(part, definitions, places) for part in rule["prefixItems"]]
            return f"[{', '.join(items)}]" if len(set(items)) > 1 else f"{len(items)} times {items[0]}"
        minimum, maximum = rule.get("minItems", 0), rule.get("maxItems")
        count = f"{maximum}, each " if minimum == maximum and maximum else ""
        return f"list of {count}{_value(rule.get('items', {}), definitions, places)}"
    if kind == "object":
        inner = _by_name(rule)
        return f"by name: {_value(inner, definitions, places)}" if inner is not None else "keys by name"
    words = {"number": "number", "integer": "whole number", "string": "text", "boolean": "`true`, `false`"}
    return str(words.get(kind, kind)) + _limits(rule)


def _limits(rule: Schema) -> str:
    low = rule.get("minimum", rule.get("exclusiveMinimum"))
    high = rule.get("maximum", rule.get("exclusiveMaximum"))
    above = "above " if "exclusiveMinimum" in rule else ""
    if low is not None and high is not None:
        return f", {above}{low:g} to {high:g}"
    if low is not None:
        return f", {above or 'at least '}{low:g}"
    return "" if high is None else f", at most {high:g}"


def _unit(key: str) -> str:
    unit = next((unit for end, unit in UNITS.items() if key.endswith(end)), None)
    return f" [{unit}]" if unit else ""


def _default(key: str, rule: Schema, required: list[str]) -> str:
    if key in required:
        return "required"
    value = rule.get("default")
    if value is None or value in ({}, []):
        return ""
    if isinstance(value, dict):
        return "see its keys"
    text = json.dumps(value, ensure_ascii=False)
    return (
        f"`{text}`" if len(text) <= LONGEST_DEFAULT else f"{len(value)} values, `{text[:30].rpartition(',')[0]}, ...`"
    )


def _cell(text: str) -> str:
    """Text for a cell of a table: without line ends, bars and HTML."""
    return _one_line(text).replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")


def _one_line(text: str) -> str:
    return " ".join(text.split()).replace("``", "`")
