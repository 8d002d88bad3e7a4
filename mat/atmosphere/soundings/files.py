"""Soundings of a file in any of the formats that are read."""

from __future__ import annotations

from datetime import datetime
from functools import lru_cache
from pathlib import Path

from skyshine.mat.atmosphere.soundings.choice import Choice, index_of
from skyshine.mat.atmosphere.soundings.igra import IgraSounding, igra_soundings
from skyshine.mat.atmosphere.soundings.levels import Levels, levels_of
from skyshine.mat.atmosphere.soundings.modtran import ModtranAir
from skyshine.mat.atmosphere.soundings.modtran_cards import is_cards, read_cards
from skyshine.mat.atmosphere.soundings.modtran_json import read_modtran_json
from skyshine.mat.atmosphere.soundings.netcdf import is_netcdf, read_column, times_in
from skyshine.mat.atmosphere.soundings.readings import Readings
from skyshine.mat.atmosphere.soundings.table import read_table
from skyshine.mat.atmosphere.soundings.wyoming import WyomingList, wyoming_lists
from skyshine.schemas.csv_table import read_text
from skyshine.schemas.regular_files import refuse_special_file


def read_levels(file: Path, choice: Choice | None = None) -> Levels:
    """The sounding of a file that is chosen.

    Parameters
    ----------
    file : Path
        CSV, a list of the University of Wyoming (text or CSV), IGRA v2, netCDF on pressure levels, or an input of
        MODTRAN (cards or JSON).
    choice : Choice, optional
        Choice of a sounding; by default the only one of the file.

    Raises
    ------
    InputError
        With file:line:column of what does not fit.
    """
    refuse_special_file(file)
    choice = choice or Choice()
    if is_netcdf(file):
        return levels_of(read_column(file, choice))
    soundings = _in_file(file, file.stat().st_mtime_ns, file.stat().st_size)
    return levels_of(_readings(soundings[index_of([sounding.time for sounding in soundings], choice, file)]))


def levels_in_text(text: str, file: Path) -> Levels:
    """The only sounding of a text.

    Raises
    ------
    InputError
        As `read_levels`.
    """
    soundings = _soundings(text, file)
    return levels_of(_readings(soundings[index_of([sounding.time for sounding in soundings], Choice(), file)]))


def times_of(file: Path) -> list[datetime | None]:
    """Times of the soundings of a file; None where it does not say.

    Raises
    ------
    InputError
        As `read_levels`.
    """
    refuse_special_file(file)
    if is_netcdf(file):
        return times_in(file)
    return [sounding.time for sounding in _in_file(file, file.stat().st_mtime_ns, file.stat().st_size)]


_Sounding = Readings | IgraSounding | WyomingList | ModtranAir


def _readings(sounding: _Sounding) -> Readings:
    return sounding if isinstance(sounding, Readings) else sounding.read()


@lru_cache(maxsize=2)
def _in_file(file: Path, changed_ns: int, size: int) -> list[_Sounding]:
    """Soundings of a file, read once for all states of a job."""
    return _soundings(read_text(file), file)


def _soundings(text: str, file: Path) -> list[_Sounding]:
    if is_cards(text):
        return [read_cards(text, file)]
    if text.lstrip().startswith("{"):
        return [read_modtran_json(text, file)]
    return [*igra_soundings(text, file)] or [*wyoming_lists(text, file)] or [read_table(text, file)]
