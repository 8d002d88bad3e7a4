"""The jobs that `mat init` copies: the starter with its photograph, and one a kind of scene."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from skyshine.schemas.errors import InputError, nearest

STARTER = "starter"
PHOTOGRAPH = "textures/yellowstone_road.png"


def _root() -> Path:
    return Path(str(resources.files("skyshine.examples")))


def example_names() -> list[str]:
    """Names of the packaged jobs, the starter first."""
    names = sorted(path.parent.name for path in _root().glob("*/job.yaml"))
    return [STARTER, *(name for name in names if name != STARTER)]


def starter_files(name: str = STARTER) -> list[Path]:
    """The files of a packaged job, `job.yaml` first: its YAML, its tables and description, its photograph, where it has
    one.

    Raises
    ------
    InputError
        There is no job of this name.
    """
    if name not in example_names():
        raise InputError(f"found the example '{name}'; {nearest(name, example_names())}")
    files = [path for path in (_root() / name).iterdir() if path.suffix in (".yaml", ".md", ".csv", ".glb", ".py")]
    files.sort(key=lambda path: (path.name != "job.yaml", path.name))
    return [*files, _root() / PHOTOGRAPH] if name == STARTER else files


def example(name: str = STARTER) -> Path:
    """Path of a packaged job, for trying a function on it; `mat init` copies one to work with.

    Raises
    ------
    InputError
        There is no job of this name.

    Examples
    --------
    >>> import skyshine.mat
    >>> skyshine.mat.example("ship").name
    'job.yaml'
    """
    return starter_files(name)[0]
