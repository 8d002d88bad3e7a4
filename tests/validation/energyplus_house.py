"""A house in EnergyPlus: flat roof, roof of 30 degrees, and four walls, on days that repeat until they are periodic."""

import sqlite3
import tempfile
from datetime import date
from pathlib import Path

import numpy as np

from skyshine.mat.bench import energyplus

STEPS = 6  # an hour
# Thickness m, conductivity, density, heat capacity: dense concrete on insulation.
LAYERS = ((0.1, 1.4, 2100.0, 880.0), (0.15, 0.035, 30.0, 1400.0))
SOLAR_ABSORPTANCE, THERMAL_EMISSIVITY, GROUND_ALBEDO = 0.7, 0.9, 0.2
ROUGHNESS_LENGTH = 1e-3  # of concrete in the library: multiplier 1.52, which EnergyPlus calls medium rough
# Slope, azimuth, exposure.
FACES = {
    "roof": (0.0, 180.0, "roof"),
    "tilt": (30.0, 180.0, "roof"),
    "south": (90.0, 180.0, "wall"),
    "east": (90.0, 90.0, "wall"),
    "north": (90.0, 0.0, "wall"),
    "west": (90.0, 270.0, "wall"),
}
# Latitude, longitude, hours ahead of UTC, altitude m, profile of the sky: places whose typical years EnergyPlus brings.
PLACES = {
    "Tampa": (27.97, -82.53, -5, 6, "tropical"),
    "Golden": (39.74, -105.18, -7, 1829, "us_standard"),
    "Chicago": (41.98, -87.92, -6, 201, "us_standard"),
}
DATES = ((3, 21), (6, 21), (9, 21), (12, 21))
_SIDE, _HEIGHT = 10.0, 6.0  # m: those that the law of roofs takes for a house
_NAMES = {
    "outside": "Surface Outside Face Temperature",
    "inside": "Surface Inside Face Temperature",
    "coefficient": "Surface Outside Face Convection Heat Transfer Coefficient",
    "sunlight": "Surface Outside Face Incident Solar Radiation Rate per Area",
}
_HEAD = """
Version, 25.2;
SimulationControl, No, No, No, No, Yes;
Building, house, 0, Country, 0.04, 0.04, MinimalShadowing, 40, 20;
Timestep, {steps};
SurfaceConvectionAlgorithm:Outside, {law};
GlobalGeometryRules, UpperLeftCorner, Counterclockwise, World;
Zone, inside;
Construction, faces, layer 0, layer 1;
Output:SQLite, Simple;
"""


def weather_of(place):
    """The typical year of a place, or None."""
    (found,) = (energyplus.program().parent / "WeatherData").glob(f"*{place}*.epw")
    return found


def simulated(place, law, coefficients=None):
    """Temperatures and fluxes of the faces at the ends of steps.

    Parameters
    ----------
    place : str
    law : str
        Of convection outside, by its name in EnergyPlus.
    coefficients : dict of (date, face) to (24 * STEPS,) ndarray, optional
        Means over the steps [W m^-2 K^-1], in place of the law.

    Returns
    -------
    dict of (date, face) to dict of str to (24 * STEPS,) ndarray
        ``outside`` and ``inside`` [K], ``coefficient`` [W m^-2 K^-1], ``sunlight`` [W m^-2].
    """
    with tempfile.TemporaryDirectory() as work:
        text = _model(law) + (_given(coefficients, Path(work)) if coefficients else "")
        report = energyplus.simulate(text, weather_of(place), Path(work))
        if "Completed Successfully" not in report:
            raise AssertionError(report)
        return _read(Path(work) / "eplusout.sql")


def _model(law):
    text = _HEAD.format(steps=STEPS, law=law)
    for number, (thickness, conductivity, density, capacity) in enumerate(LAYERS):
        text += (
            f"Material, layer {number}, MediumRough, {thickness}, {conductivity}, {density}, {capacity},"
            f" {THERMAL_EMISSIVITY}, {SOLAR_ABSORPTANCE}, {SOLAR_ABSORPTANCE};\n"
        )
    for month, day in DATES:
        text += f"RunPeriod, {month}-{day}, {month}, {day}, , {month}, {day}, , Sunday, No, No, No, No, No;\n"
    ring = [(0.0, 0.0), (_SIDE, 0.0), (_SIDE, _SIDE), (0.0, _SIDE)]
    for number, name in enumerate(("south", "east", "north", "west")):
        one, other = ring[number], ring[(number + 1) % 4]
        text += _face(name, "Wall", [(*one, _HEIGHT), (*one, 0.0), (*other, 0.0), (*other, _HEIGHT)])
    for name, beside, slope in (("roof", 0.0, 0.0), ("tilt", 20.0, 30.0)):
        top = _HEIGHT + _SIDE * np.tan(np.radians(slope))
        corners = [(0.0, _SIDE, top), (0.0, 0.0, _HEIGHT), (_SIDE, 0.0, _HEIGHT), (_SIDE, _SIDE, top)]
        text += _face(name, "Roof", [(x + beside, y, z) for x, y, z in corners])
    return text + "".join(f"Output:Variable, *, {name}, Timestep;\n" for name in _NAMES.values())


def _face(name, kind, corners):
    points = ", ".join(f"{value:.4f}" for corner in corners for value in corner)
    return (
        f"BuildingSurface:Detailed, {name}, {kind}, faces, inside, , Outdoors, , SunExposed, WindExposed, , 4,"
        f" {points};\n"
    )


def _given(coefficients, folder):
    """Schedules of a year of given coefficients; on days that are not run they are 10."""
    text, columns = "", []
    for name in FACES:
        year = np.full((365, 24 * STEPS), 10.0)
        for month, day in DATES:
            number = date(2017, month, day).timetuple().tm_yday - 1
            year[number] = coefficients[(month, day), name]
        columns.append(year.ravel())
        text += (
            f"Schedule:File, of {name}, , {folder / 'given.csv'}, {len(columns)}, 0, 8760, Comma, No, {60 // STEPS};\n"
            f"SurfaceProperty:ConvectionCoefficients, {name}, Outside, Schedule, , of {name};\n"
        )
    np.savetxt(folder / "given.csv", np.transpose(columns), "%.6f", ",")
    return text


def _read(file):
    query = (
        "select EnvironmentName, KeyValue, Name, Value from ReportData join ReportDataDictionary"
        " using (ReportDataDictionaryIndex) join Time using (TimeIndex) join EnvironmentPeriods"
        " using (EnvironmentPeriodIndex) where ifnull(WarmupFlag, 0) = 0 order by TimeIndex"
    )
    short, found = {name: key for key, name in _NAMES.items()}, {}
    database = sqlite3.connect(file)
    try:
        for period, face, name, value in database.execute(query):
            month, day = period.split("-")
            at = found.setdefault(((int(month), int(day)), face.lower()), {})
            at.setdefault(short[name], []).append(value)
    finally:
        database.close()
    return {
        key: {name: np.array(values) + (273.15 if name.endswith("side") else 0.0) for name, values in at.items()}
        for key, at in found.items()
    }
