"""Air of a MODTRAN input: a standard model, or levels with units by letter, as cards (`modtran_cards`) or JSON
(`modtran_json`) state it.

References
----------
Berk et al. 2003, MODTRAN4 Version 3 Revision 1 User's Manual; Berk et al. 2011, MODTRAN 5.2.2 User's Manual (cards 1,
1A, 2, 2C, 2C1, 2C2, 2C2X); Kneizys et al. 1988, AFGL-TR-88-0177 (letters of units, models that replace values).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.soundings.readings import Readings
from skyshine.mat.atmosphere.state.gas_amounts import DOBSON_UNIT, GasAmounts
from skyshine.mat.atmosphere.state.humidity import WATER_MOLAR_MASS
from skyshine.mat.atmosphere.state.hydrostatics import DRY_AIR_MOLAR_MASS
from skyshine.mat.atmosphere.state.levels import exponential, linear
from skyshine.mat.atmosphere.state.profiles import Profile, load_profile
from skyshine.mat.radiometry.constants import AVOGADRO, BOLTZMANN, GAS_CONSTANT, MMHG, STANDARD_ATMOSPHERE, ZERO_CELSIUS
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

MODELS = dict(
    enumerate(
        ("tropical", "midlatitude_summer", "midlatitude_winter", "subarctic_summer", "subarctic_winter", "us_standard"),
        start=1,
    )
)
CONSTANT, BY_ALTITUDE, BY_PRESSURE = 0, 7, 8  # values of MODEL beside those
# Gases of cards 2C1 and 2C2 in order, with g mol^-1 (IUPAC 2018); those of 2C2X, of which others than these are left.
MOLAR_MASSES = {
    "H2O": 1e3 * WATER_MOLAR_MASS,
    "CO2": 44.009,
    "O3": 47.997,
    "N2O": 44.013,
    "CO": 28.010,
    "CH4": 16.043,
    "O2": 31.998,
    "NO": 30.006,
    "SO2": 64.058,
    "NO2": 46.005,
    "NH3": 17.031,
    "HNO3": 63.012,
    "CFC-11": 137.36,
    "CFC-12": 120.91,
    "HCFC-22": 86.47,
    "CCl4": 153.81,
}
GASES = tuple(MOLAR_MASSES)[:12]
HEAVY_GASES = ("CFC-11", "CFC-12", "", "", "HCFC-22", "", "", "", "", "", "", "CCl4", "")
# Factor and offset to SI by letter.
_PRESSURE = {"A": 1e2, "B": STANDARD_ATMOSPHERE, "C": MMHG}
_TEMPERATURE = {"A": (1.0, 0.0), "B": (1.0, ZERO_CELSIUS), "C": (5 / 9, 459.67 * 5 / 9)}
_WATER = {"E": ("vapour_pressure", 1e2, 0.0), "F": ("dew_point", 1.0, 0.0), "G": ("dew_point", 1.0, ZERO_CELSIUS)}
_WATER |= {"A": ("h2o", 1e-6, 0.0), "C": ("mixing_ratio", 1e-3, 0.0), "D": ("absolute_humidity", 1e-3, 0.0)}
_WATER |= {"H": ("relative_humidity", 1e-2, 0.0)}
_LETTERS = {"pressure": "ABC", "temperature": "ABC", "H2O": "ABCDEFGH"}
_OF_GASES = "ABCDE"
_HIGHEST = 100e3  # m, of the levels of a standard model: where a sounding may end
_ATM_CM = 1e3 * DOBSON_UNIT  # molecules m^-2


@dataclass(frozen=True)
class Cell:
    """A value of a level.

    Attributes
    ----------
    unit : str
        Letter of the unit, number 1 to 6 of the model whose value is meant, or empty.
    line, column : int
        Place in the file, counted from 1.
    """

    value: float
    unit: str
    line: int
    column: int


@dataclass(frozen=True, eq=False)
class ModtranAir:
    """Air as MODTRAN describes it.

    Attributes
    ----------
    model : int
        Value of MODEL: 1 to 6, `BY_ALTITUDE` or `BY_PRESSURE`.
    instead : dict of str to int
        Number of the model in place of MODEL's, or of values that are not given, by quantity or gas: M1 to M6.
    levels : sequence of dict of str to Cell
        Altitude [km], pressure, temperature and gases; empty for MODEL 1 to 6.
    amounts : GasAmounts
        Amounts of H2O and O3 by H2OSTR and O3STR.
    notes : tuple of str
        What the file says that is not read.
    """

    file: Path
    model: int
    instead: Mapping[str, int] = field(default_factory=dict)
    levels: Sequence[Mapping[str, Cell]] = ()
    amounts: GasAmounts = field(default_factory=GasAmounts)
    notes: tuple[str, ...] = ()
    time: None = None

    def read(self) -> Readings:
        """Readings in SI units.

        Raises
        ------
        InputError
            A unit that a quantity does not have, or a level without altitude, pressure or temperature.
        """
        return self._of_levels() if self.levels else self._of_model()

    def _of_model(self) -> Readings:
        base = load_profile(MODELS[self.model])
        inside = base.altitude <= _HIGHEST
        altitude = base.altitude[inside]
        values = {"altitude": altitude}
        for name in ("pressure", "temperature", *(gas for gas in base.mole_fraction)):
            number = self.instead.get("temperature" if name == "pressure" else name) or self.model
            values["h2o" if name == "H2O" else name] = _of_profile(load_profile(MODELS[number]), name, altitude)
        return Readings(self.file, values, "sorted", amounts=self.amounts, notes=self.notes)

    def _of_levels(self) -> Readings:
        size = len(self.levels)
        values: dict[str, Floats] = {}
        written: dict[str, Floats] = {}
        places: dict[tuple[int, str], tuple[int, int]] = {}

        def put(row: int, name: str, value: float, cell: Cell) -> None:
            values.setdefault(name, np.full(size, np.nan))[row] = value
            written.setdefault(name, np.full(size, np.nan))[row] = cell.value
            places[row, name] = (cell.line, cell.column)

        missing = set()
        for row, level in enumerate(self.levels):
            height = level["altitude"]
            altitude = 1e3 * height.value
            if self.model == BY_ALTITUDE or row == 0:
                put(row, "altitude", altitude, height)
            state = {}
            for name in ("pressure", "temperature"):
                state[name] = self._in_si(name, level.get(name), altitude)
                put(row, name, state[name], level.get(name, height))
            for gas in (*GASES, *filter(None, HEAVY_GASES)):
                cell = level.get(gas)
                unit = self._unit(gas, cell)
                if unit == "":
                    missing.add(gas)
                elif unit.isdigit():
                    profile = load_profile(MODELS[int(unit)])
                    name = "h2o" if gas == "H2O" else gas
                    put(row, name, float(_of_profile(profile, gas, np.array([altitude]))[0]), cell or height)
                else:
                    assert cell is not None  # a unit of its own
                    put(row, *_of_gas(gas, cell.value, unit, **state), cell)
        notes = list(self.notes)
        if missing - set(HEAVY_GASES):
            named = ", ".join(gas for gas in GASES if gas in missing)
            notes.append(f"gives no amount of {named} at some level; the profile's is used at all")
        values = {name: array for name, array in values.items() if name not in missing}
        return Readings(self.file, values, "sorted", None, written, places, self.amounts, tuple(notes))

    def _unit(self, name: str, cell: Cell | None) -> str:
        """Letter or number of what gives a value; empty where nothing does, which for H2O is dry air."""
        unit = "" if cell is None else cell.unit.upper()
        number = self.instead.get("temperature" if name == "pressure" else name, 0)
        if cell is None or (not unit and cell.value == 0.0):
            unit = str(number or ("A" if name == "H2O" else ""))
        if cell is None:
            return unit
        allowed = ["A", *_LETTERS.get(name, _OF_GASES)[1:]]
        models = [] if self.model == BY_PRESSURE else [str(number) for number in MODELS]
        if unit and unit not in (*allowed, *models):
            raise _error(
                self.file,
                cell,
                f"found the unit {unit!r} of {name}; allowed: {', '.join(allowed)}"
                + (f", or {models[0]} to {models[-1]} for a standard model's" if models else ", at levels of pressure"),
            )
        return unit or ("A" if cell.value != 0.0 else "")

    def _in_si(self, name: str, cell: Cell | None, altitude: float) -> float:
        unit = self._unit(name, cell)
        if unit.isdigit():
            return float(_of_profile(load_profile(MODELS[int(unit)]), name, np.array([altitude]))[0])
        if cell is None or unit == "":
            raise InputError(
                f"gives no {name} at {altitude / 1e3:g} km; allowed: {name} at every level", file=self.file
            )
        if name == "pressure":
            return cell.value * _PRESSURE[unit]
        factor, offset = _TEMPERATURE[unit]
        return cell.value * factor + offset


def _of_profile(profile: Profile, name: str, altitude: Floats) -> Floats:
    """Pressure, temperature or a gas of a standard model at altitudes [m]."""
    if name == "temperature":
        return linear(altitude, profile.altitude, profile.temperature)
    return exponential(
        altitude, profile.altitude, profile.pressure if name == "pressure" else profile.mole_fraction[name]
    )


def _of_gas(gas: str, value: float, unit: str, pressure: float, temperature: float) -> tuple[str, float]:
    """Name and SI value of an amount of gas; a mole fraction but for measures of humidity."""
    if unit == "B":
        fraction = 1e6 * value * BOLTZMANN * temperature / pressure
        return ("h2o" if gas == "H2O" else gas), fraction
    if gas == "H2O":
        name, factor, offset = _WATER[unit]
        return name, value * factor + offset
    moles_per_gram = 1 / MOLAR_MASSES[gas]
    factor = {
        "A": 1e-6,
        "C": DRY_AIR_MOLAR_MASS * moles_per_gram,
        "D": moles_per_gram * GAS_CONSTANT * temperature / pressure,
        "E": 1e2 / pressure,
    }[unit]
    return gas, value * factor


def column_amounts(water: tuple[float, str], ozone: tuple[float, str]) -> GasAmounts:
    """Amounts by H2OSTR and O3STR.

    Parameters
    ----------
    water, ozone : (float, str)
        Value, and its unit: ``'g'`` for g cm^-2, ``'a'`` for atm cm, empty for a factor on the profile. A value of 0
        leaves the profile as it is.
    """
    scale: dict[str, float] = {}
    columns: dict[str, float] = {}  # molecules m^-2
    for gas, (value, unit) in (("H2O", water), ("O3", ozone)):
        if value == 0:
            continue
        if unit == "":
            scale[gas] = value
        elif unit == "a":
            columns[gas] = value * _ATM_CM
        else:
            columns[gas] = value * 1e4 / MOLAR_MASSES[gas] * AVOGADRO
    return GasAmounts(
        scale=scale,
        water_column=columns["H2O"] / AVOGADRO * WATER_MOLAR_MASS if "H2O" in columns else None,
        ozone_column=columns["O3"] / DOBSON_UNIT if "O3" in columns else None,
    )


def _error(file: Path, cell: Cell, message: str) -> InputError:
    return InputError(message, file=file, line=cell.line, column=cell.column)
