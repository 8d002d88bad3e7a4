"""The texture material mapper: photographs in, material codes with their confidence out.

`load_job` reads a job file, `check` says what it will do with a texture, `map_textures` writes the databases of all its
textures, an outcome for each; `map_texture` and `write_texture` do so for one `TextureJob`. `open_tmm` reads a
database, `read_usage` its shares of materials; `score`, `preview`, `export` and `import_texture` are those of the
commands. Trained classifiers come from `train_library`.

Examples
--------
>>> import skyshine.tmm
>>> job = skyshine.tmm.TextureJob(image="road.png", material="asphalt_road")
>>> job.name, job.way, job.materials
('road', 'material', ('asphalt_road',))
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from skyshine.tmm.database.reader import TmmFile, open_tmm
    from skyshine.tmm.database.usage import read_usage
    from skyshine.tmm.exchange.export import export
    from skyshine.tmm.exchange.imported import import_texture
    from skyshine.tmm.job.load import load_job
    from skyshine.tmm.job.model import TextureJob, TmmJob
    from skyshine.tmm.mapping.run import check
    from skyshine.tmm.mapping.run import classify as map_textures
    from skyshine.tmm.mapping.texture_map import TextureMap, map_texture
    from skyshine.tmm.mapping.write import write_texture
    from skyshine.tmm.report.preview import draw as preview
    from skyshine.tmm.report.score import score
    from skyshine.tmm.training.library import train_library

_HOMES = {
    "TextureJob": ("job.model", "TextureJob"),
    "TextureMap": ("mapping.texture_map", "TextureMap"),
    "TmmFile": ("database.reader", "TmmFile"),
    "TmmJob": ("job.model", "TmmJob"),
    "check": ("mapping.run", "check"),
    "export": ("exchange.export", "export"),
    "import_texture": ("exchange.imported", "import_texture"),
    "load_job": ("job.load", "load_job"),
    "map_texture": ("mapping.texture_map", "map_texture"),
    "map_textures": ("mapping.run", "classify"),
    "open_tmm": ("database.reader", "open_tmm"),
    "preview": ("report.preview", "draw"),
    "read_usage": ("database.usage", "read_usage"),
    "score": ("report.score", "score"),
    "train_library": ("training.library", "train_library"),
    "write_texture": ("mapping.write", "write_texture"),
}

__all__ = [
    "TextureJob",
    "TextureMap",
    "TmmFile",
    "TmmJob",
    "check",
    "export",
    "import_texture",
    "load_job",
    "map_texture",
    "map_textures",
    "open_tmm",
    "preview",
    "read_usage",
    "score",
    "train_library",
    "write_texture",
]


def __getattr__(name: str) -> Any:
    # Imported when asked for, so that `tmm --help` does not wait for image and HDF5 libraries.
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, attribute = _HOMES[name]
    return getattr(importlib.import_module(f"{__name__}.{module}"), attribute)


def __dir__() -> list[str]:
    return __all__
