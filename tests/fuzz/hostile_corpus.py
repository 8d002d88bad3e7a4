"""Bad and unusual database files, each with a name and with what a loader must do with it.

Usage: python tests/fuzz/hostile_corpus.py FOLDER

writes them all, in folders named by what a loader must do: ``refuse``; ``equal``, read as the original; ``either``, for
faults in parts that a runtime need not read, one of the two; ``unjudged``, anything, where HDF5 itself reads beyond its
memory (up to 2.0.0; mended by pull request 6184 of HDFGroup/hdf5). Every case is a function of a good file, so that the
corpus is the same each time.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import hostile_axes
import hostile_channels
import hostile_harmless
import hostile_headers
import hostile_parts
import hostile_storage
import hostile_textures
import hostile_wavelengths
from good_databases import write_all
from hostile_cases import REFUSE, Case, edited

SUBJECTS = (
    *(hostile_headers, hostile_axes, hostile_storage, hostile_harmless),
    *(hostile_textures, hostile_channels, hostile_wavelengths),
)


def cases() -> list[Case]:
    """The whole corpus; names are unique."""
    optional = [edited("surface", name, REFUSE, edit) for name, edit in hostile_parts.refused()]
    return [case for subject in SUBJECTS for case in subject.cases()] + optional


def main(folder: Path) -> None:
    good_folder = folder / "good"
    good_folder.mkdir(parents=True)
    good = write_all(good_folder)
    for case in cases():
        target = folder / case.verdict
        target.mkdir(exist_ok=True)
        case.write(good, target)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
