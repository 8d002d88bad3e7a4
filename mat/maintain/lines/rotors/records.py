"""Generated lines as HITRAN records, one file a spectral region, with the source of every band beside them."""

from __future__ import annotations

import csv
import gzip
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mat.maintain.lines.rotors import nitrous_oxide, ozone
from mat.maintain.lines.rotors.bands import BandLines

# Regions within which the bands are complete, cm^-1; lines outside them are omitted.
REGIONS = {
    ozone.MOLECULE: ((600.0, 830.0), (950.0, 1200.0), (2010.0, 2190.0)),
    nitrous_oxide.MOLECULE: ((530.0, 650.0), (1110.0, 1345.0)),
}
PROVENANCE = "bands.csv"


def write_all(folder: Path) -> list[Path]:
    """Generate the lines of all molecules and write them into a folder; returns the files of records."""
    folder.mkdir(parents=True, exist_ok=True)
    bands = [*ozone.all_bands(), *nitrous_oxide.band_lines()]
    files = []
    for molecule, regions in REGIONS.items():
        for low, high in regions:
            path = folder / f"{molecule:02d}_generated_{low:.0f}_{high:.0f}.par.gz"
            write(path, bands, molecule, low, high)
            files.append(path)
    with (folder / PROVENANCE).open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["reference", "molecule", "isotopologue", "upper", "lower", "lines", "strength", "source"])
        for number, band in enumerate(bands, start=1):
            strength = f"{band.strength.sum():.4g}"
            writer.writerow(
                [
                    number,
                    band.molecule,
                    band.isotopologue,
                    band.upper,
                    band.lower,
                    band.strength.size,
                    strength,
                    band.source,
                ]
            )
    return files


def write(path: Path, bands: Sequence[BandLines], molecule: int, low: float, high: float) -> None:
    """Write the lines of a molecule between two wavenumbers (cm^-1), ordered; the six reference numbers of each record
    are the row of its band in the list of bands.
    """
    rows = [
        record
        for number, band in enumerate(bands, start=1)
        if band.molecule == molecule
        for record in _records(band, number, low, high)
    ]
    with gzip.GzipFile(path, "wb", mtime=0) as file:
        file.write("".join(f"{record}\n" for _, record in sorted(rows)).encode("ascii"))


def _records(band: BandLines, reference: int, low: float, high: float) -> list[tuple[float, str]]:
    """(wavenumber, record of 160 characters) of the lines of a band (Rothman et al. 2005, JQSRT 96, 139, Table 1)."""
    states = f"{' '.join(band.upper):>15s}{' '.join(band.lower):>15s}"
    codes = f"{0:06d}{f'{reference:2d}' * 6} {0.0:7.1f}{0.0:7.1f}"
    rows = []
    for k in np.flatnonzero((band.wavenumber >= low) & (band.wavenumber <= high)):
        position = (
            f"{band.molecule:2d}{band.isotopologue:1d}{band.wavenumber[k]:12.6f}{band.strength[k]:10.3E}{0.0:10.3E}"
        )
        widths = f"{_short(band.air_width[k], 4)}{band.self_width[k]:5.3f}{band.lower_energy[k]:10.4f}"
        change = f"{band.temperature_exponent[k]:4.2f}{_short(band.shift[k], 6):>8s}"
        rotation = f"{band.upper_rotation[k]}{band.lower_rotation[k]}"
        rows.append((float(band.wavenumber[k]), position + widths + change + states + rotation + codes))
    return rows


def _short(value: float, digits: int) -> str:
    """A number below 1 without its leading zero."""
    return f"{value:.{digits}f}".replace("0.", ".", 1)
