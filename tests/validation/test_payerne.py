"""Longwave and sunlight measured at Payerne in June 2016, under its own soundings and ozone.

Logical records 0100, 0300, 1100 and 1200 of the BSRN file (Hegner et al. 1998, WMO/TD-No. 897): minutes, radiosondes
written as of 0 and 12 UTC, ozone columns. The sondes leave an hour before: their first temperature is then that of the
station. A night is clear where longwave is steady and the synop of 0 UTC has neither low nor
medium cloud (record 1000; cirrus of 2/8 in one of the four); an hour of a day where the beam is steady. Optical depth
is not in the file: the direct beam of an hour gives it, and the diffuse light of that hour and the beam of the other
hours are predictions. Run with ``-s`` for the tables.
"""

import gzip
from dataclasses import dataclass

import numpy as np
import pandas as pd
import pvlib
import pytest

from skyshine.mat.atmosphere.gases.absorption import default_water_continuum
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.spectra.fluxes import broadband_fluxes, packaged_points
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.profiles import load_profile
from skyshine.mat.atmosphere.state.sounding import read_sounding
from skyshine.mat.atmosphere.state.state import AtmosphericState

pytestmark = [pytest.mark.validation, pytest.mark.shared_data]

LATITUDE, LONGITUDE, STATION = 46.815, 6.944, 491.0  # degree, m
CO2 = 404.0  # ppm, June 2016 (NOAA, Mauna Loa monthly means: 406.8; global mean 402.2)
USUAL_DEPTH = 0.12  # of aerosol at 0.55 um on nights without a beam; western Switzerland in summer
NIGHTS = (6, 10, 23, 28)  # of June, whose sondes left at 23 UTC before; half an hour before and after
CONTINUA = {"mt_ckd_4.3_closure": (-1.1, 3.0), "mt_ckd_4.3": (-3.0, 5.0), "mt_ckd_2.4": (-0.5, 3.0)}
DAYS, HOURS = (22, 23, 24), range(8, 16)  # of June, UTC
STEADY = 0.01  # of the beam of the minutes of an hour about a straight line, largest
REFERENCE_HOUR = 12  # whose beam predicts the beam of the other hours
DEPTHS = np.array([0.0, 0.1, 0.3])  # logarithms of the light are parabolas between
SUNLIGHT = 0.02
MINUTES = 30 * 1440


@dataclass
class Record:
    """Minutes of the month by name, W m^-2 and SI; sondes (n, 8) as written, ozone (n, 3)."""

    minutes: dict
    sondes: np.ndarray
    ozone: np.ndarray

    def hour(self, name, day, hour):
        """Mean of an hour of a day of June, UTC."""
        start = (day - 1) * 1440 + hour * 60
        return float(np.nanmean(self.minutes[name][start : start + 60]))


@pytest.fixture(scope="module")
def record(shared_data):
    blocks, block = {}, []
    with gzip.open(shared_data / "heat" / "bsrn" / "bsrn-pay0616.dat.gz", "rt", errors="replace") as lines:
        for line in lines:
            if line.startswith("*"):
                block = blocks.setdefault(line[2:6], [])
            else:
                block.append(line.split())
    minutes = {
        name: np.full(MINUTES, np.nan) for name in ("global", "direct", "diffuse", "longwave", "temperature", "up")
    }

    def put(name, place, text):
        if float(text) != -999:
            minutes[name][place] = float(text)

    for first, second in zip(blocks["0100"][::2], blocks["0100"][1::2], strict=True):
        place = (int(first[0]) - 1) * 1440 + int(first[1])
        put("global", place, first[2])
        put("direct", place, first[6])
        put("diffuse", place, second[0])
        put("longwave", place, second[4])
        put("temperature", place, second[8])
    for cells in blocks["0300"]:
        put("up", (int(cells[0]) - 1) * 1440 + int(cells[1]), cells[2])
    sondes = np.array([cells[:8] for cells in blocks["1100"]], float)
    return Record(minutes, sondes, np.array(blocks["1200"], float))


def sounding(record, day, minute):
    """A sonde as the text of a sounding: every hundred metres, below the height where humidity is missing.

    Pressure is written in whole hPa, so it follows from heights and temperatures and the first of them (hydrostatic).
    """
    levels = record.sondes[(record.sondes[:, 0] == day) & (record.sondes[:, 1] == minute)]
    levels = levels[: np.flatnonzero(levels[:, 6] < -900)[0]]
    kept = [0]
    for place in range(1, len(levels)):
        if levels[place, 4] >= levels[kept[-1], 4] + (20 if levels[place, 4] < 700 else 100):
            kept.append(place)
    pressure, height, air, dew = levels[kept, 3:7].T
    vapour = 6.112 * np.exp(17.62 * dew / (243.12 + dew))  # hPa, over water (WMO No. 8, annex 4.B)
    pressure = pressure.copy()
    for place in range(1, height.size):
        virtual = (air + 273.15) / (1 - 0.378 * vapour / pressure)
        mean = 0.5 * (virtual[place] + virtual[place - 1])
        pressure[place] = pressure[place - 1] * np.exp(-9.807 / 287.05 * (height[place] - height[place - 1]) / mean)
    rows = [f"{h:.1f},{p:.4f},{t:.2f},{d:.2f}" for h, p, t, d in zip(height, pressure, air, dew, strict=True)]
    return "\n".join(["altitude[m],pressure[hPa],temperature[C],dew_point[C]", *rows]) + "\n"


def state_of(record, day, minute, depth):
    """The air of a sonde with the ozone of its day or of the days next to it, and rural aerosol of an optical depth."""
    near = record.ozone[np.abs(record.ozone[:, 0] - day) <= 1]
    gases = GasAmounts(ppm={"CO2": CO2}, ozone_column=float(near[:, 2].mean()) if near.size else None)
    profile = read_sounding(sounding(record, day, minute), "payerne.csv", load_profile("midlatitude_summer"))
    return AtmosphericState.from_profile(
        profile, surface_altitude=STATION, gas_amounts=gases, aerosol=Aerosol("rural", optical_depth=depth)
    )


def test_sondes_leave_an_hour_before_their_time(record):
    """First temperature of the sondes of the nights less the station's, rms [K], by minutes before their time."""
    rms = {}
    for before in (0, 60):
        difference = []
        for day in range(2, 31):
            sonde = record.sondes[(record.sondes[:, 0] == day) & (record.sondes[:, 1] == 0)]
            if len(sonde):
                difference.append(sonde[0, 5] - record.minutes["temperature"][(day - 1) * 1440 - before])
        rms[before] = float(np.sqrt(np.nanmean(np.square(difference))))
    print(f"\nfirst temperature of the sondes less the station's, rms K by minutes before: {rms}")
    assert rms[60] < 0.4 < rms[0]


def test_longwave_of_clear_nights(record, quoted):
    """Pyrgeometers of the network are good to 2 to 4 W m-2 on a scale that may be low by some in humid air."""
    errors = {name: [] for name in CONTINUA}
    print(f"\nnight before June   measured   computed less measured, W m-2: {', '.join(CONTINUA)}")
    for day in NIGHTS:
        start = (day - 1) * 1440 - 90
        measured = record.minutes["longwave"][start : start + 60]
        assert np.nanstd(measured) < 1.5
        state = state_of(record, day, 0, USUAL_DEPTH)
        for name in CONTINUA:
            light = broadband_fluxes(state, [STATION], [-30.0], 0.2, points=packaged_points(name))
            errors[name].append(light.longwave_down[0] - np.nanmean(measured))
        print(
            f"{day:17d} {np.nanmean(measured):10.1f} {'   '.join(f'{values[-1]:+.1f}' for values in errors.values())}"
        )
    for name, (mean, largest) in CONTINUA.items():
        for word, value in zip(("mean", "low", "high"), (np.mean, np.min, np.max), strict=True):
            quoted(f"air.payerne.{name.replace('.', '_')}.{word}", f"{value(errors[name]):.1f}", "W m-2")
        assert np.mean(errors[name]) == pytest.approx(mean, abs=0.7) and np.abs(errors[name]).max() < largest, name
    assert np.mean(errors[default_water_continuum()]) > -2.0


def steady(record, day, hour):
    """Whether the beam of an hour is that of a clear sky: a straight line of minutes."""
    start = (day - 1) * 1440 + hour * 60
    beam = record.minutes["direct"][start : start + 60]
    line = np.polyval(np.polyfit(np.arange(60), beam, 1), np.arange(60)) if np.all(np.isfinite(beam)) else np.nan
    return bool(np.all(np.abs(beam - line) < STEADY * np.mean(beam)))


def sunlight(record, day, hours, albedo):
    """Direct normal, direct and diffuse on the level for each of `DEPTHS` and hours: means of an hour from five minutes
    of it.
    """
    times = pd.to_datetime([f"2016-06-{day:02d}T{h:02d}:{m:02d}:30Z" for h in hours for m in range(6, 60, 12)])
    elevation = pvlib.solarposition.get_solarposition(times, LATITUDE, LONGITUDE, STATION)["elevation"].to_numpy()
    distance = float(np.mean(pvlib.solarposition.nrel_earthsun_distance(times)))
    shape, parts = (len(hours), 5), []
    for depth in DEPTHS:
        light = broadband_fluxes(state_of(record, day, 720, depth), [STATION], elevation, albedo, sun_distance=distance)
        direct = light.direct_normal[0]
        level = direct * np.sin(np.radians(elevation))
        parts.append([part.reshape(shape).mean(axis=1) for part in (direct, level, light.diffuse[0])])
    return np.array(parts).transpose(1, 2, 0), np.sin(np.radians(elevation)).reshape(shape).mean(axis=1)


@pytest.mark.parametrize("day", DAYS)
def test_sunlight_of_clear_days_by_measured_optical_depth(record, day):
    hours = [hour for hour in HOURS if steady(record, day, hour)]
    assert len(hours) >= 4 and REFERENCE_HOUR in hours
    albedo = record.hour("up", day, REFERENCE_HOUR) / record.hour("global", day, REFERENCE_HOUR)
    (direct, level, diffuse), sine = sunlight(record, day, hours, albedo)
    truth = {name: np.array([record.hour(name, day, h) for h in hours]) for name in ("direct", "diffuse", "global")}
    # The reference of BSRN for the global irradiance is the sum of its parts (Ohmura et al. 1998, Bull. Am. Meteorol.
    # Soc. 79, 2115); the pyranometer that measures it at once is off by up to 2 % with a low Sun.
    parts = truth["direct"] * sine + truth["diffuse"]
    fine = np.linspace(0, DEPTHS[-1], 3001)

    def at(light, depths):
        fits = [np.polyfit(DEPTHS, np.log(row), 2) for row in light]
        return np.array([np.exp(np.polyval(fit, depth)) for fit, depth in zip(fits, depths, strict=True)])

    beams = np.array([at(direct, [depth] * len(hours)) for depth in fine[::10]])
    depth = np.array([np.interp(-t, -beam, fine[::10]) for t, beam in zip(truth["direct"], beams.T, strict=True)])
    reference = depth[hours.index(REFERENCE_HOUR)]
    beam = at(direct, [reference] * len(hours)) / truth["direct"] - 1
    whole = (at(level, depth) + at(diffuse, depth)) / parts - 1
    print(f"\nJune {day}, albedo {albedo:.3f}; differences in %; W m-2")
    print("hour  optical depth  sum of parts  diffuse  direct by the depth of the reference hour  pyranometer")
    for k, hour in enumerate(hours):
        print(
            f"{hour:4d} {depth[k]:10.3f} {parts[k]:9.0f} {100 * whole[k]:+6.1f}"
            f" {truth['diffuse'][k]:9.0f} {100 * (at(diffuse, depth)[k] / truth['diffuse'][k] - 1):+6.1f}"
            f" {truth['direct'][k]:9.0f} {100 * beam[k]:+6.1f} {100 * (truth['global'][k] / parts[k] - 1):+16.1f}"
        )
    assert np.all(depth > 0)  # 0: the computed beam of clean air is too weak
    assert np.abs(whole).max() < SUNLIGHT
