"""``catalog.json``: every database of a folder with its type, state, band, versions and hash."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from skyshine.schemas.hdf5 import open_database
from skyshine.schemas.whole_files import write_whole

CATALOG_FORMAT = "1.1.0"
# Root attributes by the keys of an entry, in which state and band are numbers.
_NAMES = {
    "state_name": "state",
    "sounding": "sounding",
    "band_name": "band",
    "date": "date",
    "source": "source",
}
_NAME = re.compile(r"^(?:s(?P<state>\d+))?(?:b(?P<band>\d+))?\.")


def write_catalog(folder: Path, names: Sequence[str]) -> Path:
    """Write the catalogue of the databases `names` in `folder`."""
    path = folder / "catalog.json"
    content = {"format_version": CATALOG_FORMAT, "files": [_entry(folder, name) for name in sorted(names)]}
    write_whole(path, json.dumps(content, indent=2) + "\n")
    return path


def _entry(folder: Path, name: str) -> dict[str, Any]:
    match = _NAME.match(name)
    numbers = {key: int(text) for key, text in match.groupdict().items() if text} if match else {}
    with open_database(folder / name) as file:
        read = ("filetype", "format_version", "data_version", "generator", "content_sha256")
        names = {
            f"{key}_name" if key in ("state", "band") else key: str(file.attrs[key])
            for key in _NAMES
            if key in file.attrs
        }
        return {"file": name, **numbers, **names, **{key: str(file.attrs[key]) for key in read}}
