"""The starter job: files that `mat init` copies."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

FILES = ("starter/job.yaml", "starter/README.md", "textures/yellowstone_road.png")


def starter_files() -> list[Path]:
    """The packaged starter job, its description and its photograph."""
    root = Path(str(resources.files("skyshine.examples")))
    return [root / name for name in FILES]
