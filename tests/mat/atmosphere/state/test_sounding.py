"""Soundings: units, round trips of the standard profiles, inversions, and what is refused."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.soundings.units import UNITS
from skyshine.mat.atmosphere.state.gas_amounts import DOBSON_UNIT, GasAmounts
from skyshine.mat.atmosphere.state.humidity import mole_fraction
from skyshine.mat.atmosphere.state.profiles import GASES, PROFILES, load_profile
from skyshine.mat.atmosphere.state.sounding import read_sounding
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.errors import InputError

STANDARD = load_profile("us_standard")
# Three levels of a winter night over low ground.
NIGHT = """\
# station 10548
altitude[m],pressure[hPa],temperature[C],relative_humidity[%]
450,965.0,-12.0,90
600,946.5,-4.0,60
1500,844.5,-6.5,40
3000,694.9,-14.0,30
"""


def read(text):
    return read_sounding(text, "night.csv", STANDARD)


def test_the_named_gases_are_those_of_every_profile():
    assert all(set(load_profile(name).mole_fraction) == set(GASES) for name in PROFILES)


def test_a_standard_profile_written_as_a_sounding_is_itself():
    profile = load_profile("tropical")
    low = profile.altitude <= 30e3
    rows = np.column_stack([profile.altitude / 1e3, profile.pressure / 1e2, profile.temperature])[low]
    rows = np.column_stack([rows, profile.mole_fraction["H2O"][low] * 1e6, profile.mole_fraction["O3"][low] * 1e9])
    lines = "\n".join(",".join(f"{x:.12g}" for x in row) for row in rows)
    sounding = read_sounding(
        f"altitude[km],pressure[hPa],temperature[K],h2o[ppmv],O3[ppbv]\n{lines}\n", "t.csv", profile
    )
    ours, own = (AtmosphericState.from_profile(p) for p in (sounding, profile))
    assert ours.altitude == pytest.approx(own.altitude)
    assert ours.temperature == pytest.approx(own.temperature, abs=1e-6)
    assert ours.pressure == pytest.approx(own.pressure, rel=1e-9)
    for gas in ("H2O", "O3", "CH4"):
        assert ours.mole_fraction[gas][:20] == pytest.approx(own.mole_fraction[gas][:20], rel=2e-2)
    assert ours.precipitable_water(0.0) == pytest.approx(own.precipitable_water(0.0), rel=1e-3)
    assert ours.ozone_column(0.0) == pytest.approx(own.ozone_column(0.0), rel=1e-3)


# 20 C at 1000 hPa and 50 %: es = 2339 Pa (CRC Handbook), so e = 1169.5 Pa; w = 0.62198 e / (p - e), dew point 9.27 C.
@pytest.mark.parametrize(
    ("kind", "value"),
    [
        ("relative_humidity", 0.5),
        ("vapour_pressure", 1169.5),
        ("dew_point", 273.15 + 9.27),
        ("mixing_ratio", 0.62198 * 1169.5 / (1e5 - 1169.5)),
        ("specific_humidity", 0.62198 * 1169.5 / (1e5 - 0.37802 * 1169.5)),
        ("absolute_humidity", 1169.5 / (461.52 * 293.15)),
        ("h2o", 0.011695),
    ],
)
def test_measures_of_humidity_agree(kind, value):
    assert mole_fraction(kind, value, 1e5, 293.15) == pytest.approx(0.011695, rel=2e-3)


@pytest.mark.parametrize(
    "head",
    [
        "height[ft],pressure[inHg],temperature[F],relative_humidity[1]",
        "altitude[km],pressure[Pa],temperature[K],relative_humidity[percent]",
    ],
)
def test_units(head):
    factors = {"ft": 1 / 0.3048, "inHg": 1 / 33.86389, "km": 1e-3, "Pa": 100.0, "1": 0.01, "percent": 1.0}
    units = [part.split("[")[1][:-1] for part in head.split(",")]
    lines = [head]
    for line in NIGHT.splitlines()[2:]:
        z, p, t, h = (float(x) for x in line.split(","))
        t = t * 1.8 + 32 if units[2] == "F" else t + 273.15
        lines.append(
            ",".join(f"{x:.9g}" for x in (z * factors[units[0]], p * factors[units[1]], t, h * factors[units[3]]))
        )
    ours, own = read("\n".join(lines)), read(NIGHT)
    assert ours.altitude == pytest.approx(own.altitude) and ours.pressure == pytest.approx(own.pressure, rel=1e-6)
    assert ours.temperature == pytest.approx(own.temperature, abs=1e-6)
    assert ours.mole_fraction["H2O"] == pytest.approx(own.mole_fraction["H2O"], rel=1e-5)


# The same amount in every unit: a kilometre, an atmosphere, one in a thousand.
_ONE_ATMOSPHERE = {"Pa": 101325.0, "hPa": 1013.25, "mbar": 1013.25, "mb": 1013.25, "kPa": 101.325, "bar": 1.01325}
_ONE_ATMOSPHERE |= {"atm": 1.0, "mmHg": 760.0, "Torr": 760.0, "inHg": 29.92126}
_ONE_IN_A_THOUSAND = {"kg/kg": 1e-3, "g/kg": 1.0, "1": 1e-3}
SAME_AMOUNT = {
    "altitude": {"m": 1000.0, "km": 1.0, "ft": 3280.8399, "kft": 3.2808399},
    "pressure": _ONE_ATMOSPHERE,
    "relative_humidity": {"1": 1e-3, "%": 0.1, "percent": 0.1},
    "mixing_ratio": _ONE_IN_A_THOUSAND,
    "specific_humidity": _ONE_IN_A_THOUSAND,
    "vapour_pressure": _ONE_ATMOSPHERE,
    "absolute_humidity": {"kg/m3": 1e-3, "g/m3": 1.0},
    "h2o": {"1": 1e-3, "ppmv": 1e3, "ppm": 1e3, "ppbv": 1e6, "ppb": 1e6, "pptv": 1e9, "ppt": 1e9},
}
# A dry level of NIGHT in the first unit of each measure of humidity.
DRY = {"relative_humidity": 0.3, "dew_point": 245.0, "mixing_ratio": 5e-4, "specific_humidity": 5e-4}
DRY |= {"vapour_pressure": 60.0, "absolute_humidity": 5e-4, "h2o": 6e-4}


def _in_unit(name, unit, value):
    """An amount [SI] in a unit: by the freezing and the boiling point of water for temperatures."""
    if name in ("temperature", "dew_point"):
        freezing, boiling = {"K": (273.15, 373.15), "F": (32.0, 212.0)}.get(unit, (0.0, 100.0))
        return freezing + (boiling - freezing) * (value - 273.15) / 100
    same = SAME_AMOUNT[name]
    return value * same[unit] / next(iter(same.values()))


@pytest.mark.parametrize(("name", "unit"), [(name, unit) for name, units in UNITS.items() for unit in units])
def test_each_unit_is_converted(name, unit):
    humidity = name if name in DRY else "relative_humidity"
    columns = {"altitude": "m", "pressure": "Pa", "temperature": "K"}
    columns[humidity] = "K" if humidity == "dew_point" else next(iter(SAME_AMOUNT[humidity]))

    def written(units):
        rows = [",".join(f"{column}[{units[column]}]" for column in columns)]
        for line in NIGHT.splitlines()[2:]:
            z, p, t, _ = (float(x) for x in line.split(","))
            values = zip(columns, (z, 100 * p, t + 273.15, DRY[humidity]), strict=True)
            rows.append(",".join(f"{_in_unit(column, units[column], value):.12g}" for column, value in values))
        return read("\n".join(rows))

    ours, own = written(columns | {name: unit}), written(columns)
    for part in ("altitude", "pressure", "temperature"):
        np.testing.assert_allclose(getattr(ours, part), getattr(own, part), rtol=1e-6)
    np.testing.assert_allclose(ours.mole_fraction["H2O"], own.mole_fraction["H2O"], rtol=2e-5)


def test_an_inversion_thinner_than_the_regular_levels_is_kept():
    state = AtmosphericState.from_profile(read(NIGHT), surface_altitude=450.0)
    for altitude, celsius in ((450, -12.0), (600, -4.0), (1500, -6.5)):
        assert state.temperature_at(altitude) == pytest.approx(celsius + 273.15, abs=0.5)
    assert np.all(np.diff(state.pressure) < 0) and np.all(np.diff(state.altitude) > 0)
    assert state.relative_humidity[0] == pytest.approx(90.0, abs=0.5)
    # Air of the standard profile far above, no step in temperature on the way there.
    assert state.temperature_at(40e3) == pytest.approx(
        np.interp(40e3, STANDARD.altitude, STANDARD.temperature), abs=0.5
    )
    assert (
        np.max(np.abs(np.diff(state.temperature) / np.diff(state.altitude))) < 0.06
    )  # K/m: that of the inversion itself


def test_the_ground_below_a_sounding_is_continued_a_little_only():
    low = AtmosphericState.from_profile(read(NIGHT), surface_altitude=0.0)
    assert low.temperature[0] == pytest.approx(261.15)
    with pytest.raises(InputError, match="begin the profile lower"):
        AtmosphericState.from_profile(read(NIGHT.replace("450,965.0", "550,952.7")), surface_altitude=-470.0)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "600,946.5",
            "450,946.5",
            r"night.csv:4:1: found the same altitude again, 450 m after 450 m; allowed: altitudes that increase",
        ),
        ("1500,844.5", "500,844.5", r"night.csv:5:1: found a lower altitude, 500 m after 600 m"),
        ("844.5", "946.5", r"night.csv:5:6: found 94650 Pa above 94650 Pa; allowed: pressure that falls"),
        ("-6.5,40", "-6.5,130", r"night.csv:5:17: found 130, which is 130 % relative humidity at 266\.6 K"),
        ("-14.0", "250", r"night.csv:6:12: found 250, which is 523\.1 K; allowed: 140 to 335 K"),
        ("-14.0", "nan", r"night.csv:6:12: temperature: found 'nan'; allowed: a finite number"),
        ("-14.0,30", "-14.0", r"night.csv:6:1: found 3 cells; allowed: 4"),
        ("temperature[C]", "temperature", r"night.csv:2:27: found no unit of temperature; allowed: K, C"),
        ("altitude[m]", "altitude[km]", r"night.csv:3:1: found 450, which is 4.5e\+05 m; allowed"),
        (
            "altitude[m]",
            "altitude[ft]",
            r"night.csv:5:6: found 84450 Pa where altitudes and temperatures .* look at the units",
        ),
        ("pressure[hPa]", "pressure[furlong]", r"night.csv:2:13: found the unit 'furlong' of pressure; allowed: Pa"),
        (
            "relative_humidity[%]",
            "O3[ppbv]",
            r"night.csv:2:1: found no humidity; allowed: one of relative_humidity, dew_point",
        ),
        (
            "temperature[C]",
            "temprature[C]",
            r"night.csv:2:27: found the column 'temprature'; did you mean 'temperature'",
        ),
        ("temperature[C]", "altitude[km]", r"night.csv:2:27: found the column 'altitude' twice"),
        (
            "altitude[m],pressure[hPa]",
            "altitude[m],O3[ppm]",
            r"night.csv:2:1: the column 'pressure' is missing; add it",
        ),
    ],
)
def test_bad_soundings_say_where(old, new, message):
    assert old in NIGHT
    with pytest.raises(InputError, match=message):
        read(NIGHT.replace(old, new, 1))


def test_a_sounding_needs_rows():
    with pytest.raises(InputError, match="found 1 rows of numbers; allowed: 2"):
        read("\n".join(NIGHT.splitlines()[:3]))


def test_gas_amounts():
    from_profile = AtmosphericState.from_profile
    plain = from_profile("midlatitude_summer")
    rich = from_profile("midlatitude_summer", gas_amounts=GasAmounts(ppm={"CH4": 1.9}, scale={"O3": 1.2, "H2O": 0.5}))
    assert rich.mole_fraction["O3"] == pytest.approx(1.2 * plain.mole_fraction["O3"])
    assert rich.precipitable_water(0.0) == pytest.approx(0.5 * plain.precipitable_water(0.0))
    assert rich.mole_fraction["CH4"][0] == pytest.approx(1.9e-6)
    exact = from_profile("midlatitude_summer", gas_amounts=GasAmounts(water_column=25.0, ozone_column=300.0))
    assert exact.precipitable_water(0.0) == pytest.approx(25.0, rel=1e-9)
    density = exact.number_density * exact.mole_fraction["O3"]
    assert exact._column(density, 0.0) / DOBSON_UNIT == pytest.approx(300.0, rel=1e-9)
    for gas_amounts, message in (
        (GasAmounts(scale={"O4": 2.0}), "no gas 'O4' in this profile; did you mean 'O3'"),
        (GasAmounts(ppm={"CFC-11": -1.0}), "at least 0"),
        (GasAmounts(ppm={"CH4": 2.0}, scale={"CH4": 2.0}), "both a scale and an amount"),
        (GasAmounts(water_column=500.0), "more than saturated air of this profile"),
        (GasAmounts(ozone_column=float("nan")), "finite"),
    ):
        with pytest.raises(InputError, match=message):
            from_profile("midlatitude_summer", gas_amounts=gas_amounts)


def test_saturated_hot_air():
    """Fog in the heat: 100 % at 45 C has 64.8 g m^-3 (Smithsonian Meteorological Tables: 65.3 g m^-3)."""
    text = "altitude[m],pressure[hPa],temperature[C],relative_humidity[%]\n0,1000,45,100\n1000,896.5,38,100\n"
    state = AtmosphericState.from_profile(read_sounding(text, "hot.csv", load_profile("tropical")))
    vapour = state.number_density[0] * state.mole_fraction["H2O"][0] * 18.015e-3 / 6.02214e23
    assert vapour == pytest.approx(0.0653, rel=0.01)
    assert state.relative_humidity[0] == pytest.approx(100.0)
    assert np.all(state.mole_fraction["H2O"] * state.pressure <= saturation_pressure(state.temperature) * (1 + 1e-9))
