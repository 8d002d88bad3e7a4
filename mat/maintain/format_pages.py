"""Writes the pages that describe the file formats, from the layout schemas that `mat verify` checks files by.

Run ``python -m mat.maintain.format_pages FOLDER [FILE.h5 ...]`` after changing a layout; FOLDER is ``schemas``
of the checkout. With files, what each field is (its ``long_name``) and how axes are read is first taken from them into
the layouts.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from skyshine.schemas.format_versions import FORMAT_MAJOR
from skyshine.schemas.hdf5 import Group, read_file

Layout = dict[str, Any]  # a layout schema, or a part of one

TYPES = {
    "f4": "float32",
    "f8": "float64",
    "i1": "int8",
    "i2": "int16",
    "i4": "int32",
    "i8": "int64",
    "u1": "uint8",
    "u2": "uint16",
    "u4": "uint32",
    "u8": "uint64",
    "text": "UTF-8 text of variable length",
}
INTRODUCTION = """\
An HDF5 file that netCDF-4 and xarray open without conversion. Arrays are little-endian, in row-major order of the axes named below,
compressed with the filters shuffle and deflate and protected by Fletcher-32; small ones lie in their headers, under the headers' checksums. Every axis is a dimension scale of its group, with the
attributes `units`, `long_name` and, where a runtime interpolates on it, `interpolation` (`linear`, `linear_periodic`,
`linear_folded`, `exact`), `period` and `out_of_range` (`error` or `clamp`); `examples/runtimes/README.md` defines the rules. In a
group that has the array `material_name`, the arrays on a material axis name it in their attribute `coordinates`. An array whose attribute `differences`
names axes has, along each of these, its first value and then the difference of each value from the one before it: cumulative sums in single precision, along
one axis after the other, are its values. A reader of
format {major} reads every version {major}.x and refuses other major versions.
"""  # noqa: E501
ATTRIBUTES = {
    "Conventions": "version of the netCDF Climate and Forecast metadata conventions",
    "filetype": "this format",
    "format_version": "version of the layout: a new major version breaks readers, a new minor version adds fields",
    "data_version": "version of the data that the file was computed from",
    "generator": "program and version",
    "job": "the part of the job that the file depends on, as YAML",
    "content_sha256": "SHA-256 over groups, axes, arrays and all attributes but this one; an array"
    " enters with a digest of its own (`schemas/hdf5_digest.py`, `schemas/array_digest.py`)",
    "state": "name of the state; by default its preset or profile, `sounding` where it is made from one",
    "made_from": "preset or profile of a state that the job names, `sounding` where it is made from one",
    "sounding": "name of the file of the sounding",
    "aerosol_optical_depth_550": "1, of the state's aerosol from the ground to space, where the job writes it",
    "angstrom_exponent": "1, of the extinction of the state's aerosol, where the job writes it",
    "aerosol_table": "name of the file of the aerosol's optical properties",
    "sea_temperature": "K, of the sea below the paths, whose surface layer the lowest air is; absent for none",
    "night_sky": "airglow over its mean, with starlight, in the ambient light; absent for none",
    "aerosol_layers": "further layers of aerosol: particles, place and optical depth at 0.55 um of each",
    "air": "what the air near the ground follows: weather (the day's mean, or a time), profile or sounding",
    "band": "name of the band in the job, or b01, b02 ... by its order",
    "date": "day of the state, for which the source's distance and the Moon's phase are taken",
    "source": "`sun` or `moon`",
    "ground_emissivity": "of the ground around a face",
    "ground_temperature": "K, of the ground where `ground_material` is not read",
    "ground_radiance": "W m^-2 sr^-1, emitted by the ground at `ground_temperature`",
    "ground": "annual wave at the surface of the ground, by which deep temperatures follow the season, where they do",
    "ground_material": "name of the ground's material in the `.htt` file, where the job names one",
    "ground_below_paths": "what reflects below the paths, where it is a material's spectrum; what is not modelled",
    "ground_albedo": "of the ground, for sunlight",
    "ends_at_ground": "`true` where the line of sight ends at the ground, else `false`",
    "absorption": "the band model, or line by line with the gases whose lines were summed",
    "layout": "`channels`: see below",
    "ground_altitude_km": "altitude of the ground",
    "scale_height_km": "H below",
    "range_km": "least and largest range that the file is for; of a spectrum its range, `inf` to space",
    "altitude_km": "least and largest altitude of observers that the file is for",
    "horizon_azimuth": "degree from north eastward, nodes of the horizon; only between walls, as those below",
    "horizon_elevation": "degree, up to which walls reach at these azimuths",
    "sky_view": "open share of the sky above the horizon",
    "level_sky_view": "view factor of the open sky from a level surface",
    "wall_material": "name of the walls' material, whose temperature they have",
    "wall_temperature": "K, of the walls: one, or 24 at the hours 0 to 23",
    "wall_emissivity": "of the walls, for longwave",
    "wall_albedo": "of the walls, for sunlight",
}


def page(layout: Layout, name: str) -> str:
    """Text of the page of one file type.

    Parameters
    ----------
    layout : dict
        The layout schema; its description, of what runtimes compute from the fields, ends the page.
    name : str
        File type and major version, such as ``htt-1``.
    """
    filetype, _, major = name.rpartition("-")
    root = layout["properties"]
    lines = [f"# `.{filetype}` format {major}: {layout['title']}", "", "Generated from the layout schema "]
    lines[-1] += f"`schemas/{name}.layout.json` by `mat/maintain/format_pages.py`."
    lines += [
        "",
        INTRODUCTION.replace("{major}", major),
        "## Root attributes",
        "",
        "| attribute | value | what |",
        "|---|---|---|",
    ]
    lines += [
        f"| `{key}` | {_value(rule)} | {ATTRIBUTES.get(key, '')} |"
        for key, rule in root["attributes"]["properties"].items()
    ]
    for path, content in _groups(root, ""):
        lines += ["", f"## {f'Group `{path}`' if path else 'Root group'}"]
        lines += _axes(content["axes"]) + _arrays(content["variables"])
        if len(lines[-1].split("\n")) == 1 and lines[-1].startswith("## "):
            lines += ["", "Contains groups or attributes only."]
    formulas = ["", layout["description"].rstrip("\n")] if "description" in layout else []
    return "\n".join(lines + formulas) + "\n"


def _groups(content: Layout, path: str) -> Iterator[tuple[str, Layout]]:
    yield path, content
    rules = content["groups"]
    children = rules.get("properties", {}) | {
        f"<{key}>": rule for key, rule in rules.get("patternProperties", {}).items()
    }
    for name, rule in children.items():
        yield from _groups(rule["properties"], f"{path}/{name}".lstrip("/"))


def _axes(content: Layout) -> list[str]:
    axes, required = content.get("properties", {}), content.get("required", [])
    if not axes:
        return []
    lines = ["", "| axis | type | unit | read | what |", "|---|---|---|---|---|"]
    for name, rule in axes.items():
        has = rule["properties"]
        read = _value(has["interpolation"]) if "interpolation" in has else ""
        period = has.get("period", {}).get("const")
        read += f", period {period:g}" if read and period else ""
        what = rule.get("description", "") + ("" if name in required else " (may be absent)")
        lines.append(f"| `{name}` | {_type(has)} | {_value(has['units'])} | {read} | {what.strip()} |")
    return lines


def _arrays(variables: Layout) -> list[str]:
    if not variables.get("properties"):
        return []
    required = variables.get("required", [])
    lines = ["", "| array | type | axes | unit | what |", "|---|---|---|---|---|"]
    for name, rule in variables["properties"].items():
        has = rule["properties"]
        what = rule.get("description", "") + ("" if name in required else " (may be absent)")
        axes = _dims(has["dims"])
        lines.append(f"| `{name}` | {_type(has)} | {axes} | {_value(has['units'])} | {what.strip()} |")
    return lines


def _dims(rule: Layout) -> str:
    """Axes of an array; where it may have others, those too."""
    if "prefixItems" in rule:
        return ", ".join(" or ".join(item["enum"]) for item in rule["prefixItems"])
    lists = rule["enum"] if "enum" in rule else [rule["const"]]
    return ", ".join(" or ".join(dict.fromkeys(names)) for names in zip(*lists, strict=True))


def _type(has: Layout) -> str:
    rule = has["type"]
    return " or ".join(TYPES[kind] for kind in rule.get("enum", [rule.get("const")]))


def _value(rule: Layout) -> str:
    if "const" in rule:
        return f"`{rule['const']}`"
    if "enum" in rule:
        return " or ".join(f"`{value}`" for value in rule["enum"])
    return f"matches `{rule['pattern']}`" if "pattern" in rule else "any"


def describe_fields(layout: Layout, root: Group) -> None:
    """Take into a layout schema what a file says of its fields, and how its axes are read."""
    has = layout.get("properties", layout)
    for kind, items in (("axes", root.axes), ("variables", root.variables)):
        for name, item in items.items():
            rule = has[kind].get("properties", {}).get(name)
            if rule is None:
                continue
            rule.setdefault("description", item.long_name)
            for key in ("interpolation", "period"):
                if key in item.attributes and "enum" not in rule["properties"].get(key, {}):
                    value = item.attributes[key]
                    rule["properties"][key] = {"const": value if isinstance(value, str) else float(value)}
                    rule["required"] += [key] if key not in rule["required"] else []
    for name, child in root.groups.items():
        rules = has["groups"]
        by_pattern = [rule for key, rule in rules.get("patternProperties", {}).items() if re.search(key, name)]
        for rule in [rules["properties"][name]] if name in rules.get("properties", {}) else by_pattern:
            describe_fields(rule, child)


def layout_names(folder: Path) -> list[str]:
    """File types with their major versions, of all layouts in a folder."""
    return sorted(path.name.removesuffix(".layout.json") for path in folder.glob("*.layout.json"))


def main(folder: Path, files: list[str]) -> None:
    layouts = {
        name: json.loads((folder / f"{name}.layout.json").read_text(encoding="utf-8")) for name in layout_names(folder)
    }
    for file in files:
        root, attributes = read_file(file)
        describe_fields(layouts[f"{attributes['filetype']}-{FORMAT_MAJOR}"], root)
    for name, layout in layouts.items():
        if files:
            text = json.dumps(layout, indent=1, ensure_ascii=False) + "\n"
            (folder / f"{name}.layout.json").write_text(text, encoding="utf-8")
        (folder / "formats" / f"{name}.md").write_text(page(layout, name), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
