"""Starter files of a user: copied beside the JSON Schemas by which editors complete and check them."""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping
from pathlib import Path

from skyshine import schemas
from skyshine.schemas.errors import InputError

# The schema of a YAML file by a key of its root; the first that it has counts, for a job of mat may have textures too.
SCHEMA_OF_KEY = {
    "skyshine_frame": "mat-frame.schema.json",
    "skyshine_scene": "mat-scene.schema.json",
    "states": "mat-job.schema.json",
    "bands": "mat-job.schema.json",
    "textures": "tmm-job.schema.json",
    "skyshine": "mat-job.schema.json",
}


def schema_name(text: str) -> str | None:
    """Name of the schema of a YAML file, by its keys; None for tables and pages.

    Examples
    --------
    >>> schema_name("skyshine: 1")
    'mat-job.schema.json'
    """
    return next((name for key, name in SCHEMA_OF_KEY.items() if re.search(rf"^{key}:", text, re.MULTILINE)), None)


def write_starter(folder: Path, files: Mapping[str, Path], advice: str) -> None:
    """Copy files into a folder; YAML begins with the line by which editors find its schema, which is copied too.

    Parameters
    ----------
    folder : Path
        Made where there is none.
    files : mapping of str to Path
        What is copied, by its name in the folder.
    advice : str
        What to do where a file is there already.

    Raises
    ------
    InputError
        A file is there already, and nothing is written; or the folder cannot be written.
    """
    texts = {name: file.read_text(encoding="utf-8") for name, file in files.items() if file.suffix == ".yaml"}
    named = {name: schema for name, text in texts.items() if (schema := schema_name(text))}
    everything = {**files, **{schema: schemas.path(schema) for schema in named.values()}}
    for name in everything:
        if (folder / name).exists():
            raise InputError(f"exists already; {advice}", file=folder / name)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, file in everything.items():
            if name in named:
                line = f"# yaml-language-server: $schema={named[name]}\n"
                (folder / name).write_text(line + texts[name], encoding="utf-8", newline="\n")
            elif file.suffix == ".md":  # its pictures are those that the build will draw
                text = file.read_text(encoding="utf-8").replace("](../pictures/", "](built/pictures/")
                (folder / name).write_text(text, encoding="utf-8", newline="\n")
            else:
                shutil.copyfile(file, folder / name)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}; name another folder", file=folder) from None
