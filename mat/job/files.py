"""Files that a job names: read with the job, so that whatever is built from it knows their content."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Annotated

import pydantic

from skyshine.schemas.csv_table import read_text
from skyshine.schemas.paths import job_path


@dataclass(frozen=True)
class TextFile:
    """A file named in a job.

    Attributes
    ----------
    name : str
        Name of the file as the job states it.
    """

    name: str
    path: str
    text: str

    @property
    def sha256(self) -> str:
        return hashlib.sha256(self.text.encode()).hexdigest()


def _read(value: object, info: pydantic.ValidationInfo) -> TextFile:
    if isinstance(value, TextFile):
        return value
    if not isinstance(value, str) or not value:
        raise ValueError(f"found {value!r}; allowed: the path of a file, relative to the job")
    path = job_path((info.context or {}).get("folder", "."), value)
    if not path.is_file():
        raise ValueError(f"found '{value}', which is no file at {path}; allowed: a path relative to the job; fix it")
    return TextFile(value, str(path), read_text(path))


JobFile = Annotated[
    pydantic.InstanceOf[TextFile],
    pydantic.BeforeValidator(_read),
    # Name and content: a table is kept only as long as the file that it was built from says the same.
    pydantic.PlainSerializer(lambda file: {"file": file.name, "sha256": file.sha256}, return_type=dict),
    pydantic.WithJsonSchema({"type": "string", "minLength": 1}),
]
