"""The images that one entry of a job names: a file, a folder, a pattern, or the tiles of a UDIM set."""

from __future__ import annotations

import re
from pathlib import Path, PurePath

from skyshine.schemas.paths import job_path

UDIM = "<UDIM>"  # represents the four digits of a tile, 1001 and up, as in MaterialX and USD
_TILE = "[1-9][0-9][0-9][0-9]"
_ENDINGS = [".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr", ".tga", ".bmp", ".dds", ".hdr", ".jp2", ".webp", ".pgm"]
_ENDINGS += [".ppm", ".gif"]


def texture_name(image: str) -> str:
    """The name that a texture has by default: its image's without ending, other characters replaced."""
    return _plain(PurePath(image).stem)


def _plain(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9_.-]", "_", text).lstrip(".-")


def find_images(folder: Path, image: str) -> dict[str, str] | None:
    """Images by the names of their textures, in the order of their paths; None where `image` is a file's name.

    Raises ValueError: there is no such image, or one lies outside the job's folder.

    folder : Path; of the job.
    image : str
        A folder (its images, not those of folders in it), a pattern with ``*``, ``?`` and ``[...]`` (``**`` for any
        folders), or a name with ``<UDIM>``. A file of exactly this name comes first.
    """
    try:
        matches = _matches(folder, image)
    except OSError as error:
        raise ValueError(f"found '{image[:60]}', which cannot be looked at: {error.strerror}; check the path") from None
    if matches is None:
        return None
    images = sorted(_as_written(path, folder, image) for path in matches)
    if not images:
        raise ValueError(f"found no image for '{image}'; name a file, a folder of images, or a pattern that some match")
    for name in images:
        job_path(folder, name)
    names = [texture_name(name) for name in images]
    if len(set(names)) < len(names):
        # Folders that each contain an image of the same name.
        names = [_plain(str(PurePath(name).with_suffix("")).replace("/", "_")) for name in images]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"found two images for '{image}' that would both be named '{twice}'; list them with a 'name'")
    return dict(zip(names, images, strict=True))


def _matches(folder: Path, image: str) -> list[Path] | None:
    """The files that are meant, none of them hidden; None where `image` is a file's name."""
    target = job_path(folder, image)
    if target.is_dir():
        matches = [path for path in target.iterdir() if path.suffix.lower() in _ENDINGS]
    elif not target.exists() and re.search(r"[*?\[]|" + UDIM, image):
        pattern, start = PurePath(image.replace(UDIM, _TILE)), folder
        if pattern.anchor:
            start, pattern = Path(pattern.anchor), pattern.relative_to(pattern.anchor)
        matches = list(start.glob(str(pattern)))
    else:
        return None
    return [path for path in matches if path.is_file() and not path.name.startswith(".")]


def _as_written(path: Path, folder: Path, image: str) -> str:
    """The path of an image as a job would write it."""
    return path.as_posix() if PurePath(image).is_absolute() else path.relative_to(folder).as_posix()
