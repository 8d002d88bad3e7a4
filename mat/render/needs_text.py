"""The needs of a scene as YAML, alone or in a copy of a job."""

from __future__ import annotations

import json
import re
from typing import Any

from skyshine.mat.render.query_limits import SceneNeeds

_TOP_KEY = re.compile(r"^[^\s#]")


def needs_text(scene_name: str, needs: SceneNeeds) -> str:
    """The key `needs` of a job, a reason beside each of its keys."""
    lines = [f"needs:  # of the scene {scene_name}, by mat check --scene"]
    for limit in needs.limits:
        lines += [f"  # {limit.reason}", f"  {limit.key}: {_value(limit.value)}"]
    lines += [f"  # {note}" for note in needs.notes]
    if needs.replaced:
        lines += [
            f"  # {len(needs.replaced)} materials with {needs.replaced_share:.2%} of the pixels are omitted;"
            " write into the scene, under surface:",
            f"  #   replaced_materials: {_value(needs.replaced)}",
        ]
    return "\n".join(lines) + "\n"


def with_needs(job_text: str, needs: str) -> str:
    """The text of a job with other needs; all else stays as it is written."""
    lines, inside = [], False
    for line in job_text.splitlines():
        if _TOP_KEY.match(line):
            inside = re.match(r"needs\s*:", line) is not None
        if not inside or line.startswith("#"):
            lines.append(line)
    return "\n".join(lines).rstrip() + "\n\n" + needs


def _value(value: Any) -> str:
    """Value in one line of YAML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {entry}" for key, entry in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, float):
        return f"{value:.12g}"
    # Times of the day would be numbers to base 60 in YAML 1.1.
    return json.dumps(value) if ":" in str(value) else str(value)
