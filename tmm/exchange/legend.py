"""Legends: which number of an exported raster is which material, as JSON beside it."""

from __future__ import annotations

from typing import Any

from skyshine.tmm.exchange.image import MaterialImage


def legend(image: MaterialImage, start: int = 1) -> dict[int, dict[str, Any]]:
    """Code and name of each material by its number, counted from `start` in the order of the codes."""
    return {k: {"code": code, "name": name} for k, (code, name) in enumerate(image.materials.items(), start)}
