"""Packaged data of the atmosphere: profiles, aerosol, cloud, Sun and Moon, continua, gas absorption, presets."""

from importlib.resources import files
from pathlib import Path


def path(name: str) -> Path:
    """Path of a packaged data file or folder, e.g. ``path("profiles/tropical.csv")``."""
    return Path(str(files(__name__).joinpath(name)))
