"""File formats and their schemas, readers of YAML, CSV and HDF5, and error messages."""

from pathlib import Path


def path(name: str) -> Path:
    """Path of a schema that comes with the package, such as ``mat-job.schema.json``."""
    return Path(__file__).parent / name
