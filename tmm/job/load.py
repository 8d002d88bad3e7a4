"""Reading a job file of `tmm`."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.documents import Document, parse_model, read_yaml
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import open_database
from skyshine.tmm.job.model import PACKAGED, TmmJob


def load_job(path: str | os.PathLike[str], library: MaterialLibrary) -> tuple[TmmJob, Path]:
    """A job and the folder to which its paths are relative.

    Raises
    ------
    InputError
        At the line and column of what is wrong, unknown material names, paths out of the folder and image encoders
        that a model was not trained with included.
    """
    path = Path(path)
    document = read_yaml(path)
    job = parse_model(document, TmmJob, {"materials": library.names, "folder": path.parent})
    _check_encoders(document, path.parent)
    return job, path.parent


def encoder_problem(wanted: str | None, features: str | None, folder: Path) -> str | None:
    """What is wrong with the file of an image encoder beside a model; None where nothing is.

    Parameters
    ----------
    wanted : str or None
        SHA-256 of the encoder that the model was trained with; None where it was trained without.
    features : str or None
        The file that the job names.
    """
    if wanted is None:
        return None if features is None else "the model takes no image encoder; leave classifier.features out"
    if features is None:
        return (
            "the model takes features of an image encoder; name the ONNX file that it was trained with (SHA-256 "
            f"{wanted[:12]}...) in classifier.features"
        )
    try:
        with open(folder / features, "rb") as file:
            found = hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return f"'{features}' is no file that can be read; name the ONNX file that the model was trained with"
    if found == wanted:
        return None
    return (
        f"'{features}' has the SHA-256 {found[:12]}...; allowed: the ONNX file that the model was trained with, "
        f"{wanted[:12]}..."
    )


def _check_encoders(document: Document, folder: Path) -> None:
    """Compare encoders with those that models which stand alone were trained with, here, where lines are known."""
    for number, entry in enumerate(document.data["textures"]):
        model, features = entry.get("model"), (entry.get("classifier") or {}).get("features")
        if model is None or entry.get("seeds") is not None:
            continue
        wanted = None
        if model != PACKAGED:  # which takes no encoder
            try:
                with open_database(folder / model) as file:
                    wanted = str(file["tokens"].attrs["encoder_sha256"]) if "tokens" in file else None
            except (InputError, KeyError):
                continue  # what is wrong with the model is said where it is read
        if problem := encoder_problem(wanted, features, folder):
            key = ("model",) if features is None else ("classifier", "features")
            raise document.error(("textures", number, *key), problem)
