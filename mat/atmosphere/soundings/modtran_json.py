"""Air of the JSON of MODTRAN 6: ATMOSPHERE of its first case. See `modtran` for what the cards say likewise."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from skyshine.mat.atmosphere.soundings.modtran import (
    BY_ALTITUDE,
    BY_PRESSURE,
    CONSTANT,
    GASES,
    MODELS,
    Cell,
    ModtranAir,
    column_amounts,
)
from skyshine.schemas.documents import Document, Location, document_of
from skyshine.schemas.errors import nearest

_MODELS = {
    "ATM_CONSTANT": CONSTANT,
    "ATM_TROPICAL": 1,
    "ATM_MIDLAT_SUMMER": 2,
    "ATM_MIDLAT_WINTER": 3,
    "ATM_SUBARC_SUMMER": 4,
    "ATM_SUBARC_WINTER": 5,
    "ATM_US_STANDARD_1976": 6,
    "ATM_USER_ALT_PROFILE": BY_ALTITUDE,
    "ATM_USER_PRESS_PROFILE": BY_PRESSURE,
}
_QUANTITIES = {f"PROF_{name.upper()}": name for name in ("altitude", "pressure", "temperature")}
_QUANTITIES |= {f"PROF_{gas}": gas for gas in GASES}
_QUANTITIES |= {
    "PROF_WATER_VAPOR": "H2O",
    "PROF_CARBON_DIOXIDE": "CO2",
    "PROF_OZONE": "O3",
    "PROF_NITROUS_OXIDE": "N2O",
    "PROF_CARBON_MONOXIDE": "CO",
    "PROF_METHANE": "CH4",
    "PROF_OXYGEN": "O2",
    "PROF_NITRIC_OXIDE": "NO",
    "PROF_SULFUR_DIOXIDE": "SO2",
    "PROF_NITROGEN_DIOXIDE": "NO2",
    "PROF_AMMONIA": "NH3",
    "PROF_NITRIC_ACID": "HNO3",
}
for _gas, _names in {
    "CFC-11": ("CCl3F", "F11", "CFC11"),
    "CFC-12": ("CCl2F2", "F12", "CFC12"),
    "HCFC-22": ("CHClF2", "F22", "CFC22"),
    "CCl4": ("CCl4",),
}.items():
    _QUANTITIES |= {f"PROF_{name}": _gas for name in _names}
_LETTERS = {"UNT_DPPMV": "A", "UNT_DMOL_PER_CM3": "B", "UNT_DGRAM_PER_KG": "C", "UNT_DGRAM_PER_M3": "D"}
_UNITS = {
    "altitude": {"UNT_KILOMETERS": "A"},
    "pressure": {"UNT_PMILLIBAR": "A", "UNT_PATM": "B"},
    "temperature": {"UNT_TKELVIN": "A", "UNT_TCELSIUS": "B"},
    "H2O": _LETTERS
    | {"UNT_PMILLIBAR": "E", "UNT_TDEWPOINT_KELVIN": "F", "UNT_TDEWPOINT_CELSIUS": "G", "UNT_REL_HUMIDITY": "H"},
}
_NOT_READ = "is read for its ATMOSPHERE; keys of the job give aerosol, ground, geometry and spectral range"


def read_modtran_json(text: str, file: Path) -> ModtranAir:
    """Air of the first case of a MODTRAN JSON.

    Raises
    ------
    InputError
        With file:line:column of a key that is missing, a model, profile or unit that is unknown, and of profiles of
        different lengths.
    """
    document = document_of(text.replace("\t", " "), file)
    cases = _get(document, (), "MODTRAN")
    here: Location = ("MODTRAN", 0, "MODTRANINPUT", "ATMOSPHERE")
    if not (isinstance(cases, list) and cases):
        raise document.error(("MODTRAN",), "found no list of cases; allowed: MODTRAN: [{MODTRANINPUT: ...}]")
    _get(document, here[:2], "MODTRANINPUT")
    _get(document, here[:3], "ATMOSPHERE")
    model = _model(document, (*here, "MODEL"))
    if model is None or model == CONSTANT:
        raise document.error(
            (*here, "MODEL"),
            f"found {'no MODEL' if model is None else 'air of one level'}; {nearest('', [*_MODELS][1:])}",
        )
    instead = {}
    for number, name in enumerate(("temperature", "H2O", "O3", "CH4", "N2O", "CO"), start=1):
        instead[name] = _model(document, (*here, f"M{number}")) or 0
        if instead[name] > len(MODELS):
            raise document.error((*here, f"M{number}"), "found a user's profile; allowed: a standard model; name one")
    amounts = column_amounts(_amount(document, here, "H2O"), _amount(document, here, "O3"))
    if _lookup(document, (*here, "C_PROF")):
        raise document.error((*here, "C_PROF"), "found factors on minor gases; allowed: C_PROF 0")
    notes = [_NOT_READ]
    if _lookup(document, (*here, "CO2MX")):
        notes.append(f"states {_lookup(document, (*here, 'CO2MX'))} ppm of CO2 (CO2MX), which co2_ppm gives instead")
    if len(cases) > 1:
        notes.append(f"has {len(cases)} cases; the air is that of the first")
    levels = _levels(document, (*here, "PROFILES")) if model in (BY_ALTITUDE, BY_PRESSURE) else []
    return ModtranAir(file, model, instead, levels, amounts, tuple(notes))


def _lookup(document: Document, location: Location) -> Any:
    """The value at a location, None where there is none."""
    value = document.data
    for part in location:
        try:
            value = value[part]
        except (KeyError, IndexError, TypeError):
            return None
    return value


def _get(document: Document, location: Location, key: str) -> Any:
    value = _lookup(document, (*location, key))
    if value is None:
        raise document.error(location, f"has no {key}; allowed: an input of MODTRAN 6 with it; add it")
    return value


def _model(document: Document, location: Location) -> int | None:
    """Number of a standard model or of a user's profile, by its name or number; None where the key is missing."""
    value = _lookup(document, location)
    if value is None:
        return None
    if isinstance(value, str) and value in _MODELS:
        return _MODELS[value]
    if isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= BY_PRESSURE:
        return value
    raise document.error(location, f"found {value!r}; {nearest(str(value), _MODELS)}")


def _amount(document: Document, location: Location, gas: str) -> tuple[float, str]:
    """Value and unit of H2OSTR or O3STR."""
    value = _lookup(document, (*location, f"{gas}STR"))
    unit = str(_lookup(document, (*location, f"{gas}UNIT")) or "").strip().lower()
    if unit not in ("", "g", "a"):
        raise document.error((*location, f"{gas}UNIT"), f"found {unit!r}; allowed: g (g/cm2), a (atm cm) or blank")
    if value is None:
        return 0.0, ""
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < float("inf"):
        raise document.error((*location, f"{gas}STR"), f"found {value!r}; allowed: a number of at least 0")
    return float(value), unit


def _levels(document: Document, location: Location) -> list[dict[str, Cell]]:
    profiles = _lookup(document, location)
    if not (isinstance(profiles, list) and profiles):
        raise document.error(location, "has no PROFILES for a user's profile; add them")
    columns: dict[str, list[Cell]] = {}
    for index in range(len(profiles)):
        here = (*location, index)
        kind = _get(document, here, "TYPE")
        if kind not in _QUANTITIES:
            continue  # aerosol, and gases that no table has
        name = _QUANTITIES[kind]
        if name in columns:
            raise document.error((*here, "TYPE"), f"found {name} twice; allowed: once; remove one")
        columns[name] = _column(document, here, name)
        for other, cells in columns.items():
            if len(cells) != len(columns[name]):
                raise document.error(
                    (*here, "PROFILE"), f"found {len(columns[name])} values of {name} and {len(cells)} of {other}"
                )
    for name in ("altitude", "pressure", "temperature"):
        if name not in columns:
            raise document.error(location, f"has no PROF_{name.upper()}; add it")
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def _column(document: Document, location: Location, name: str) -> list[Cell]:
    units = _UNITS.get(name, _LETTERS)
    unit, values = _get(document, location, "UNITS"), _get(document, location, "PROFILE")
    if unit not in units:
        raise document.error((*location, "UNITS"), f"found {unit!r} of {name}; {nearest(str(unit), units)}")
    if not isinstance(values, list):
        raise document.error((*location, "PROFILE"), "found no list; allowed: numbers")
    masks = _lookup(document, (*location, "PRO_MASK")) or [0] * len(values)
    cells = []
    for row, value in enumerate(values):
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < float("inf"):
            raise document.error((*location, "PROFILE", row), f"found {value!r}; allowed: a finite number")
        mask = masks[row] if isinstance(masks, list) and row < len(masks) else -1
        if mask not in range(len(MODELS) + 1):
            raise document.error((*location, "PRO_MASK"), f"found {mask!r}; allowed: 0 to {len(MODELS)} for each level")
        line, column = document.where((*location, "PROFILE", row))
        assert line is not None and column is not None  # the place of a text
        cells.append(Cell(float(value), str(mask) if mask else units[unit], line, column))
    return cells
