"""Scene materials: thermal stacks, reflectance spectra and specular lobes, each value with its source."""

from importlib import resources
from pathlib import Path


def path(name: str = "") -> Path:
    """Path of a packaged material file, such as ``path("mat.yaml")`` or ``path("ref/concrete.csv")``."""
    return Path(str(resources.files(__name__))) / name
