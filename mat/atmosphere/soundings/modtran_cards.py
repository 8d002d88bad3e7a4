"""Air of the cards of MODTRAN 4 and 5: tape5, `.tp5`, and `.ltn` of PcModWin. See `modtran` for the manuals."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from skyshine.mat.atmosphere.soundings.modtran import (
    BY_ALTITUDE,
    BY_PRESSURE,
    CONSTANT,
    GASES,
    HEAVY_GASES,
    MODELS,
    Cell,
    ModtranAir,
    column_amounts,
)
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.schemas.errors import InputError
from skyshine.schemas.plain_numbers import plain_number

# Card 1: MODTRN, SPEED, BINARY, LYMOLC, MODEL, T_BEST, ITYPE, IEMSCT, IMULT, M1.
_CARD_1 = re.compile(r"[TMCKFL][SMTF01+ ]{3}[0-8][TF ] {0,3}[1-4] {4}[0-4] {3}[- ][0-2]( {4}[0-9])+", re.I)
_MOST_LEVELS = 5000
_NOT_READ = "states aerosol, clouds, ground, geometry and spectral range as well, which keys of the job give instead"


def is_cards(text: str) -> bool:
    """Whether a text begins with card 1 of MODTRAN."""
    return bool(_CARD_1.match(text.partition("\n")[0]))


def read_cards(text: str, file: Path) -> ModtranAir:
    """Air of the first run of a tape5.

    Raises
    ------
    InputError
        With file:line:column of what is no number or no value of its field, of a card that is missing, and of air that
        is no column: that of a horizontal path (MODEL 0), or of an earlier run (I_RD2C 0).
    """
    deck = _Deck(text, file)
    card = deck.next("card 1")
    model = int(card.text(4, 5))
    m1, m2, m3, m4, m5, m6, heavy_amounts, reads_levels = (card.whole(start, start + 5) for start in range(20, 60, 5))
    instead = dict(zip(("temperature", "H2O", "O3", "CH4", "N2O", "CO"), (m1, m2, m3, m4, m5, m6), strict=True))
    for index, number in enumerate(instead.values()):
        if not 0 <= number <= len(MODELS):
            raise card.error(20 + 5 * index, f"found M{index + 1} {number}; allowed: 0 to {len(MODELS)}")
    notes = [_NOT_READ]
    amounts, extra_cards, carbon_dioxide = _card_1a(deck.next("card 1A"))
    if carbon_dioxide:
        notes.append(f"states {carbon_dioxide:g} ppm of CO2 (CO2MX), which co2_ppm gives instead")
    for name in extra_cards:
        deck.next(name)
    _skip_aerosol(deck)
    levels = []
    if model == CONSTANT:
        raise card.error(4, "found MODEL 0, air of one level; allowed: 1 to 8; give its values as levels (MODEL 7)")
    if model in (BY_ALTITUDE, BY_PRESSURE):
        if reads_levels != 1:
            raise card.error(
                55, f"found MODEL {model} with I_RD2C {reads_levels}, levels of an earlier run; allowed: 1; add card 2C"
            )
        levels = list(_levels(deck, heavy_amounts))
    runs = sum(bool(_CARD_1.match(line)) for line in deck.rest)
    if runs:
        notes.append(f"has {runs} more run{'s' if runs > 1 else ''}, whose air is not read")
    return ModtranAir(file, model, instead, levels, amounts, tuple(notes))


class _Card:
    """A line of fields by column."""

    def __init__(self, file: Path, number: int, line: str) -> None:
        self.file, self.number, self.line = file, number, line

    def text(self, start: int, stop: int) -> str:
        return self.line[start:stop].strip()

    def value(self, start: int, stop: int) -> float:
        """A number as Fortran reads it; 0 for blanks."""
        written = self.text(start, stop)
        try:
            return plain_number(re.sub("[dD]", "e", written)) if written else 0.0
        except ValueError:
            raise self.error(
                start, f"found {written!r} in columns {start + 1} to {stop}; allowed: a number; align it with its field"
            ) from None

    def whole(self, start: int, stop: int) -> int:
        value = self.value(start, stop)
        if value != int(value):
            raise self.error(start, f"found {self.text(start, stop)!r}; allowed: a whole number")
        return int(value)

    def cell(self, start: int, stop: int, unit: str) -> Cell:
        return Cell(self.value(start, stop), unit.strip(), self.number, start + 1)

    def error(self, start: int, message: str) -> InputError:
        return InputError(message, file=self.file, line=self.number, column=start + 1)


class _Deck:
    """Cards in order."""

    def __init__(self, text: str, file: Path) -> None:
        self.file, self._lines, self._used = file, text.splitlines(), 0

    @property
    def rest(self) -> list[str]:
        return self._lines[self._used :]

    def next(self, name: str) -> _Card:
        if not self.rest:
            raise InputError(
                f"ends before {name}; allowed: the cards of a MODTRAN run", file=self.file, line=len(self._lines)
            )
        line = self.rest[0]
        self._used += 1
        card = _Card(self.file, self._used, line)
        if "\t" in line:
            raise card.error(
                line.index("\t"), f"found a tab in {name}; allowed: fields by column; replace it by blanks"
            )
        return card


def _card_1a(card: _Card) -> tuple[GasAmounts, list[str], float]:
    """Amounts of gases, names of the cards that follow, and CO2MX [ppm]."""
    if not re.match(r"[TFS01 ][TF01 ][TF01 ]", card.line, re.I) or len(card.text(10, 20).split()) > 1:
        raise card.error(0, "found no card 1A; allowed: T, F or blank in columns 1 to 3; the echo of a run lacks it")
    carbon_dioxide = card.value(10, 20)
    amounts = column_amounts(_amount(card, 20, "H2OSTR"), _amount(card, 30, "O3STR"))
    if card.text(40, 41) not in ("", "0"):
        raise card.error(40, f"found C_PROF {card.text(40, 41)!r}, factors on minor gases; allowed: 0 or blank")
    if card.text(100, 110) not in ("", "0"):
        raise card.error(100, f"found NSSALB {card.text(100, 110)}; allowed: 0 or blank; remove card 1B")
    switches = {"card 1A1": 41, "card 1A2": 43, "card 1A3": 45, "card 1A4": 49}
    following = [name for name, column in switches.items() if card.text(column, column + 1).upper() == "T"]
    return amounts, following, carbon_dioxide


def _amount(card: _Card, start: int, name: str) -> tuple[float, str]:
    """Number and unit of H2OSTR or O3STR."""
    written = card.text(start, start + 10)
    unit = written[:1].lower() if written[:1].lower() in ("g", "a") else ""
    try:
        value = plain_number(written[len(unit) :]) if written[len(unit) :].strip() else 0.0
    except ValueError:
        value = -1.0
    if value < 0:
        raise card.error(
            start,
            f"found {name} {written!r}; allowed: g or a with a column in g/cm2 or atm cm, or a factor of at least 0",
        )
    return value, unit


def _skip_aerosol(deck: _Deck) -> None:
    """Card 2 and those that belong to it before the levels."""
    card = deck.next("card 2")
    cloud, army = card.whole(20, 25), card.whole(25, 30)
    if card.text(0, 2).upper() == "A+":
        deck.next("card 2A+")
        deck.next("the second line of card 2A+")
    if 1 <= cloud <= 10 or cloud in (18, 19):
        deck.next("card 2A")
    if army == 1:
        deck.next("card 2B")


def _levels(deck: _Deck, heavy_amounts: int) -> Iterator[dict[str, Cell]]:
    card = deck.next("card 2C")
    count, minor, aerosol = card.whole(0, 5), card.whole(5, 10), card.whole(10, 15)
    if not 2 <= count <= _MOST_LEVELS:
        raise card.error(0, f"found {count} levels (ML); allowed: 2 to {_MOST_LEVELS}")
    if card.text(45, 50) not in ("", "0"):
        raise card.error(45, f"found NMOLYC {card.text(45, 50)}; allowed: 0 or blank; remove the gases of card 2CY")
    for number in range(1, count + 1):
        where = f"level {number} of {count}"
        card = deck.next(f"card 2C1 of {where}")
        units = card.line[60:74].ljust(14)
        names = ("altitude", "pressure", "temperature", *GASES[:3])
        cells = {
            name: card.cell(start, start + 10, unit)
            for name, start, unit in zip(names, range(0, 60, 10), " " + units[:5], strict=True)
        }
        minor_gases = list(zip(GASES[3:], units[5:], strict=True))
        cells |= {
            gas: Cell(0.0, unit.strip(), card.number, 66 + index) for index, (gas, unit) in enumerate(minor_gases)
        }
        if minor == 1:
            cells |= _wrapped(deck, f"card 2C2 of {where}", minor_gases)
            if heavy_amounts == 2:
                unit = card.line[75:76]
                cells |= _wrapped(deck, f"card 2C2X of {where}", [(gas, unit) for gas in HEAVY_GASES])
        if aerosol in (1, 2):
            deck.next(f"card 2C3 of {where}")
        yield cells


def _wrapped(deck: _Deck, name: str, gases: Sequence[tuple[str, str]]) -> dict[str, Cell]:
    """Amounts of gases in two lines, eight in the first."""
    cells = {}
    card = deck.next(name)
    for index, (gas, unit) in enumerate(gases):
        if index == 8:
            card = deck.next(f"the second line of {name}")
        start = 10 * (index % 8)
        cells[gas] = card.cell(start, start + 10, unit)
    return {gas: cell for gas, cell in cells.items() if gas}
