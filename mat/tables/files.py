"""The file types of the table builder: names, file names."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class FileType:
    """One type of database.

    Attributes
    ----------
    name : str
        The root attribute ``filetype``.
    """

    name: str
    title: str


HTT = FileType("htt", "Surface temperatures through the day")
ATMQ = FileType("atmq", "Atmospheric quantities with the Sun as source")
LUNAR_ATMQ = FileType("lunar_atmq", "Atmospheric quantities with the Moon as source")
BAND = FileType("band", "Blackbody radiance and material properties of a spectral band")
# Spectrum of one line of sight, written by `mat spectrum` and in no catalogue.
SPECTRUM = FileType("spectrum", "Spectra of one line of sight")
FORMATS: dict[str, FileType] = {kind.name: kind for kind in (HTT, ATMQ, LUNAR_ATMQ, BAND)}  # those of a build


def state_label(state: int, states: int = 1) -> str:
    """Label of a state, counted from 1: two digits, more where the job has more than 99 `states`."""
    return f"s{state:0{max(2, len(str(states)))}d}"


def state_file(state: int, states: int = 1) -> str:
    """Name of the temperature table of a state of a job with so many `states`."""
    return f"{state_label(state, states)}.htt.h5"


def atmosphere_file(state: int, band: int, source: str, states: int = 1) -> str:
    """Name of the atmospheric table of a state, band and source ('sun' or 'moon')."""
    return f"{state_label(state, states)}b{band:02d}.{'atmq' if source == 'sun' else 'lunar_atmq'}.h5"


def band_file(band: int) -> str:
    """Name of the band database, counted from 1."""
    return f"b{band:02d}.band.h5"
