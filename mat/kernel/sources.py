"""The digest by which a library is known to be compiled from the sources beside it; the build reads this module too."""

from __future__ import annotations

import hashlib
from pathlib import Path


def sources_digest(folder: Path) -> str | None:
    """Digest of the C sources of a folder and of the program that compiles them.

    Parameters
    ----------
    folder : Path
        The folder `mat/kernel`, of a checkout or as installed.

    Returns
    -------
    str or None
        64 hexadecimal digits; None where the sources are not, as in an installed wheel.
    """
    files = sorted(file for file in folder.iterdir() if file.suffix in (".c", ".h") or file.name == "backend.py")
    if not files:
        return None
    digest = hashlib.sha256()
    for file in files:
        content = file.read_bytes()
        digest.update(f"{file.name} {len(content)}\n".encode() + content)
    return digest.hexdigest()
