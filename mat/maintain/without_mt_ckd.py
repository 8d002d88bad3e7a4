"""Make a source tree without MT_CKD data, from which `pip wheel` builds a package under Apache-2.0 alone.

    python -m mat.maintain.without_mt_ckd CHECKOUT OUT --absorption FILE --broadband FILE

FILE and FILE are a band model and its broadband points with the continua of LOWTRAN7, as `mat lines build --continua
lowtran7` and `python -m mat.maintain.lines broadband` write them. A wheel is built from the tree; its default water
vapour continuum is `lowtran7`.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import click
import h5py

from skyshine.mat.atmosphere.gases.absorption import FILETYPE
from skyshine.mat.atmosphere.spectra import fluxes
from skyshine.mat.spectroscopy.lowtran_continua import LowtranContinua
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import open_database

FOLDERS = ("mat", "tmm", "materials", "atmospheres", "schemas", "examples")
PARTICLES = ("atmospheres/aerosol/phase.h5", "atmospheres/cloud/phase.h5")  # tables in HDF5 without gases
FILES = ("pyproject.toml", "README.md", "LICENSE", "NOTICE", "CITATION.cff", "CHANGELOG.md")
# What of the texts speaks of MT_CKD: file, pattern that occurs once, replacement.
EDITS = (
    ("pyproject.toml", r'"Apache-2\.0 AND LicenseRef-MT-CKD"', '"Apache-2.0"'),
    ("pyproject.toml", r', "LICENSES/\*\.txt"', ""),
    ("pyproject.toml", r'(?m)^version = "([^"]+)"$', r'version = "\1+lowtran7"'),
    (
        "README.md",
        r"; of the MT_CKD data, their own \(`LICENSES`\): their notice.*?without them\.",
        ". This package was built without MT_CKD data;\nits water vapour continuum is that of LOWTRAN7.",
    ),
    (
        "NOTICE",
        r"    Water vapour, N2, O2 and CO2 continua from MT_CKD.*?implied warranties\.\n",
        "    Water vapour, N2 and O2 continua from LOWTRAN7 (AFGL-TR-88-0177, public domain).\n",
    ),
    (
        "atmospheres/absorption.md",
        r"\A(# .*\n)",
        r"\1\n**This package was built without MT_CKD: wherever this page names MT_CKD, its table contains the"
        r" continua of LOWTRAN7 (`continuum/README.md`).**\n",
    ),
)


@click.command(help=__doc__)
@click.argument("checkout", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.argument("out", type=click.Path(file_okay=False, path_type=Path))
@click.option(
    "--absorption", required=True, type=click.Path(path_type=Path), help="Band model with LOWTRAN7's continua."
)
@click.option(
    "--broadband", required=True, type=click.Path(path_type=Path), help="Broadband points of that band model."
)
def main(checkout: Path, out: Path, absorption: Path, broadband: Path) -> None:
    """Write the tree to a folder that does not exist yet."""
    check_tables(absorption, broadband)
    if out.exists():
        raise InputError("exists already; name a new folder", file=out)
    for folder in FOLDERS:
        shutil.copytree(checkout / folder, out / folder, ignore=shutil.ignore_patterns("__pycache__", "*.h5"))
    for name in (*FILES, *PARTICLES):
        shutil.copyfile(checkout / name, out / name)
    shutil.copyfile(absorption, out / "atmospheres/absorption.h5")
    shutil.copyfile(broadband, out / "atmospheres/broadband.h5")
    for file in (out / "atmospheres/continuum").glob("mt_ckd*"):
        file.unlink()
    for name, pattern, replacement in EDITS:
        _edit(out / name, pattern, replacement)
    click.echo(f"{out}: build the package with 'pip wheel --no-deps {out}'")


def check_tables(absorption: Path, broadband: Path) -> None:
    """Refuse a band model with figures of MT_CKD, or points of another band model.

    Raises
    ------
    InputError
    """
    with open_database(absorption, FILETYPE) as file:
        continuum = str(file.attrs.get("water_continuum", "mt_ckd_4.3"))
        content = str(file.attrs["content_sha256"])
        if continuum != LowtranContinua.name or (named := _naming_mt_ckd(file)):
            origin = "its water vapour continuum" if continuum != LowtranContinua.name else named
            raise InputError(
                f"contains figures of MT_CKD ({origin}); make it with 'mat lines build --continua lowtran7'",
                file=absorption,
            )
    with open_database(broadband, fluxes.FILETYPE) as file:
        if str(file.attrs["absorption_sha256"]) != content:
            raise InputError(
                f"was not chosen from {absorption}; choose with 'python -m mat.maintain.lines broadband --table"
                f" {absorption}'",
                file=broadband,
            )


def _naming_mt_ckd(file: h5py.File) -> str:
    """Place of an attribute that names MT_CKD, or an empty text."""
    attributes: list[str] = []

    def visit(name: str, item: h5py.HLObject) -> None:
        attributes.extend(f"{name}@{key}" for key, value in item.attrs.items() if re.search(r"(?i)mt_?ckd", str(value)))

    visit("", file)
    file.visititems(visit)
    return attributes[0] if attributes else ""


def _edit(file: Path, pattern: str, replacement: str) -> None:
    text, count = re.subn(pattern, replacement, file.read_text(encoding="utf-8"), flags=re.DOTALL)
    if count != 1:
        raise InputError(f"has {count} places like '{pattern}', allowed: 1; adjust EDITS to the text", file=file)
    file.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
