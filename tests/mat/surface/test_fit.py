"""Fits to records that the solver made: parameters come back, held-out days stay unseen, blanks do not count."""

from dataclasses import replace

import numpy as np
import planted_skin
import pytest
from scipy.constants import Stefan_Boltzmann

from skyshine.mat.surface.fit import fit_record
from skyshine.mat.surface.measured_skin import MeasuredRecord, read_measured
from skyshine.schemas.errors import InputError

TRUE = {"albedo": 0.45, "conductivity": 0.7}
RECORD = planted_skin.weather(3)


@pytest.fixture(scope="module")
def soil():
    return planted_skin.planted("soil_loam_brown", TRUE, RECORD)


def test_planted_parameters_come_back(soil):
    fit = fit_record(*soil, list(TRUE), held_out=0.5)
    assert fit.values["albedo"] == pytest.approx(TRUE["albedo"], abs=0.003)
    assert fit.values["conductivity"] == pytest.approx(TRUE["conductivity"], rel=0.02)
    errors = {(each.part, each.prediction): each.rms for each in fit.errors if each.hours == "all"}
    assert errors["held out", "fit"] < 0.03 < 1.0 < errors["held out", "material as it was"]
    assert not fit.notes


def test_parts_are_whole_days_after_the_spin_up(soil):
    material, measured = soil
    days = np.arange(72) // 24
    fit = fit_record(material, measured, ["albedo"], held_out=0.5)
    assert [set(days[part]) for part in (fit.fitted, fit.held_out)] == [{1}, {2}]
    fit = fit_record(material, measured, ["albedo"], held_out="alternate", spin_up=0.0)
    assert [set(days[part]) for part in (fit.fitted, fit.held_out)] == [{0, 2}, {1}]
    fit = fit_record(material, measured, ["albedo"], held_out=0, spin_up=1.5)
    assert np.flatnonzero(fit.fitted)[[0, -1]].tolist() == [36, 71] and not fit.held_out.any()


def test_held_out_days_and_blanks_do_not_change_the_fit(soil):
    material, measured = soil
    skin = measured.skin.copy()
    skin[48:] += 5.0
    skin[:24] = 0.0
    whole = fit_record(material, measured, ["albedo"], held_out=0.5)
    assert fit_record(material, replace(measured, skin=skin), ["albedo"], held_out=0.5).values == whole.values
    skin[30:34] = np.nan
    fit = fit_record(material, replace(measured, skin=skin), ["albedo"], held_out=0.5)
    assert fit.fitted.sum() == 20 and fit.values["albedo"] == pytest.approx(whole.values["albedo"], abs=0.05)


def test_longwave_gives_the_temperature_with_the_emissivity():
    """The reflected part of the sky's longwave is taken off; emissivity and albedo come back together."""
    values = {"emissivity": 0.88, "albedo": 0.3}
    material, measured = planted_skin.planted("soil_loam_brown", values, RECORD)
    longwave = 0.88 * Stefan_Boltzmann * measured.skin**4 + 0.12 * RECORD.values["lw_down"]
    radiometer = MeasuredRecord(RECORD, longwave, True)
    assert radiometer.temperature(0.88)[0] == pytest.approx(measured.skin, abs=1e-9)
    slope = (radiometer.temperature(0.8801)[0] - radiometer.temperature(0.8799)[0]) / 2e-4
    assert radiometer.temperature(0.88)[1] == pytest.approx(slope, rel=1e-5)
    fit = fit_record(material, radiometer, list(values), held_out=0)
    assert list(fit.values.values()) == pytest.approx([0.88, 0.3], abs=0.01)


def test_a_dry_material_may_become_wet():
    material, measured = planted_skin.planted("concrete", {"wetness": 0.3}, RECORD)
    assert material.surface.wetness == 0.0
    fit = fit_record(material, measured, ["wetness"], held_out=0)
    assert fit.values["wetness"] == pytest.approx(0.3, abs=0.01)


def test_a_thick_slab_gives_the_product_only():
    """Of a slab without end the surface shows sqrt(k rho c) alone: Carslaw and Jaeger (1959), section 2.6."""
    material, measured = planted_skin.planted("sand_wet", {}, RECORD)
    noise = 0.2 * planted_skin.autoregression(72, 0.5, 1)
    layers = tuple(replace(layer, thickness=3.0) for layer in material.thermal.layers)
    thick = replace(material, thermal=replace(material.thermal, layers=layers))
    fit = fit_record(
        thick, replace(measured, skin=measured.skin + noise), ["conductivity", "heat_capacity"], held_out=0
    )
    assert fit.uncertainty.correlation[0, 1] < -0.95
    assert any("conductivity and heat_capacity cannot be distinguished" in note for note in fit.notes)
    first = material.thermal.layers[0]
    product = fit.values["conductivity"] * fit.values["heat_capacity"]
    assert product == pytest.approx(first.conductivity * first.heat_capacity, rel=0.15)


@pytest.mark.parametrize(
    "change, settings, message",
    [
        ({}, {"held_out": 1.0}, "found held_out 1"),
        ({}, {"held_out": "weekends"}, "found held_out weekends; allowed: 0 to less than 1, or 'alternate'"),
        ({}, {"spin_up": 3.0}, "found a spin-up of 3 days"),
        ({"skin": np.full(72, np.nan)}, {}, "found 0 measured skin temperatures in the days of the fit; allowed: at"),
        ({"skin": np.where(np.arange(72) < 48, 290.0, np.nan)}, {}, "found no measured skin temperature in the days"),
        ({"record": planted_skin.weather(1.5), "skin": np.zeros(36)}, {}, "found a record of 1.5 days; allowed: at"),
    ],
)
def test_what_cannot_be_fitted_is_refused(soil, change, settings, message):
    material, measured = soil
    with pytest.raises(InputError, match=message):
        fit_record(material, replace(measured, **change), ["albedo"], **settings)


def test_a_parameter_that_moves_no_temperature_is_refused():
    """A back behind two metres of insulation."""
    material, measured = planted_skin.planted("concrete", {}, RECORD)
    first, second = material.thermal.layers
    wool = replace(second, thickness=2.0, conductivity=0.01)
    hidden = replace(material, thermal=replace(material.thermal, layers=(first, wool)))
    with pytest.raises(InputError, match="back_temperature has no effect on material 'concrete' under this record"):
        fit_record(hidden, measured, ["back_temperature"])


HEADER = "time,sw_down,lw_down,air_temperature[C],relative_humidity,wind_speed,pressure[hPa]"


def rows(count, minutes=30):
    times = np.datetime64("2026-06-01T00:00") + np.arange(count) * np.timedelta64(minutes, "m")
    return [f"{time}Z,{index},320,15,50,2,980" for index, time in enumerate(times)]


def write(folder, lines):
    file = folder / "record.csv"
    file.write_text("\n".join(lines) + "\n")
    return file


def test_readings_are_averaged_to_half_hours_where_half_are_there(tmp_path):
    skins = ["15", "17", "16", "", "", "20", "", "30", "32", "1", "1", "1", "5"]
    lines = [f"{row},{skin}" for row, skin in zip(rows(13, minutes=10), skins, strict=True)]
    measured = read_measured(write(tmp_path, [f"{HEADER},surface_temperature[C]", *lines]))
    assert measured.record.step == 600.0 and np.isnan(measured.skin[[3, 4, 6]]).all()
    mean = measured.averaged()
    assert mean.skin - 273.15 == pytest.approx([16.0, np.nan, 31.0, 1.0], nan_ok=True)
    assert mean.record.values["sw_down"].tolist() == [1.0, 4.0, 7.0, 10.0]
    assert mean.record.step == 1800.0 and str(mean.record.start) == "2026-06-01T00:10:00.000"


def test_missing_rows_have_weather_but_no_skin(tmp_path):
    lines = [f"{row},16" for row in rows(8)]
    del lines[3]
    measured = read_measured(write(tmp_path, [f"{HEADER},surface_temperature[C]", *lines]))
    assert np.flatnonzero(np.isnan(measured.skin)).tolist() == [3]
    assert measured.record.values["sw_down"][3] == 3.0


@pytest.mark.parametrize(
    "header, change, message",
    [
        (HEADER, None, r"record.csv:1:1: the column 'surface_temperature' or 'lw_up' is missing; add it"),
        (f"{HEADER},surface_temperature,lw_up", (0, ",,"), "found the columns surface_temperature and lw_up"),
        (f"{HEADER},lw_up", (4, ",nan"), r"record.csv:6:\d+: lw_up: found 'nan'"),
        (f"{HEADER},surface_temperature", (4, ",15"), r"record.csv:6:\d+: surface_temperature: found '15'"),
        (f"{HEADER},lw_up", (4, "T02:07"), r"record.csv:6:1: time: found a reading 2220 s after the one before"),
    ],
)
def test_records_that_do_not_fit_are_refused_at_their_place(tmp_path, header, change, message):
    lines = rows(8)
    blanks = "," * (header.count(",") - HEADER.count(","))
    lines = [row + blanks for row in lines]
    if change and change[1].startswith("T"):
        lines[change[0]] = lines[change[0]].replace("T02:00", change[1])
    elif change:
        lines[change[0]] = lines[change[0]].removesuffix(blanks) + change[1]
    with pytest.raises(InputError, match=message):
        read_measured(write(tmp_path, [header, *lines]))
