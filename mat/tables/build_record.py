"""Reader of ``build.json``: the cost of each file of a folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

NAME = "build.json"


def cost_of(path: Path) -> dict[str, Any] | None:
    """Cost of a database from the record beside it; None where the record has no such file."""
    try:
        entry = json.loads((path.parent / NAME).read_text(encoding="utf-8"))["files"][path.name]
        return entry if isinstance(entry["stages"], dict) and entry["stages"] else None
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
