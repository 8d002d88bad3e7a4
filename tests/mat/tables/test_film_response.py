"""The film of water on shaded surfaces: its march, what a file holds, and temperatures against whole solutions."""

from dataclasses import fields, replace

import numpy as np
import pytest
from numpy_response import ColumnFilm, ColumnResponse, StoredFilm, StoredResponse

from skyshine.mat.products.shade_error import stored_response
from skyshine.mat.scene.surface import surface_inputs, surface_materials
from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.film import LATENT_HEAT
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.response import response_table
from skyshine.mat.surface.response_nodes import LAG_STARTS, OFFSETS
from skyshine.mat.surface.solver import FINE_STEPS, solve_columns
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.mat.surface.weather import Wetting
from skyshine.mat.tables.axes import AxisRule
from skyshine.mat.tables.film_response import FILM
from skyshine.mat.tables.htt import shade_fields
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Group

SHEET, SNOW = "paint_green_on_metal", "snow_fine"
HOURS = range(24)
JOB = {
    "skyshine": 1,
    "name": "rain",
    "site": {"latitude_deg": 45, "longitude_deg": 5, "date": "2026-06-28", "utc_offset_h": 2},
    "states": [
        {
            "profile": "midlatitude_summer",
            "weather": {
                "wind_speed_m_s": 2.5,
                "relative_humidity_percent": 70,
                "hourly": {
                    "time": [f"{hour:02d}:00" for hour in HOURS],
                    "air_temperature_c": [18 + 7 * round(float(np.cos(np.pi * (hour - 15) / 12)), 3) for hour in HOURS],
                    "rain_mm_h": [4.0 if hour in (12, 13) else 0.0 for hour in HOURS],
                },
            },
        }
    ],
    "bands": [],
    "materials": [SHEET, SNOW],
}
PLACE = np.array([300.0]), np.array([0.0]), np.array([180.0])


class Rain:
    """A shower at noon: inputs, materials, the table of responses as it is computed and as a reader has it."""

    def __init__(self):
        self.inputs = surface_inputs(JOB)[1]
        library = load_library()
        self.materials = surface_materials([library[name] for name in (SHEET, SNOW)], None, Wetting(rain=True))
        self.scene = Scene(*self.inputs, PLACE[0], np.array([0.0, 90.0]), np.zeros(2))
        self.table = response_table(self.materials, self.scene)
        self.library = stored_response(self.table)
        film = self.table.film
        self.response = StoredResponse(
            AxisRule("response_altitude", self.table.altitudes_m / 1e3),
            AxisRule("response_slope", self.table.slopes_deg),
            LAG_STARTS,
            OFFSETS,
            *(getattr(self.table, name) for name in ("kernel", "temperature", "loss_slope", "loss_excess", "melt")),
            StoredFilm(*(getattr(film, field.name) for field in fields(StoredFilm))),
        )

    def whole(self, around=None):
        """Temperatures [K] and absorbed heat of the dry sheet [W m^-2] at 288 times."""
        face = Scene(*self.inputs, *PLACE, around)
        ((_, solution),) = solve_columns(self.materials[0], face.forcing, steps=FINE_STEPS)
        return solution.temperature, Balance(face.forcing(FINE_STEPS), self.materials[0]).absorbed

    def column(self, material=0, slope=0.0):
        return self.response.columns(np.array([material]), np.array([0.3]), np.array([slope]))


@pytest.fixture(scope="module")
def rain():
    return Rain()


@pytest.mark.parametrize("around", [Surroundings(((10.0, 15.0),)), Surroundings(((0.0, 24.0),), 0.5)])
def test_a_sheet_stays_wet_in_the_shade_as_its_whole_solution_does(rain, around):
    (start, lit), (whole, dark), limit = rain.whole(), rain.whole(around), rain.table.highest[:1].astype(float)
    column = rain.column()
    error = start + column.change(dark - lit, start, limit) - whole
    forgotten = start + replace(column, film=None).change(dark - lit, start, limit) - whole
    assert np.abs(error).max() < 2.5 and np.sqrt(np.mean(error**2)) < 0.3
    assert np.abs(forgotten).max() > 3 * np.abs(error).max()
    # The library in C, which readers of files call.
    faces = [np.array([1]), np.array([0.3]), np.zeros(1), np.zeros(1)]
    changed = rain.library.changes(faces, dark - lit, start, limit)
    np.testing.assert_allclose(changed, column.change(dark - lit, start, limit), atol=1e-9)
    still = column.change(0 * lit, start, limit)
    assert np.abs(still).max() < 1e-12


def test_a_whole_film_loses_the_latent_heat_of_its_water_and_dew_stands_in_the_dry_loss(rain):
    """A painted sheet emits nearly as water does; below 0 C ice has another latent heat."""
    film, reference = rain.table.film, rain.table.temperature[0, 0, 0]
    kelvin = reference[:, None] + OFFSETS
    dry_emissivity, wet = rain.materials[0].thermal_emissivity, rain.materials[0].film
    emitted = (wet.thermal_emissivity - dry_emissivity) * 5.670374419e-8 * kelvin**4
    forcing = rain.scene.forcing(FINE_STEPS).columns(np.array([0])).times(np.arange(24) * 12)
    received = (wet.thermal_emissivity - dry_emissivity) * (forcing.longwave_sky + forcing.longwave_ground)
    expected = LATENT_HEAT * np.maximum(film.evaporation[0, 0, 0], 0) + emitted - received.T
    liquid = kelvin > 274
    np.testing.assert_allclose(film.heat_loss[0, 0, 0][liquid], expected[liquid], rtol=2e-3, atol=0.5)
    assert np.all(np.diff(film.evaporation[0, 0, 0], axis=1)[:, 5:] > 0)
    light = film.sunlight[0, 0, 0], film.dry_sunlight[0, 0, 0]
    darker = wet.solar_absorptance / rain.materials[0].solar_absorptance - 1
    np.testing.assert_allclose(light[0], darker * light[1], rtol=1e-5, atol=1e-4)


def test_no_water_stays_on_snow_nor_without_a_column_of_rain(rain):
    assert rain.table.film.capacity[0] > 0 and rain.table.film.capacity[1] == 0
    assert not np.any(rain.table.film.heat_loss[1]) and rain.column(material=1).film is None
    dry = surface_inputs(
        JOB | {"states": [{"profile": "midlatitude_summer", "weather": {"air_temperature_c": [11, 25]}}]}
    )[1]
    library = load_library()
    scene = Scene(*dry, PLACE[0], np.array([0.0]), np.zeros(1))
    table = response_table(surface_materials([library[SHEET]]), scene)
    assert table.film is None
    assert not set(FILM) & set(shade_fields(table, scene)[1])


def film(capacity=0.5, rain=0.0, before=None, count=1):
    table = np.zeros((count, 288, 2))
    row = np.zeros((count, 288))
    return ColumnFilm(table, table, row, row, np.full(count, capacity), row + rain, before)


def test_a_full_film_dries_as_the_closed_form_of_its_share():
    """dw/dt = -E s with w = c s^(3/2) has s = (1 - E t / (3 c))^2, until it is dry at t = 3 c / E."""
    hours, evaporation = np.arange(1, 289) / 12, 0.5 * 3 / (12 * 3600)  # dry after twelve hours
    share, start, end = film(before=np.array([0.5])).sunlit_shares(np.full((1, 288), evaporation))
    np.testing.assert_allclose(share[0], np.maximum(1 - hours / 12, 0) ** 2, atol=0.02)
    assert start == 1 and end < 1e-6


def test_a_film_that_returns_is_the_same_at_both_ends_of_the_day_or_full():
    """Evaporation by day and dew at night: as much as falls is lost, or what does not stay runs off."""
    day = np.where(np.arange(288) < 144, -1.0, 3.0)
    share, start, end = film(count=3).sunlit_shares(np.array([[3e-6], [1e-5], [1e-4]]) * day)
    assert np.all(np.abs(end - start) < 1e-6) and np.all((share >= 0) & (share <= 1))
    flux = np.array([3e-6, 1e-5, 1e-4])[:, None] * np.where(day > 0, 3 * share, -1.0)
    lost = flux.sum(axis=1) * 300
    assert abs(lost[0]) < 1e-3 * 3e-6 * 43200 and lost[2] < 0  # kg m^-2; of the last some runs off


@pytest.mark.parametrize("capacity", [0.0, 1e-30, 1e30])
@pytest.mark.parametrize("evaporation", [-1e30, -1e-30, 0.0, 1e-30, 1e30])
def test_extreme_films_stay_between_nothing_and_the_whole_surface(capacity, evaporation):
    share, start, end = film(capacity, rain=1e-3).sunlit_shares(np.full((1, 288), evaporation))
    for values in (share, start, end):
        assert np.all((values >= 0) & (values <= 1))
    assert capacity > 0 or not np.any(share)


def test_sunlight_that_is_taken_counts_once():
    wet = replace(film(), sunlight=np.full((1, 288), 40.0), dry_sunlight=np.full((1, 288), 200.0))
    for heat, left in ((0.0, 40.0), (-50.0, 30.0), (-200.0, 0.0), (-900.0, 0.0), (300.0, 40.0)):
        np.testing.assert_allclose(wet.light(np.full((1, 288), heat)), left)
    assert np.all(film().light(np.full((1, 288), -10.0)) == 0)


def test_rain_falls_on_the_slope_of_the_face(rain):
    level, steep, hanging = (rain.column(slope=slope).film.rain.max() for slope in (0.0, 60.0, 130.0))
    assert level == pytest.approx(4 / 3600, rel=1e-6) and steep == pytest.approx(level / 2) and hanging == 0


def test_a_file_that_holds_a_part_of_the_film_is_refused(rain):
    axes, variables = shade_fields(rain.table, rain.scene)
    root = Group(axes | {"material": None, "altitude": None}, variables, {}, {})
    root.axes["material"] = axes["response_altitude"]
    whole = StoredResponse.of(root)
    for field in fields(whole.film):
        stored, computed = getattr(whole.film, field.name), getattr(rain.table.film, field.name)
        assert stored is None if computed is None else np.array_equal(stored, computed)
    assert whole.film.before is None
    for name in FILM[1:]:
        part = {key: value for key, value in variables.items() if key != name}
        with pytest.raises(InputError, match=f"lacks '{name}'"):
            StoredResponse.of(replace(root, variables=part))


@pytest.mark.parametrize("before", [None, 0.0])
def test_water_that_lasts_over_midnight_in_the_shade_wets_the_morning_of_a_day_that_repeats(before):
    """Of a sheet without memory, rain at noon: it is dry at 20 h in the open and wet for more than a day in shade."""
    hours = np.ones((1, 24))
    tables = {"heat_loss": 100 + 2 * OFFSETS, "evaporation": 2e-5 * (1 + OFFSETS / 20)}
    water = ColumnFilm(
        **{name: hours[..., None] * values for name, values in tables.items()},
        sunlight=0 * hours,
        dry_sunlight=0 * hours,
        capacity=np.array([0.5]),
        rain=np.where(np.abs(np.arange(288) - 144) < 4, 1e-3, 0.0)[None],
        before=None if before is None else np.array([before]),
    )
    kernel = np.zeros((1, 24, LAG_STARTS.size))
    kernel[..., 0] = 0.1  # K m^2 W^-1: a loss of 10 W m^-2 K^-1, at once
    excess = np.zeros((1, 24, OFFSETS.size))
    sheet = ColumnResponse(LAG_STARTS, OFFSETS, kernel, 290 * hours, 10 * hours, excess, 0 * hours, water)
    change = sheet.change(np.full((1, 288), -80.0), np.full((1, 288), 290.0), np.array([1e4]))[0]
    if before is None:
        assert abs(change[0] - change[-1]) < 0.1 and change[0] < -9
    else:
        assert change[0] == pytest.approx(-8.0, abs=1e-6) and change[-1] < -9
