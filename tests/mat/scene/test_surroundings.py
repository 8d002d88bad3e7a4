"""Ground and walls that a state names, as the heat balance and the files have them."""

import pickle

import numpy as np
import pytest
import yaml
from scipy.constants import Stefan_Boltzmann

import skyshine.mat
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.cost import WALLS, estimate
from skyshine.mat.plan.plan import Kind, make_plan
from skyshine.mat.products.product import Context, TaskReport
from skyshine.mat.products.temperature import TemperatureProduct
from skyshine.mat.scene import surface
from skyshine.mat.scene.surface import ground_albedo, scene_inputs, surface_inputs, surface_materials
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.solver import solve_columns
from skyshine.mat.tables.verify import problems
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError

STREET = {"horizon_deg": [[0, 5], [90, 50], [180, 5], [270, 50]], "wall": {"material": "brick_red"}}
NO_SHADE = {"needs": {"shade": False}}
NOON, BEFORE_DAWN = 12 * 24, 5 * 24  # of SUN_STEPS


@pytest.fixture(scope="module", autouse=True)
def skies():
    """The clear sky of one air over one ground is computed once for all tests: surroundings do not change it."""
    known, compute = {}, surface.band_model_sky

    def remembered(*arguments):
        key = pickle.dumps(arguments)
        if key not in known:
            known[key] = compute(*arguments)
        return known[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(surface, "band_model_sky", remembered)
        yield


@pytest.fixture
def job(tiny_job):
    """The tiny job, with walls among its faces, and keys of its state."""

    def make(needs=None, **keys):
        content = yaml.safe_load(tiny_job())
        content["states"][0].update(keys)
        content["materials"] = ["brick_red"]  # no ground by default
        content["surface_grid"] |= {"slope_deg": [0, 90], "time": ["00:00", "12:00"]}
        return content | (needs or {})

    return make


def table(content, folder):
    """The temperature table of a job, without its other files."""
    loaded, library = load_job(content), load_library()
    plan = make_plan(loaded, library)
    task = next(task for task in plan.tasks if task.kind is Kind.TEMPERATURE)
    context = Context(task, loaded.on_date_of_state(1), plan.materials, library)
    (identity,) = TemperatureProduct().identity(context)
    (content,) = TemperatureProduct().compute(context, TaskReport(task.files))
    folder.mkdir(exist_ok=True)
    identity.write(folder, content)
    return skyshine.mat.open(folder / task.files[0])


def enclosure(content):
    return surface_inputs(content)[1][2].enclosure


def forcing(content):
    sun, weather, sky = surface_inputs(content)[1]
    planes = np.array([0.0, 45.0, 90.0, 180.0])
    return Scene(sun, weather, sky, np.zeros(1), planes, 2 * planes).forcing(96)


@pytest.mark.parametrize("open_plain", [{}, {"horizon_deg": 0}, {"horizon_deg": [[0, 0], [90, 0]], "sky_view": 1}])
def test_a_level_horizon_and_the_whole_sky_are_no_surroundings_to_the_last_bit(job, open_plain):
    assert enclosure(job(surroundings=open_plain)) is None
    without, level = forcing(job()), forcing(job(surroundings=open_plain))
    for name, values in vars(without).items():
        assert np.array_equal(values, getattr(level, name)), name


def test_the_ground_reflects_as_its_material_unless_the_weather_names_an_albedo(job):
    (asphalt,) = surface_materials([load_library()["asphalt_road"]])
    weather = {"air_temperature_c": [22, 33]}
    for keys, expected in (
        ({}, 0.2),
        ({"ground_material": "asphalt_road"}, 1 - asphalt.solar_absorptance),
        ({"ground_material": "asphalt_road", "weather": {**weather, "ground_albedo": 0.2}}, 0.2),
        ({"weather": {**weather, "ground_albedo": 0.5}}, 0.5),
    ):
        loaded = load_job(job(**keys)).trimmed
        assert ground_albedo(loaded, loaded.states[0]) == pytest.approx(expected)
        sky = scene_inputs(loaded, 1)[2]
        assert sky.ground_albedo == pytest.approx(expected)
        assert sky.enclosure is None or sky.enclosure.ground.albedo == sky.ground_albedo


def test_hot_ground_radiates_on_what_faces_it(job):
    """A hanging face has all of the change, a wall half of it."""
    plain, road = (forcing(job(**keys)) for keys in ({}, {"ground_material": "asphalt_road"}))
    change = road.longwave_ground - plain.longwave_ground
    ground = enclosure(job(ground_material="asphalt_road")).ground.temperature[0, 0, ::6]
    (asphalt,) = surface_materials([load_library()["asphalt_road"]])
    emitted = asphalt.thermal_emissivity * Stefan_Boltzmann * ground**4
    reflected = (1 - asphalt.thermal_emissivity) * plain.longwave_sky[0]
    assert road.longwave_ground[3] == pytest.approx(emitted + reflected, rel=1e-3)
    assert change[3, 48] > 100
    np.testing.assert_allclose(change[2], 0.5 * change[3], rtol=1e-9)
    assert np.all(road.longwave_ground[0] == 0)
    np.testing.assert_allclose(road.longwave_sky, plain.longwave_sky, rtol=1e-12)


def test_the_ground_is_the_level_face_of_its_material_in_the_table(job, tmp_path):
    """Without walls, and between them."""
    for number, keys in enumerate(({}, {"surroundings": STREET})):
        content = job(ground_material="asphalt_road", **keys)
        built = table(content | NO_SHADE, tmp_path / str(number))
        ground = enclosure(content).ground.temperature[0, 0]
        assert built.temperature(material="asphalt_road", time=[0, 12]) == pytest.approx(ground[[0, NOON]], abs=0.05)
        assert problems(built.path) == []


def test_the_file_tells_what_stood_around_its_surfaces(job, tmp_path):
    street = table(job(ground_material="asphalt_road", surroundings=STREET), tmp_path / "street")
    attributes = street.attributes
    assert (attributes["ground_material"], attributes["wall_material"]) == ("asphalt_road", "brick_red")
    assert attributes["horizon_azimuth"].tolist() == [0, 90, 180, 270]
    assert attributes["horizon_elevation"].tolist() == [5, 50, 5, 50]
    views = enclosure(job(surroundings=STREET)).between
    assert attributes["level_sky_view"] == pytest.approx(views.sky[0]) and attributes["sky_view"] == 1
    morning = street.value("direct_normal_irradiance", altitude=0.0, forcing_time=[8.0, 12.5])
    assert morning[0] == 0 < morning[1]
    court = table(job(surroundings={"sky_view": 0.4, "wall": {"temperature_c": 20}}) | NO_SHADE, tmp_path / "court")
    assert court.attributes["wall_temperature"] == pytest.approx(293.15) and "wall_material" not in court.attributes
    assert court.attributes["level_sky_view"] == pytest.approx(0.4) and problems(court.path) == []
    plain = table(job() | NO_SHADE, tmp_path / "plain")
    assert not {"ground_albedo", "horizon_azimuth", "sky_view"} & plain.attributes.keys()


def test_a_shadow_in_a_street_changes_temperatures_as_the_response_says(job, tmp_path):
    """Loader against the full solution, on level ground and on a wall."""
    content = job(ground_material="asphalt_road", surroundings={"horizon_deg": 30, "wall": {"material": "brick_red"}})
    built = table(content, tmp_path)
    open_share = built.attributes["level_sky_view"]
    for slope, sky_view in ((0.0, 0.6), (90.0, 1.0)):
        column = {"material": "asphalt_road", "azimuth": 180.0, "slope": slope}
        # The loader counts the share over the whole sky, the solution over the open one.
        change = built.absorbed_change(**column, shade=[(10, 14)], sky_view=1 - (1 - sky_view) * open_share)
        read = built.temperature(**column, time=12.0, absorbed_change=change)
        solved = skyshine.mat.temperature(
            "asphalt_road", job=content, slope=slope, azimuth=180.0, shade="10:00-14:00", sky_view=sky_view
        )
        lit = built.temperature(**column, time=12.0)
        exact = np.interp(12.0, solved.time, solved.temperature)
        assert abs(read - exact) < 0.1 * abs(lit - exact) + 0.3


def test_given_and_operated_grounds_and_walls_have_those_temperatures(job):
    """None of them needs to be among the materials of the job."""
    around = {"horizon_deg": 40, "wall": {"material": "concrete_wall"}}
    keys = {"ground_material": "steel_bare", "surroundings": around}
    given = job({"temperatures_c": {"steel_bare": 60.0, "concrete_wall": [float(hour) for hour in range(24)]}}, **keys)
    content = enclosure(given)
    assert content.ground.temperature == pytest.approx(333.15)
    assert content.walls.temperature[0, :, NOON] == pytest.approx(285.15)
    heated = {"concrete_wall": {"kind": "fixed", "temperature_c": 80.0}}
    warm, cold = (enclosure(job(more, **keys)).walls.temperature for more in ({"operated": heated}, {}))
    assert np.all(warm[0, :, BEFORE_DAWN] > cold[0, :, BEFORE_DAWN] + 1)
    with pytest.raises(InputError, match="found the operated 'marble', which is not in materials"):
        load_job(job({"operated": {"marble": heated["concrete_wall"]}}, **keys))


@pytest.mark.parametrize(
    "surroundings",
    [
        {"sky_view": 0},
        {"horizon_deg": 90},
        {"horizon_deg": 90, "sky_view": 0, "wall": {"material": "snow_melting"}},
        {"horizon_deg": 45, "wall": {"material": "aluminium_polished"}},
        {"horizon_deg": 70, "wall": {"temperature_c": 1500}},
        {"horizon_deg": 70, "wall": {"temperature_c": -200, "emissivity": 0.01, "albedo": 0.99}},
        {"horizon_deg": [[359.9, 90]], "sky_view": 0.001, "wall": {"temperature_c": [20] * 24}},
    ],
)
@pytest.mark.parametrize("site", [{"date": "2026-06-28"}, {"latitude_deg": 80, "date": "2026-12-21"}])
def test_extreme_surroundings_give_finite_temperatures_within_their_bounds(job, surroundings, site):
    weather = {"air_temperature_c": [22, 33]} if len(site) == 1 else {"air_temperature_c": -40, "wind_speed_m_s": 0}
    content = job(ground_material="aluminium_polished", surroundings=surroundings, weather=weather)
    content["site"] = content["site"] | site
    sun, air, sky = surface_inputs(content)[1]
    slopes = np.array([0.0, 90.0, 180.0])
    scene = Scene(sun, air, sky, np.zeros(1), slopes, np.zeros(3))
    for material in surface_materials([load_library()[name] for name in ("aluminium_polished", "concrete")]):
        for _, solution in solve_columns(material, scene.forcing):
            assert np.all(np.isfinite(solution.temperature)) and solution.bound_excess.max() < 0.2
            assert np.abs(solution.energy_closure).max() < 0.05


def test_a_change_of_the_surroundings_alone_makes_another_table_of_temperatures(job):
    def header(content):
        loaded, library = load_job(content), load_library()
        plan = make_plan(loaded, library)
        task = next(task for task in plan.tasks if task.files == ("s01.htt.h5",))
        return TemperatureProduct().identity(Context(task, loaded, plan.materials, library))[0].header.job

    road, weather = {"ground_material": "asphalt_road"}, {"air_temperature_c": [22, 33], "ground_albedo": 0.2}
    jobs = [
        job(),
        job(**road),
        job(**road, weather=weather),
        job(surroundings={"horizon_deg": 20}),
        job(surroundings={"horizon_deg": 20, "sky_view": 0.5}),
        job(surroundings=STREET),
        job({"operated": {"brick_red": {"kind": "fixed", "temperature_c": 20.0}}}, surroundings=STREET),
        job({"temperatures_c": {"brick_red": 20.0}}, surroundings=STREET),
    ]
    texts = [header(content) for content in jobs]
    assert len(set(texts)) == len(texts)
    assert header(job(surroundings={"horizon_deg": 0})) == texts[0]
    assert "surroundings" not in texts[0]


def test_walls_that_are_solved_count_in_the_estimate(job):
    def seconds(content):
        loaded = load_job(content)
        return estimate(loaded, make_plan(loaded, load_library()))["temperature"]

    assert seconds(job(surroundings=STREET)) - seconds(job()) == pytest.approx(WALLS)
    assert seconds(job(surroundings={"horizon_deg": 30})) == pytest.approx(seconds(job()))
