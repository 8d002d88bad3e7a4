"""Writes the JSON Schemas of the YAML files, from the models that read them, so that editors complete them, and
a page of the keys of each in the folder ``keys`` beside them.

Run ``python -m mat.maintain.job_schema FOLDER`` after changing a model; FOLDER is ``schemas`` of the checkout.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pydantic

from mat.maintain.manual import keys
from skyshine.mat.job.model import Job
from skyshine.mat.render.frame_file import FrameModel
from skyshine.mat.render.scene_file import SceneModel
from skyshine.materials.files import SpecularFile, ThermalFile
from skyshine.materials.library import Index
from skyshine.tmm.job.model import TmmJob

MODELS: dict[str, type[pydantic.BaseModel]] = {
    "mat-job.schema.json": Job,
    "mat-frame.schema.json": FrameModel,
    "mat-scene.schema.json": SceneModel,
    "tmm-job.schema.json": TmmJob,
    "material-index.schema.json": Index,
    "material-ht.schema.json": ThermalFile,
    "material-spec.schema.json": SpecularFile,
}


def schema_text(name: str) -> str:
    """Text of one of the schemas, as in its file."""
    schema = MODELS[name].model_json_schema(mode="validation")
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "$comment": "Generated from the models."}
    return json.dumps(head | schema, indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    (folder / "keys").mkdir(exist_ok=True)
    for file_name in MODELS:
        (folder / file_name).write_text(schema_text(file_name), encoding="utf-8")
        (folder / "keys" / keys.file_name(file_name)).write_text(keys.page(file_name), encoding="utf-8")
