"""Temperatures under shade and other heat, read from a file, against whole solutions; extreme surfaces; bounds."""

from dataclasses import replace

import numpy as np
import pytest
from numpy_response import ColumnResponse

from skyshine.mat import open as open_file
from skyshine.mat.scene.surface import surface_inputs, surface_materials
from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.response import response_table, surface_response
from skyshine.mat.surface.response_nodes import LAG_STARTS, OFFSETS
from skyshine.mat.surface.solver import solve_columns
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.mat.surface.table import temperature_table
from skyshine.mat.tables.files import HTT
from skyshine.mat.tables.htt import enclosure_attributes, htt_group, shade_fields
from skyshine.mat.tables.stated_error import accuracy_group
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Header, read_file, write_file

NAMES = ["asphalt_road", "grass_green", "soil_loam_wet", "aluminium_weathered", "pvc_white", "snow_melting"]
FOIL = "aluminium_weathered"  # the least heat capacity of the library
SNOW, MELTING_POINT = "snow_melting", 273.15
SLOPES, AZIMUTHS = [0.0, 45.0, 90.0], [0.0, 90.0, 180.0, 270.0]
HOURS = np.arange(48) / 2
JOB = {
    "skyshine": 1,
    "name": "shade",
    "site": {"latitude_deg": 35, "longitude_deg": 139, "date": "2026-06-21", "utc_offset_h": 9},
    "states": [{"profile": "midlatitude_summer", "weather": {"air_temperature_c": [18, 29]}}],
    "bands": [{"wavelength_um": [8, 12]}],
    "materials": NAMES,
}
POLE = {
    **JOB,
    "site": {"latitude_deg": 80, "longitude_deg": 15, "date": "2026-12-21", "utc_offset_h": 1},
    "states": [{"profile": "subarctic_winter", "weather": {"air_temperature_c": [-35, -25]}}],
}


class Day:
    """A file of one state and what it was computed from."""

    def __init__(self, job, path):
        inputs = surface_inputs(job)[1]
        library = load_library()
        self.materials = dict(zip(NAMES, surface_materials([library[name] for name in NAMES]), strict=True))
        self.codes = {name: library[name].code for name in NAMES}
        self.scene = Scene(*inputs, np.array([0.0, 500.0]), np.array(SLOPES), np.zeros(3))
        ordered = sorted(self.materials.values(), key=lambda material: self.codes[material.name])
        names = [material.name for material in ordered]
        table = temperature_table(
            ordered, *inputs, [0.0, 500.0], AZIMUTHS, SLOPES, list(HOURS), steps=288
        )  # as whole solutions below
        axes = {
            "altitude_km": np.array([0.0, 0.5]),
            "azimuth_deg": np.array(AZIMUTHS),
            "slope_deg": np.array(SLOPES),
            "time_h": HOURS,
        }
        around = {"ground_material": "asphalt_road", **enclosure_attributes(inputs[2].enclosure)}
        fields = shade_fields(response_table(ordered, self.scene), self.scene)
        group = htt_group(
            table,
            [self.codes[name] for name in names],
            names,
            axes,
            accuracy_group([], {}, {}, {}),
            around,
            shade=fields,
        )
        write_file(path, group, Header(HTT.name, "data", "job"))
        self.table = open_file(path)

    def whole(self, name, slope, azimuth, around=None):
        """Temperatures of the whole solution, balance and forcing of one face at 288 times."""
        material = self.materials[name]
        face = Scene(
            self.scene.sun,
            self.scene.weather,
            self.scene.sky,
            np.array([0.0]),
            np.array([slope]),
            np.array([azimuth]),
            around,
        )
        ((_, solution),) = solve_columns(material, face.forcing, steps=288)
        return solution.temperature[0], Balance(face.forcing(288), material)


@pytest.fixture(scope="module")
def day(tmp_path_factory):
    return Day(JOB, tmp_path_factory.mktemp("shade") / "s01.htt.h5")


@pytest.fixture(scope="module")
def night(tmp_path_factory):
    return Day(POLE, tmp_path_factory.mktemp("night") / "s01.htt.h5")


SHADES = [
    {"shade": [(10.0, 14.0)]},
    {"shade": [(22.0, 9.25), (15.1, 15.6)]},
    {"shade": [(0.0, 24.0)], "sky_view": 0.4, "facing": 315.0},
    {"sky_view": 0.7, "facing": 272.0, "facing_emissivity": 0.6},
]


def around(shade):
    return Surroundings(**{**shade, "shade": tuple(shade.get("shade", ()))})


@pytest.mark.parametrize("shade", SHADES)
@pytest.mark.parametrize(("slope", "azimuth"), [(0.0, 0.0), (90.0, 270.0), (45.0, 90.0)])
def test_shaded_temperatures_are_those_of_whole_solutions(day, shade, slope, azimuth):
    for name in NAMES[:-1]:
        place = {"material": name, "slope": slope, "azimuth": azimuth}
        sunlit, _ = day.whole(name, slope, azimuth)
        whole, _ = day.whole(name, slope, azimuth, around(shade))
        change = day.table.absorbed_change(**place, **shade)
        read = day.table.temperature(**place, time=HOURS, absorbed_change=change)
        expected, start = whole[::6], sunlit[::6]
        assert np.abs(expected - start).max() > 0.2
        assert np.sqrt(np.mean((read - expected) ** 2)) < 0.35, name


def test_the_response_is_given_at_the_lowest_and_the_highest_altitude(day):
    assert list(day.table.root.axes["response_altitude"].values) == [0.0, 0.5]


@pytest.mark.parametrize("shade", SHADES)
def test_changes_of_heat_are_those_of_the_solver(day, shade):
    place = {"slope": 45.0, "azimuth": 180.0}
    for name in NAMES[:2]:
        _, shaded = day.whole(name, 45.0, 180.0, around(shade))
        _, sunlit = day.whole(name, 45.0, 180.0)
        change = day.table.absorbed_change(material=name, **place, **shade)
        # Light is averaged over the steps before it meets the plane; the Sun rises within one.
        np.testing.assert_allclose(change, (shaded.absorbed - sunlit.absorbed)[0], atol=3.0)
        assert np.sqrt(np.mean((change - (shaded.absorbed - sunlit.absorbed)[0]) ** 2)) < 0.4


@pytest.mark.parametrize("steps", [1, 24, 100, 288])
def test_no_change_of_heat_gives_the_table(day, steps):
    place = {"material": NAMES, "slope": 33.0, "azimuth": 70.0, "time": 13.3}
    table = day.table.temperature(**place)
    np.testing.assert_allclose(day.table.temperature(**place, absorbed_change=np.zeros(steps)), table, rtol=1e-14)


def test_shade_all_day_is_one_call(day):
    place = {"material": ["asphalt_road", "grass_green"], "slope": 45.0, "azimuth": 180.0}
    change = day.table.absorbed_change(**place, shade=[(0, 24)], sky_view=0.8)
    shaded = day.table.shaded_temperature(**place, time=13.0, sky_view=0.8)
    assert np.array_equal(shaded, day.table.temperature(**place, time=13.0, absorbed_change=change))
    assert np.all(shaded < day.table.temperature(**place, time=13.0) - 5)


@pytest.mark.parametrize("name", NAMES[:-1])
@pytest.mark.parametrize("shade", SHADES)
def test_shaded_temperatures_keep_within_the_bounds_of_the_balance(day, name, shade):
    """Between the coldest and the warmest temperature at which some time's fluxes are in balance without conduction,
    and those of the air behind: its mean, or all of its day where the back floats.
    """
    for slope, azimuth in ((0.0, 0.0), (90.0, 180.0)):
        _, balance = day.whole(name, slope, azimuth, around(shade))
        trial = np.linspace(180.0, 420.0, 2401)[:, None]
        loss = np.stack([balance.loss(np.full(balance.shape, kelvin))[0] for kelvin in trial[:, 0]])
        balanced = trial[np.argmax(loss > 0, axis=0), 0]
        floats = day.materials[name].thermal.back.kind == "cavity"
        air = balance.air_temperature if floats else balance.air_temperature.mean()
        change = day.table.absorbed_change(material=name, slope=slope, azimuth=azimuth, **shade)
        read = day.table.temperature(
            material=name, slope=slope, azimuth=azimuth, time=np.arange(288) / 12, absorbed_change=change
        )
        assert read.min() > min(balanced.min(), np.min(air)) - 0.3
        assert read.max() < max(balanced.max(), np.max(air)) + 0.3


def test_less_heat_never_warms_and_more_never_cools(day):
    draw = np.random.default_rng(2)
    time = np.arange(0, 24, 0.25)
    for name in NAMES:
        sunlit = day.table.temperature(material=name, time=time)
        for scale in (5.0, 80.0, 900.0):
            heat = draw.uniform(0, scale, 96)
            assert np.all(day.table.temperature(material=name, time=time, absorbed_change=heat) >= sunlit)
            assert np.all(day.table.temperature(material=name, time=time, absorbed_change=-heat) <= sunlit)


def test_much_heat_on_a_wet_surface_settles(day):
    """Evaporation grows so fast with temperature that the tangent alone is 40 K off."""
    material = day.materials["soil_loam_wet"]
    sunlit, _ = day.whole("soil_loam_wet", 0.0, 0.0)
    face = Scene(*(getattr(day.scene, part) for part in ("sun", "weather", "sky")), *np.zeros((3, 1)))

    def heated(steps):
        forcing = face.forcing(steps)
        return replace(forcing, longwave_ground=forcing.longwave_ground + 600 / material.thermal_emissivity)

    ((_, solution),) = solve_columns(material, heated, steps=288)
    read = day.table.temperature(material="soil_loam_wet", time=HOURS, absorbed_change=[600.0])
    assert (solution.temperature[0] - sunlit).max() > 8
    np.testing.assert_allclose(read, solution.temperature[0, ::6], atol=0.5)


def test_a_body_in_vacuum_cools_as_the_whole_solution(day):
    """Without air only radiation is left: 40 K in a shadow of five hours."""
    material, place = day.materials["asphalt_road"], np.zeros((3, 1))
    scene = (
        day.scene.sun,
        day.scene.weather,
        replace(day.scene.sky, pressure=np.full(day.scene.sky.pressure.shape, 1.0)),
    )
    sunlit, shaded = (Scene(*scene, *place, around) for around in (None, Surroundings(((9.0, 14.0),))))

    def airless(face):
        return lambda steps: replace(face.forcing(steps), pressure=np.zeros((1, 1)))

    response = surface_response(material, [airless(sunlit)])
    column = ColumnResponse(
        LAG_STARTS,
        OFFSETS,
        response.kernel,
        response.temperature,
        response.loss_slope,
        response.loss_excess,
        response.melt,
    )
    ((_, start),), ((_, whole),) = (solve_columns(material, airless(face), steps=288) for face in (sunlit, shaded))
    heat = (Balance(airless(face)(288), material).absorbed for face in (shaded, sunlit))
    change = column.change(np.subtract(*heat), start.temperature, np.array([1e4]))
    expected = whole.temperature - start.temperature
    assert expected.min() < -30
    assert np.sqrt(np.mean((change - expected) ** 2)) < 0.3


def test_snow_stays_at_its_melting_point_whatever_heats_it(day):
    read = day.table.temperature(material=SNOW, time=HOURS, absorbed_change=np.full(24, 500.0))
    assert np.all(read <= MELTING_POINT + 1e-3) and np.all(np.isfinite(read))


def test_shade_in_the_polar_night_changes_nothing_and_a_wall_warms(night):
    time = np.arange(0, 24, 0.25)
    for name in NAMES:
        table = night.table.temperature(material=name, time=time)
        shade = night.table.absorbed_change(material=name, shade=[(8, 16)])
        assert not shade.any()
        assert np.array_equal(night.table.temperature(material=name, time=time, absorbed_change=shade), table)
        wall = night.table.shaded_temperature(material=name, time=time, sky_view=0.5)
        assert np.all(wall > table) and np.all(wall < table.max() + 20)


def test_frozen_snow_in_the_polar_night_is_as_right_as_other_surfaces(night):
    wall = {"sky_view": 0.5, "facing": 255.0}
    whole, _ = night.whole(SNOW, 0.0, 0.0, around(wall))
    change = night.table.absorbed_change(material=SNOW, **wall)
    read = night.table.temperature(material=SNOW, time=HOURS, absorbed_change=change)
    assert np.sqrt(np.mean((read - whole[::6]) ** 2)) < 0.1


def test_arguments_broadcast(day):
    heat = np.stack([np.full(24, -50.0), np.full(24, 50.0), np.zeros(24)])
    read = day.table.temperature(
        material=["asphalt_road", "grass_green", "pvc_white"], time=[[2.0], [14.0]], absorbed_change=heat
    )
    assert read.shape == (2, 3)
    alone = day.table.temperature(material="grass_green", time=14.0, absorbed_change=heat[1])
    assert read[1, 1] == pytest.approx(float(alone), abs=1e-9)


def test_steps_of_heat_are_means_about_their_times(day):
    """A pulse of 2 hours about 12 h in 12 steps is one of 11 to 13 h in 288."""
    coarse, fine = np.zeros(12), np.zeros(288)
    coarse[6] = 200.0
    fine[11 * 12 + 1 : 13 * 12] = 200.0
    fine[[11 * 12, 13 * 12]] = 100.0
    time = np.arange(10, 18, 0.1)
    read = [day.table.temperature(material=FOIL, time=time, absorbed_change=heat) for heat in (coarse, fine)]
    np.testing.assert_allclose(*read, atol=1e-9)
    assert read[0][20] - day.table.temperature(material=FOIL, time=time)[20] > 5


@pytest.mark.parametrize(
    ("heat", "message"),
    [([], "found no steps"), (5.0, "found no steps"), ([np.nan, 1.0], "not finite"), ([np.inf], "not finite")],
)
def test_bad_changes_of_heat_are_refused(day, heat, message):
    with pytest.raises(InputError, match=message):
        day.table.temperature(material="asphalt_road", time=12, absorbed_change=heat)


def test_a_file_without_the_response_says_what_to_do(day, tmp_path):
    root, _ = read_file(day.table.path)
    kept = {name: root.variables[name] for name in ("temperature", "material_name")}
    axes = {name: root.axes[name] for name in root.variables["temperature"].dims}
    write_file(tmp_path / "bare.h5", replace(root, axes=axes, variables=kept), Header("htt", "data", "job"))
    bare = open_file(tmp_path / "bare.h5")
    assert bare.temperature(material="asphalt_road", time=12) > 300
    for call in (bare.shaded_temperature, lambda **where: bare.temperature(**where, absorbed_change=[1.0])):
        with pytest.raises(InputError, match="has no response to shade; build it again, without needs.shade: false"):
            call(material="asphalt_road", time=12)


def test_a_table_of_part_of_the_day_is_shaded_too(day, tmp_path):
    # Where the table has no time, the loss is taken at air temperature.
    root, _ = read_file(day.table.path)
    nodes = np.array([9.0, 11.0, 13.0, 15.0])
    time = replace(
        root.axes["time"], values=nodes, attributes=root.axes["time"].attributes | {"interpolation": "linear"}
    )
    whole = root.variables["temperature"]
    part = replace(whole, data=whole.data[..., [18, 22, 26, 30]])
    write_file(
        tmp_path / "part.h5",
        replace(root, axes=root.axes | {"time": time}, variables=root.variables | {"temperature": part}),
        Header(HTT.name, "data", "job"),
    )
    table = open_file(tmp_path / "part.h5")
    place = {"material": "asphalt_road", "slope": 90.0, "azimuth": 270.0, "time": nodes}
    np.testing.assert_allclose(table.shaded_temperature(**place), day.table.shaded_temperature(**place), atol=1.5)


@pytest.mark.parametrize(
    "name", ["melting_heat", "highest_temperature", "response_temperature", "solar_elevation", "thermal_emissivity"]
)
def test_a_file_with_a_part_of_the_response_is_refused(day, name):
    root = day.table.root
    variables = {key: array for key, array in root.variables.items() if key != name}
    partial = replace(day.table, root=replace(root, variables=variables))
    with pytest.raises(InputError, match=f"lacks '{name}' of the response to shade"):
        partial.shaded_temperature(material="asphalt_road", time=12.0)
