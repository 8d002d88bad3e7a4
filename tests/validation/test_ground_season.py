"""Deep ground by the season against whole years of weather over endless ground: two TMY3 files that pvlib brings."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pvlib
import pytest

from skyshine.mat.job.ground_files import ground_of_file
from skyshine.mat.job.typical_years import read_year
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.scene.surface import surface_materials
from skyshine.mat.surface.ground_year import YEAR
from skyshine.mat.surface.record import Record, record_forcing
from skyshine.mat.surface.solver import solve_columns
from skyshine.materials.library import load_library

pytestmark = pytest.mark.validation

DATA = Path(pvlib.__file__).parent / "data"
FILES = {"Greensboro": DATA / "723170TYA.CSV", "Sand Point": DATA / "703165TY.csv"}
MATERIALS = ("soil_loam_brown", "concrete", "grass_green")
DAYS = 11  # of weather that a surface is given
QUANTITIES = {
    "air_temperature": ("air_temperature_c", 1.0, ZERO_CELSIUS),
    "relative_humidity": ("relative_humidity_percent", 1.0, 0.0),
    "wind_speed": ("wind_speed_m_s", 1.0, 0.0),
    "pressure": ("pressure_hpa", 100.0, 0.0),
    "cloud_fraction": ("cloud_fraction", 1.0, 0.0),
    "direct": ("direct_normal_w_m2", 1.0, 0.0),
    "diffuse": ("diffuse_w_m2", 1.0, 0.0),
}


def year_of(file):
    """The record of a typical year, its light on level ground by the Sun of the middle of each hour."""
    year = read_year(file, "TMY3")
    rows = range(len(year.readings))
    values = {name: factor * year.values(key, rows) + zero for name, (key, factor, zero) in QUANTITIES.items()}
    hours = np.datetime64("2001-01-01T00:30", "m") + np.arange(len(rows)) * np.timedelta64(60, "m")
    utc = hours - np.timedelta64(round(60 * year.utc_offset_h), "m")
    place = year.station.latitude, year.station.longitude
    elevation = pvlib.solarposition.get_solarposition(utc, *place)["elevation"].to_numpy()
    sine = np.maximum(np.sin(np.radians(elevation)), 0.0)
    values["sw_down"] = values.pop("direct") * sine + values.pop("diffuse")
    return Record.of(3600.0 * np.arange(len(rows)), values, year.station.altitude)


def surface_of(material, record, **ground):
    """Temperatures at half hours [K]."""
    fine = record.refined(2)
    light = fine.values["sw_down"]
    forcing = replace(record_forcing(fine, (0 * light, light, 0 * light), 0.0), **ground)
    ((_, solution),) = solve_columns(material, lambda _: forcing, steps=fine.steps, fine_steps=None, period=fine.period)
    return solution.temperature[0]


@pytest.mark.parametrize("place, gain", [("Greensboro", 0.8), ("Sand Point", 1.3)])
def test_the_season_against_the_mean_air(place, gain, capsys, quoted):
    """Errors of daily means, on a day a month, after ten days of its weather. By the sea of Alaska, where the year is
    even, the mean air is as good.
    """
    record, year = year_of(FILES[place]), ground_of_file(FILES[place], 0.0)
    squares = {"mean air": [], "season": []}
    for material in surface_materials([load_library()[name] for name in MATERIALS]):
        upper, lower = material.thermal.layers
        endless = replace(material.thermal, layers=(upper, replace(lower, thickness=np.inf)))
        truth = surface_of(replace(material, thermal=endless), record)
        for name, found in squares.items():
            errors = []
            for day in range(15, 365, 30):
                rows = slice(24 * (day - DAYS), 24 * day)
                part = replace(record, values={key: values[rows] for key, values in record.values.items()})
                season = {
                    "ground_mean": np.array([[year.mean_c + ZERO_CELSIUS]]),
                    "ground_amplitude": np.array([[year.amplitude_c]]),
                    "ground_day": np.array([[(day - year.coldest_day) % YEAR]]),
                }
                surface = surface_of(material, part, **(season if name == "season" else {}))
                errors.append(float(np.mean(surface[-48:] - truth[48 * (day - 1) : 48 * day])))
            rms, most = float(np.sqrt(np.mean(np.square(errors)))), max(map(abs, errors))
            found.append(rms**2)
            if name == "season":
                quoted(f"surface.year.{place}.{material.name}".replace(" ", "_"), f"{rms:.2f}", "K")
            with capsys.disabled():
                print(f"\n{place}, {material.name}, {name}: rms {rms:.2f}, most {most:.2f} K", end="")
            assert most < (1.0 if name == "season" else 2.0)
    mean, season = (float(np.sqrt(np.mean(values))) for values in squares.values())
    assert season < gain * mean and season < 0.5
