"""Reader of ``build.json``: the cost of each file of a folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

NAME = "build.json"


def costs_in(folder: Path) -> dict[str, dict[str, Any]]:
    """Costs by file of the record in a folder, of files of which it knows the stages; none without a record."""
    try:
        files = json.loads((folder / NAME).read_text(encoding="utf-8"))["files"]
        return {name: entry for name, entry in files.items() if isinstance(entry["stages"], dict) and entry["stages"]}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return {}


def cost_of(path: Path) -> dict[str, Any] | None:
    """Cost of a database from the record beside it, or above the folder of its site; None where none has it."""
    path = path.absolute()
    return costs_in(path.parent).get(path.name) or costs_in(path.parent.parent).get(f"{path.parent.name}/{path.name}")
