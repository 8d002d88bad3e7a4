"""What every file and every command output of the project looks like: documents, HDF5 layouts, messages."""

from pathlib import Path


def path(name: str) -> Path:
    """Path of a schema that comes with the package, such as ``mat-job.schema.json``."""
    return Path(__file__).parent / name
