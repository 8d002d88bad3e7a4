"""The Base Material Table of a CDB, ``Metadata/Materials.xml``, which lists the base materials that composites name.

A CDB that is written to and has none gets one; one that is there is kept, and must have what is written. Reading raster
materials needs no such table: the map of base materials to ours names them.
Schema: http://schemas.opengis.net/cdb/1.0/Base_Material_Table.xsd (OGC CDB 1.x, volume 1, clause 2.5.1).
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from skyshine.schemas.errors import InputError, nearest
from skyshine.tmm.exchange.cdb_table import Composite, parse_xml, read_xml
from skyshine.tmm.exchange.files import write_bytes

NAMESPACE = "http://www.opengis.net/cdb/1.0/Base_Material_Table"
SCHEMA = "http://schemas.opengis.net/cdb/1.0/Base_Material_Table.xsd"


def base_table(root: Path) -> Path:
    """Path of the table in the CDB at `root`."""
    return root / "Metadata" / "Materials.xml"


def bases_of(composites: Iterable[Composite]) -> set[str]:
    """The base materials that composite materials name."""
    layers = (
        layer
        for composite in composites
        for layer in (composite.surface, composite.primary, *composite.secondary)
        if layer
    )
    return {name for layer in layers for name, _ in layer.materials}


def require_bases(root: Path, composites: Iterable[Composite]) -> None:
    """Refuse composite materials of base materials that the table of the CDB at `root` lacks; it may have no table.

    Raises InputError.
    """
    path = base_table(root)
    if not path.exists():
        return
    listed = read_bases(path)
    for name in sorted(bases_of(composites) - listed):
        raise InputError(
            f"lacks the base material '{name}', which would be written; {nearest(name, sorted(listed))}; add it to this"
            " table, or name a map to others with --map",
            file=path,
        )


def add_bases(root: Path, names: Iterable[str]) -> list[Path]:
    """Write the table of a CDB that has none.

    Returns the file; none where there was one.
    """
    path = base_table(root)
    if path.exists():
        return []
    write_bases(path, names)
    return [path]


def read_bases(path: str | os.PathLike[str]) -> set[str]:
    """The base materials of a table, in any namespace or none.

    Raises InputError: the file cannot be read, is not XML, or has no base material.
    """
    root = parse_xml(read_xml(path), Path(path))
    bases = {"".join((element.findtext("{*}Name") or "").split()) for element in root.iter("{*}Base_Material")}
    if not bases - {""}:
        raise InputError(
            "contains no Base_Material; name a Base Material Table, or remove it to have one made", file=path
        )
    return bases - {""}


def write_bases(path: str | os.PathLike[str], names: Iterable[str], version: str = "1.0") -> None:
    """Write a table that the schema accepts: each name once, ascending, without descriptions.

    Raises InputError: the file cannot be written.
    """
    from lxml import etree

    root = etree.Element(f"{{{NAMESPACE}}}Base_Material_Table", nsmap={None: NAMESPACE})  # type: ignore[dict-item]  # lxml names the default namespace None
    root.set("version", version)
    root.set("{http://www.w3.org/2001/XMLSchema-instance}schemaLocation", f"{NAMESPACE} {SCHEMA}")
    for name in sorted(set(names)):
        element = etree.SubElement(etree.SubElement(root, f"{{{NAMESPACE}}}Base_Material"), f"{{{NAMESPACE}}}Name")
        element.text = name
    write_bytes(path, etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True))
