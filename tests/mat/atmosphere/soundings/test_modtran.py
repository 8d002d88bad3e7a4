"""Air of MODTRAN's inputs: cards and JSON give what the same air in CSV does, and what is refused says where."""

import json

import numpy as np
import pytest
from scipy import constants

from skyshine.mat.atmosphere.soundings.files import read_levels
from skyshine.mat.atmosphere.state.gas_amounts import layer_columns
from skyshine.mat.atmosphere.state.profiles import load_profile
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.errors import InputError

# Altitude km, pressure hPa, temperature K, vapour pressure hPa; hydrostatic within 0.2 %.
AIR = [
    (0.010, 1010.0, 293.15, 14.0),
    (0.800, 920.6, 287.35, 11.5),
    (1.500, 846.4, 283.15, 5.2),
    (3.100, 695.2, 274.15, 1.9),
    (5.600, 505.5, 257.15, 0.4),
]
CARD_2 = "    1    0    0    0    0    0    23.000     0.000     0.000     0.000     0.000"
GAS_CONSTANT_OF_VAPOUR = 461.52  # J kg^-1 K^-1


def card_1(model=7, m=(0,) * 6, heavy=0, reads=1):
    return f"TS  {model}    3    1    0" + "".join(f"{n:5d}" for n in (*m, heavy, reads, 0)) + "   0.000   0.00"


def card_1a(co2="360.00000", water="", ozone="", switches=" F F F   F"):
    return f"FFF  8 0.0{co2:>10}{water:>10}{ozone:>10}{switches}"


def water_in(letter, pressure, kelvin, vapour):
    """Amount of water vapour in the units of a letter, by textbook forms."""
    moles = vapour / pressure
    kelvins = np.linspace(220, 300, 801)
    dew = float(np.interp(np.log(100 * vapour), np.log(saturation_pressure(kelvins)), kelvins))
    return {
        "A": 1e6 * moles,
        "B": 100 * vapour / (constants.k * kelvin) * 1e-6,
        "C": 1e3 * 0.62198 * vapour / (pressure - vapour),
        "D": 1e3 * 100 * vapour / (GAS_CONSTANT_OF_VAPOUR * kelvin),
        "E": vapour,
        "F": dew,
        "G": dew - 273.15,
        "H": 100 * 100 * vapour / float(saturation_pressure(kelvin)),
    }[letter]


def deck(water="A", pressure="A", temperature="A", model=7, first=None, extra=(), stated="", co2="360.0"):
    """A tape5 of the air; blanks follow the first three units."""
    lines = [
        first or card_1(model=model),
        card_1a(co2, stated),
        CARD_2,
        f"{len(AIR):5d}{int(bool(extra)):5d}    0own air",
    ]
    for z, p, t, e in AIR:
        of_pressure = {"A": p, "B": p * 100 / constants.atm, "C": p * 100 / constants.torr, " ": p}[pressure]
        of_temperature = {"A": t, "B": t - 273.15, "C": t * 9 / 5 - 459.67, " ": t}[temperature]
        numbers = (of_pressure, of_temperature, water_in(water, p, t, e), 0.0, 0.0)
        lines.append(
            f"{z:10.3f}"
            + "".join(f"{number:10.4G}" if abs(number) >= 1e6 else f"{number:10.5f}"[:10] for number in numbers)
            + pressure
            + temperature
            + water
        )
        lines += extra
    return "\n".join(
        [*lines, "     0.000     0.000    88.000    12.000", "   800.000  1250.000     1.000     2.000", "    0"]
    )


def levels(tmp_path, text):
    file = tmp_path / "tape5"
    file.write_text(text)
    return read_levels(file)


@pytest.mark.parametrize("water", "ABCDEFGH")
def test_units_of_water_vapour_give_the_same_air(tmp_path, water):
    read = levels(tmp_path, deck(water))
    assert read.altitude == pytest.approx([1e3 * z for z, *_ in AIR])
    assert read.pressure == pytest.approx([100 * p for _, p, _, _ in AIR])
    assert read.temperature == pytest.approx([t for _, _, t, _ in AIR])
    assert read.mole_fraction["H2O"] == pytest.approx([e / p for _, p, _, e in AIR], rel=1e-3)


@pytest.mark.parametrize(("pressure", "temperature"), ["BB", "CC", "  ", "AC"])
def test_units_of_pressure_and_temperature_give_the_same_air(tmp_path, pressure, temperature):
    read = levels(tmp_path, deck(pressure=pressure, temperature=temperature))
    assert read.pressure == pytest.approx([100 * p for _, p, _, _ in AIR], rel=1e-5)
    assert read.temperature == pytest.approx([t for _, _, t, _ in AIR], abs=2e-4)


def test_ozone_in_each_unit_gives_the_same_mole_fraction(tmp_path):
    _, p, t, _ = AIR[0]
    molecules = 100 * p / (constants.k * t)  # m^-3
    amounts = {"A": 0.04, "B": 4e-8 * molecules * 1e-6, "C": 1e3 * 4e-8 * 47.997 / 28.9647, "E": 4e-8 * p}
    amounts["D"] = 4e-8 * molecules * 47.997 / constants.N_A
    for unit, amount in amounts.items():
        text = deck().replace(f"{0.0:10.5f}AAA", f"{amount:10.3E}AAA {unit}")
        read = levels(tmp_path, text)
        assert read.mole_fraction["O3"][0] == pytest.approx(4e-8, rel=1e-3), unit


def test_a_model_number_in_place_of_a_unit_takes_that_models_value(tmp_path):
    read = levels(tmp_path, deck().replace("AAA", "AAA 2"))
    model = load_profile("midlatitude_summer")
    at_level = np.exp(np.interp(1e3 * AIR[3][0], model.altitude, np.log(model.mole_fraction["O3"])))
    assert read.mole_fraction["O3"][3] == pytest.approx(at_level)


def test_minor_gases_are_read_in_two_lines_with_their_units(tmp_path):
    cards = ["     0.320     0.150     1.800   2.090E5     0.000     0.000     0.000     0.000", "     0.001"]
    read = levels(tmp_path, deck(extra=cards))
    assert [read.mole_fraction[gas][2] for gas in ("N2O", "CO", "CH4", "O2", "HNO3")] == pytest.approx(
        [0.32e-6, 0.15e-6, 1.8e-6, 0.209, 1e-9]
    )


def test_levels_by_pressure_get_altitudes_by_hydrostatic_balance(tmp_path):
    text = "\n".join(
        line if len(line) < 63 or line[60:63] != "AAA" else "     0.010" + line[10:]
        for line in deck(model=8).splitlines()
    )
    assert levels(tmp_path, text).altitude == pytest.approx([1e3 * z for z, *_ in AIR], rel=5e-3)


@pytest.mark.parametrize(
    ("model", "number", "water", "ozone"),
    [("tropical", 1, 4.114728, None), ("us_standard", 6, 1.416445, 0.000736)],
)
def test_standard_models_have_the_columns_that_modtran_prints(tmp_path, model, number, water, ozone):
    """g/cm2, in the headers of tape7 of MODTRAN 4 (github.com/NelisW/pyradi, pyradi/data)."""
    read = levels(tmp_path, deck(first=card_1(model=number)))
    density = read.pressure / (constants.k * read.temperature) / constants.N_A
    for gas, mass, column in (("H2O", 18.015, water), ("O3", 47.997, ozone)):
        if column is not None:
            found = layer_columns(read.altitude, density * read.mole_fraction[gas]).sum() * mass / 1e4
            assert found == pytest.approx(column, rel=1e-3)


def test_m1_to_m6_replace_parts_of_a_standard_model(tmp_path):
    read = levels(tmp_path, deck(first=card_1(model=6, m=(0, 3, 0, 0, 0, 0), reads=0)))
    assert read.temperature[0] == load_profile("us_standard").temperature[0]
    assert read.mole_fraction["H2O"][0] == pytest.approx(load_profile("midlatitude_winter").mole_fraction["H2O"][0])


@pytest.mark.parametrize(("written", "factor"), [("0.5", 0.5), ("g0.708", 0.5), ("a881.0", 0.5)])
def test_the_column_of_water_is_scaled(tmp_path, written, factor):
    """1.4164 g/cm2 of the US standard model; 1 g/cm2 of vapour is 1244.1 atm cm (22,414 cm3 for 18.015 g)."""
    whole = levels(tmp_path, deck(first=card_1(model=6))).mole_fraction["H2O"]
    half = levels(tmp_path, deck(first=card_1(model=6), stated=written)).mole_fraction["H2O"]
    assert half == pytest.approx(factor * whole, rel=2e-3)


def as_json(model="ATM_USER_ALT_PROFILE", units="UNT_DPPMV", **atmosphere):
    columns = list(zip(*AIR, strict=True))
    water = [1e6 * e / p for _, p, _, e in AIR]
    parts = [
        ("PROF_ALTITUDE", "UNT_KILOMETERS", columns[0]),
        ("PROF_PRESSURE", "UNT_PMILLIBAR", columns[1]),
        ("PROF_TEMPERATURE", "UNT_TKELVIN", columns[2]),
        ("PROF_H2O", units, water),
    ]
    profiles = [{"TYPE": kind, "UNITS": unit, "PROFILE": list(values)} for kind, unit, values in parts]
    air = {"MODEL": model, "CO2MX": 400.0, "PROFILES": profiles, **atmosphere}
    return json.dumps({"MODTRAN": [{"MODTRANINPUT": {"CASE": 0, "ATMOSPHERE": air}}]}, indent="\t")


def test_json_gives_the_same_air_as_cards(tmp_path):
    cards, document = levels(tmp_path, deck("A")), levels(tmp_path, as_json())
    assert document.mole_fraction["H2O"] == pytest.approx(cards.mole_fraction["H2O"], rel=1e-6)
    assert document.temperature == pytest.approx(cards.temperature)
    assert any("CO2MX" in note for note in document.notes)


def test_json_names_standard_models_and_columns(tmp_path):
    read = levels(tmp_path, as_json("ATM_TROPICAL", H2OSTR=2.0, H2OUNIT="G"))
    density = read.pressure / (constants.k * read.temperature) / constants.N_A
    assert layer_columns(read.altitude, density * read.mole_fraction["H2O"]).sum() * 18.015 / 1e4 == pytest.approx(
        2, rel=1e-3
    )


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        (deck(first=card_1(model=0)), ":1:5:", "MODEL 0"),
        (deck(first=card_1(reads=0)), ":1:56:", "levels of an earlier run"),
        (deck(first=card_1(m=(0, 9, 0, 0, 0, 0))), ":1:26:", "M2 9"),
        (deck(co2="abc"), ":2:11:", "'abc' in columns 11 to 20"),
        (deck(stated="x1.0"), ":2:21:", "H2OSTR"),
        (deck().replace("   846.400", "   846.4x0").replace(" 846.40000", " 846.4x000"), ":7:11:", "846.4x"),
        (deck().replace("AAA", "ZAA"), ":5:11:", "the unit 'Z' of pressure"),
        ("\n".join(deck().splitlines()[:6]), ":6:", "ends before card 2C1 of level 3 of 5"),
        (deck().replace("    5    0    0own", "    1    0    0own"), ":4:1:", "1 levels (ML)"),
        (as_json("ATM_TROPICL"), ":7:15:", "ATM_TROPICAL"),
        (as_json(units="UNT_FOO"), ":45:17:", "UNT_FOO"),
        (as_json("ATM_CONSTANT"), ":7:15:", "air of one level"),
        (as_json(PROFILES=[]), ":", "has no PROFILES"),
        ('{"MODTRAN": []}', ":1:", "list of cases"),
        ('{"other": 1}', ":1:", "has no MODTRAN"),
    ],
)
def test_what_cannot_be_read_is_refused_at_its_place(tmp_path, text, place, message):
    with pytest.raises(InputError) as caught:
        levels(tmp_path, text)
    assert message in str(caught.value)
    assert place in str(caught.value)


def test_supersaturated_air_is_refused_at_its_card(tmp_path):
    with pytest.raises(InputError, match=r"tape5:5:31: .*relative humidity"):
        levels(tmp_path, deck("A").replace(f"{1e6 * 14 / 1010:10.5f}"[:10], "  30000.00"))


def test_further_runs_are_said_to_be_left(tmp_path):
    read = levels(tmp_path, deck() + "\n" + deck())
    assert any("1 more run" in note for note in read.notes)
    assert not any("more run" in note for note in levels(tmp_path, deck()).notes)
