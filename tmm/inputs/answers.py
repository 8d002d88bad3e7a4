"""Lists of numbered places of a texture with the material of each, as ``tmm suggest`` writes them to be filled in."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Protocol

import numpy as np
import pydantic
from pydantic import Field

from skyshine.materials.library import unknown_material
from skyshine.schemas.documents import StrictModel, parse_model, read_yaml
from skyshine.tmm.job.materials import UNKNOWN

SKIP = "skip"  # the answer that a place cannot be recognised: it is not asked about again
CORNERS = 32  # corners of the polygon that represents a disk


class Sized(Protocol):
    """A texture, or the database of one."""

    @property
    def height(self) -> int:
        """Rows of texels."""

    @property
    def width(self) -> int:
        """Columns of texels."""


def _known_answer(name: str, info: pydantic.ValidationInfo) -> str:
    materials = (info.context or {}).get("materials")
    if materials is not None and name not in (SKIP, UNKNOWN) and name not in materials:
        raise ValueError(unknown_material(name, [SKIP, UNKNOWN, *materials]))
    return name


class Answer(StrictModel):
    """A place and what is there."""

    number: int = Field(ge=1, description="Number of the patch on the contact sheet; each once.")
    x: int = Field(ge=0, description="Column of the texel in the middle.")
    y: int = Field(ge=0, description="Row of the texel in the middle, downwards.")
    radius: int = Field(default=0, ge=0, le=4096, description="Radius of the disk of that material, in texels.")
    material: Annotated[str, pydantic.AfterValidator(_known_answer)] | None = Field(
        default=None,
        description="Material of the disk; null: not answered yet; unknown: none of the library's; skip: cannot be "
        "recognised, no seed.",
    )

    @property
    def seed(self) -> str | None:
        """The material that is known by this answer, or `unknown`; None where it cannot be known."""
        return None if self.material == SKIP else self.material


class AnswerList(StrictModel):
    """A list that is filled in."""

    answers: tuple[Answer, ...] = Field(description="Answers in any order.")


def read_answers(path: Path, texture: Sized | None = None, materials: tuple[str, ...] | None = None) -> list[Answer]:
    """The answers of a list, those that are not filled in included.

    Raises InputError: at the line and column of what is wrong.

    path : Path
    texture : Sized, optional; within which all places must lie.
    materials : tuple of str, optional; names that are allowed; by default all.
    """
    document = read_yaml(path)
    answers = parse_model(document, AnswerList, {"materials": materials}).answers
    limits = {} if texture is None else {"x": texture.width, "y": texture.height}
    positions: dict[int, int] = {}
    for i, answer in enumerate(answers):
        if answer.number in positions:
            line = document.where(("answers", positions[answer.number], "number"))[0]
            raise document.error(
                ("answers", i, "number"),
                f"found the number {answer.number} twice; allowed: each once; see line {line}",
            )
        positions[answer.number] = i
        for key, limit in limits.items():
            if getattr(answer, key) >= limit:
                raise document.error(
                    ("answers", i, key),
                    f"found {key} {getattr(answer, key)}; allowed: 0 to {limit - 1}, the image has {limits['x']} x "
                    f"{limits['y']} texels; is the list that of another image?",
                )
    return list(answers)


def disk(answer: Answer, width: int, height: int) -> tuple[tuple[float, float], ...]:
    """The polygon of an answer's disk, within the image; of radius 0 its texel alone."""
    middle = (answer.x + 0.5, answer.y + 0.5)
    if answer.radius == 0:
        return (middle,)
    # A little more than the radius, so that its flat sides do not leave out the last texels of the disk.
    turn = 2 * np.pi * np.arange(CORNERS) / CORNERS
    corners = middle + (answer.radius + 0.1) * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    corners = np.clip(corners, 0, (width, height))
    return tuple((float(x), float(y)) for x, y in corners)


def to_text(answers: list[Answer], gains: dict[int, float], texture: str) -> str:
    """The YAML text of a list.

    gains : dict of int to float; expected gain by number, of those that are asked now.
    texture : str; its name.
    """
    lines = [
        f"# Materials of the numbered patches of {texture}: replace null by a name of the material library, 'unknown'",
        "# (none of its materials) or 'skip' (cannot be recognised). What stays null is skipped.",
        "answers:",
    ]
    for answer in answers:
        material = answer.material or "null"
        remark = f"  # expected gain {100 * gains[answer.number]:.2f} %" if answer.number in gains else ""
        lines.append(
            f"  - {{number: {answer.number}, x: {answer.x}, y: {answer.y}, radius: {answer.radius}, "
            f"material: {material}}}{remark}"
        )
    return "\n".join(lines) + "\n"
