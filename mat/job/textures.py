"""Textures of a job: images to classify, and finished databases whose materials are read."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import pydantic
from pydantic import Field

from skyshine.schemas.documents import StrictModel
from skyshine.schemas.paths import job_path
from skyshine.tmm.job.model import TextureJob


def _finished(value: object, info: pydantic.ValidationInfo) -> Path:
    if isinstance(value, Path):
        return value
    if not isinstance(value, str) or not value:
        raise ValueError(f"found {value!r}; allowed: the path of a .tmm.h5 file, relative to the job")
    path = job_path((info.context or {}).get("folder", "."), value)
    if not path.is_file():
        raise ValueError(f"found '{value}', which is no file at {path}; allowed: a path relative to the job; fix it")
    return path


class FinishedTexture(StrictModel):
    """A texture that is classified already."""

    database: Annotated[
        pydantic.InstanceOf[Path],
        pydantic.BeforeValidator(_finished),
        pydantic.PlainSerializer(str, return_type=str),
        pydantic.WithJsonSchema({"type": "string", "minLength": 1}),
    ] = Field(
        description="Path of the .tmm.h5 file, relative to the job file; the build reads which materials it uses."
    )


JobTexture = Annotated[
    Annotated[TextureJob, pydantic.Tag("image")] | Annotated[FinishedTexture, pydantic.Tag("database")],
    pydantic.Discriminator(
        lambda value: (
            "database"
            if isinstance(value, FinishedTexture) or (isinstance(value, dict) and "database" in value)
            else "image"
        )
    ),
]
