"""Composite Material Tables of OGC CDB: read as they are found in the field, written as the schema demands.

A composite material has an index, a name and substrates of base materials with weights in percent. Indices count within
one table alone: two tiles may give one index to different materials, so materials are known by name.
Schema: http://schemas.opengis.net/cdb/1.0/Composite_Material_Table.xsd (OGC CDB 1.x, volume 1, clause 2.5.2).
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from skyshine.schemas.errors import InputError
from skyshine.tmm.exchange.files import write_bytes

NAMESPACE = "http://www.opengis.net/cdb/1.0/Composite_Material_Table"
SCHEMA = "http://schemas.opengis.net/cdb/1.0/Composite_Material_Table.xsd"
MAX_INDEX = 999_999  # "the largest index" of the standard's own example table
BASE_NAME = re.compile(r"BM_[A-Za-z0-9_-]+")  # Base_Material_Table.xsd, with at most 32 characters
BYTE_LIMIT = 50_000_000  # size of a table: thousands of times one that covers 1024 x 1024 different texels in practice
PERCENT = 100  # weights of a composite material are in per cent


@dataclass(frozen=True)
class Substrate:
    """A layer of base materials.

    materials : tuple of (str, int); base materials with weights in percent, in descending order.
    thickness : str, optional; in metres, as the table writes it.
    """

    materials: tuple[tuple[str, int], ...]
    thickness: str | None = None


@dataclass(frozen=True)
class Composite:
    """A composite material; the substrates in the order from top to bottom."""

    index: int
    name: str
    primary: Substrate
    surface: Substrate | None = None
    secondary: tuple[Substrate, ...] = field(default=())


def read_table(path: str | os.PathLike[str]) -> dict[int, Composite]:
    """Read a table leniently: any namespace or none, weights omitted, indices in any order.

    Raises InputError: the file is missing or is not XML, it contains no composite material, an index occurs twice or is
    no whole number, or a composite has no base material.

    Returns them by index, ascending.
    """
    return parse_table(read_xml(path), Path(path))


def read_xml(path: str | os.PathLike[str]) -> bytes:
    """The text of an XML file of a CDB.

    Raises InputError: it cannot be read, or is larger than such a table is.
    """
    path = Path(path)
    try:
        if path.exists() and not path.is_file():
            raise InputError("is no file that can be read; check the path", file=path)
        if path.stat().st_size > BYTE_LIMIT:
            raise InputError(f"found {path.stat().st_size} bytes; allowed: at most {BYTE_LIMIT}", file=path)
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}; check the path", file=path) from None


def parse_xml(text: bytes, path: Path) -> Any:
    """The root element of the text of an XML file; `path` is in the messages.

    Raises InputError: it is not XML.
    """
    from lxml import etree  # an extra that only CDB needs

    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, remove_comments=True)
    try:
        return etree.fromstring(text, parser)
    except etree.XMLSyntaxError as error:
        line, column = (int(number) for number in error.position)
        raise InputError(f"is not XML: {error.msg}; fix it here", file=path, line=line, column=column) from None


def parse_table(text: bytes, path: Path) -> dict[int, Composite]:
    """Read the text of a table as `read_table` does; `path` is in its messages."""
    root = parse_xml(text, path)
    table: dict[int, Composite] = {}
    for element in root.iter("{*}Composite_Material"):
        composite = _composite(element, path)
        if composite.index in table:
            raise InputError(
                f"index {composite.index} occurs twice; allowed: once in a table", file=path, line=element.sourceline
            )
        table[composite.index] = composite
    if not table:
        raise InputError("contains no Composite_Material; name a Composite Material Table of a CDB", file=path)
    return dict(sorted(table.items()))


def _composite(element: Any, path: Path) -> Composite:
    text = element.get("index", "")
    if not re.fullmatch(r"\s*[0-9]{1,9}\s*", text):
        raise InputError(
            f"index: found '{text[:40]}'; allowed: a whole number, 0 or more", file=path, line=element.sourceline
        )
    index = int(text)
    substrates: dict[str, list[Substrate]] = {
        kind: [] for kind in ("Surface_Substrate", "Primary_Substrate", "Secondary_Substrate")
    }
    for child in element:
        kind = child.tag.rpartition("}")[2] if isinstance(child.tag, str) else ""
        if kind in substrates:
            substrates[kind].append(_substrate(child, path))
    if not substrates["Primary_Substrate"]:
        raise InputError(
            f"composite material {index} has no Primary_Substrate; add one", file=path, line=element.sourceline
        )
    surface, primary, secondary = substrates.values()
    name = " ".join((element.findtext("{*}Name") or "").split())
    return Composite(index, name or f"CM_{index}", primary[0], surface[0] if surface else None, tuple(secondary))


def _substrate(element: Any, path: Path) -> Substrate:
    names: list[str] = []
    stated: list[float | None] = []
    for material in element.iterfind("{*}Material"):
        names.append("".join((material.findtext("{*}Name") or "").split()))
        text = (material.findtext("{*}Weight") or "").strip()
        if text and not re.fullmatch(r"[0-9]{1,3}(\.[0-9]*)?", text):
            raise InputError(
                f"Weight: found '{text[:40]}'; allowed: 1 to 100 percent", file=path, line=material.sourceline
            )
        stated.append(float(text) if text else None)
    if not names or "" in names:
        raise InputError(
            "a substrate names no base material; add Material with a Name", file=path, line=element.sourceline
        )
    weights = [weight for weight in stated if weight is not None]
    if len(weights) < len(names):  # the schema's default of 100 for one material; equal parts where several omit it
        weights = [PERCENT / len(names)] * len(names)
    if not sum(weights):
        raise InputError("the weights of a substrate are all 0; give one", file=path, line=element.sourceline)
    percent = largest_remainders(weights)
    ranked = sorted(zip(names, percent, strict=True), key=lambda item: -item[1])
    thickness = (element.findtext("{*}Thickness") or "").strip()
    return Substrate(tuple(item for item in ranked if item[1] > 0), thickness or None)


def largest_remainders(weights: list[float]) -> list[int]:
    """Whole percents that sum to 100 in proportion to the weights (Hamilton's method)."""
    shares = [weight * PERCENT / sum(weights) for weight in weights]
    integers = [int(share + 1e-9) for share in shares]
    order = sorted(range(len(shares)), key=lambda k: integers[k] - shares[k])
    for k in order[: PERCENT - sum(integers)]:
        integers[k] += 1
    return integers


def write_table(path: str | os.PathLike[str], composites: list[Composite], version: str = "1.0") -> None:
    """Write a table that the schema accepts: indices ascending, weights descending and summing to 100.

    Raises InputError: an index, a base material or a thickness is not what the schema allows, or the file cannot be
    written.
    """
    write_bytes(path, table_text(composites, path, version))


def table_text(composites: list[Composite], path: str | os.PathLike[str], version: str = "1.0") -> bytes:
    """The text of a table that the schema accepts; `path` is in the messages of what is raised."""
    from lxml import etree

    root = etree.Element(f"{{{NAMESPACE}}}Composite_Material_Table", nsmap={None: NAMESPACE})  # type: ignore[dict-item]  # lxml names the default namespace None
    root.set("version", version)
    root.set("{http://www.w3.org/2001/XMLSchema-instance}schemaLocation", f"{NAMESPACE} {SCHEMA}")
    for composite in sorted(composites, key=lambda item: item.index):
        _check(composite, path)
        element = _child(root, "Composite_Material")
        element.set("index", str(composite.index))
        _child(element, "Name", composite.name)
        if composite.surface:
            _write_substrate(element, "Surface_Substrate", composite.surface)
        _write_substrate(element, "Primary_Substrate", composite.primary)
        for substrate in composite.secondary:
            _write_substrate(element, "Secondary_Substrate", substrate)
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def _check(composite: Composite, path: str | os.PathLike[str]) -> None:
    if not 0 <= composite.index <= MAX_INDEX:
        raise InputError(f"found index {composite.index}; allowed: 0 to {MAX_INDEX}", file=path)
    for substrate in (composite.surface, composite.primary, *composite.secondary):
        for name, _ in substrate.materials if substrate else ():
            if not BASE_NAME.fullmatch(name) or len(name) > 32:
                raise InputError(
                    f"found the base material '{name}'; allowed: BM_ and letters, digits, _ or -, 32 at most", file=path
                )
        if substrate and substrate.thickness is not None and not _positive(substrate.thickness):
            raise InputError(f"Thickness: found '{substrate.thickness}'; allowed: metres above 0", file=path)


def _positive(text: str) -> bool:
    return re.fullmatch(r"\+?[0-9]*\.?[0-9]*", text) is not None and any(digit in text for digit in "123456789")


def _write_substrate(parent: Any, tag: str, substrate: Substrate) -> None:
    element = _child(parent, tag)
    for name, weight in substrate.materials:
        material = _child(element, "Material")
        _child(material, "Name", name)
        _child(material, "Weight", str(weight))
    if substrate.thickness is not None:
        _child(element, "Thickness", substrate.thickness)


def _child(parent: Any, tag: str, text: str | None = None) -> Any:
    from lxml import etree

    element = etree.SubElement(parent, f"{{{NAMESPACE}}}{tag}")
    element.text = text
    return element
