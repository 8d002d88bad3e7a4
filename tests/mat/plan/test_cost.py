"""The estimate of a build's cost: in proportion to states, bands and materials, and nothing for what is not built."""

import pytest

from skyshine.mat.api.examples import example
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.cost import choices, estimate
from skyshine.mat.plan.plan import make_plan
from skyshine.mat.plan.resources import resources, together
from skyshine.materials.library import load_library

STATE = "\n  - {profile: midlatitude_summer, date: 2026-06-28, weather: {air_temperature_c: [22, 33]}}"


@pytest.fixture
def load(tmp_path, tiny_job):
    def loaded(*changes):
        text = tiny_job()
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
        return load_job(tmp_path / "job.yaml")

    return loaded


@pytest.fixture
def cost(load):
    def of(*changes):
        loaded = load(*changes)
        return estimate(loaded, make_plan(loaded, load_library()))

    return of


def test_twice_the_states_take_twice_the_tables(cost):
    one, two = cost(), cost(("bands:", "  - {profile: tropical, weather: {air_temperature_c: 30}}\nbands:"))
    for stage in ("compile", "atmosphere", "accuracy", "temperature"):
        assert two[stage] == pytest.approx(2 * one[stage]) and one[stage] > 0, stage


def test_a_second_source_takes_less_than_the_first(cost):
    one, both = cost(), cost(("sources: [sun]", "sources: [sun, moon]"))
    assert 1.1 * one["atmosphere"] < both["atmosphere"] < 2 * one["atmosphere"]
    assert both["temperature"] == one["temperature"] and both["compile"] == one["compile"]


def test_a_wider_band_takes_longer_to_compile(cost):
    assert cost(("[10.0, 10.2]", "[8.0, 12.0]"))["compile"] > 2 * cost()["compile"]


def test_each_further_material_costs_the_same(cost):
    few = ["asphalt_road", "asphalt_road, brick_red", "asphalt_road, brick_red, concrete"]
    one, two, three = (cost(("[asphalt_road]", f"[{names}]"))["temperature"] for names in few)
    assert three - two == pytest.approx(two - one) and two > one
    leafy = cost(("[asphalt_road]", "[asphalt_road, grass_green]"))["temperature"]
    assert leafy - one > 1.01 * (two - one)  # leaves and soil; most of the cost of so few columns is by material
    # Part of a material's cost is that of its columns, which are as many again at another altitude.
    high = ("altitude_km: [0]", "altitude_km: [0, 1]")
    first, second = (cost(("[asphalt_road]", f"[{names}]"), high)["temperature"] for names in few[:2])
    assert 1.001 * (two - one) < second - first < 1.5 * (two - one)


def test_level_surfaces_count_once_whatever_their_azimuths(cost):
    changed = [
        ("slope_deg: [0, 45]", "slope_deg: [0]"),
        ("[0], azimuth_deg: [0, 180]", "[0], azimuth_deg: [0, 90, 180, 270]"),
    ]
    assert cost(*changed)["temperature"] == pytest.approx(cost(changed[0])["temperature"])
    assert cost(changed[1])["temperature"] > cost()["temperature"]


def test_what_is_not_built_costs_nothing(cost):
    plain = cost()
    assert plain["pictures"] == plain["textures"] == 0
    drawn = cost(("pictures: false", "pictures: true"))
    assert drawn["pictures"] > 0 and drawn["atmosphere"] == plain["atmosphere"]
    assert plain["shade"] > 0 == cost(("output:", "needs: {shade: false}\noutput:"))["shade"]


def test_points_are_chosen_once_for_states_of_one_air_or_cell_whatever_the_night(load):
    more = ("bands:", STATE.lstrip("\n") + "\n" + STATE.lstrip("\n").replace("06-28", "07-05") + "\nbands:")
    warmer = (more[0], more[1].replace("[22, 33]", "[24, 33]", 1))
    moon = ("sources: [sun]", "sources: [sun, moon]")
    other = ("bands:", "  - {profile: tropical, weather: {air_temperature_c: 30}}\nbands:")
    for changes, chosen in (((more,), 1), ((more, moon), 1), ((other,), 2), ((warmer,), 1)):
        assert choices(load(*changes)) == chosen, changes


def test_a_further_day_of_a_cell_chooses_no_points(cost):
    days = [f"  - {{profile: midlatitude_summer, weather: {{air_temperature_c: [{23 + k}, 33]}}}}\n" for k in (0, 1)]
    one, two, three = (cost(("bands:", f"{''.join(days[:count])}bands:"))["compile"] for count in (0, 1, 2))
    assert 0 < three - two < 0.3 * one and two - one > three - two  # two of a cell take points for its corners


def test_what_takes_less_is_named_with_the_seconds_that_remain():
    loaded = load_job(example())
    plan = make_plan(loaded, load_library())
    stated = resources(loaded, plan)
    names, seconds = zip(*stated.less, strict=True)
    assert names == ("output.pictures: false", "accuracy: 1 K", "sources: [sun]", "1 of 2 bands")
    assert list(seconds) == sorted(seconds, reverse=True) and 0 < seconds[-1] < stated.total
    assert stated.elapsed(1) > stated.elapsed(2) > stated.elapsed(1000) > stated.in_turn
    both = together([stated, stated])
    assert both.disk == 2 * stated.disk and both.memory == stated.memory
    assert both.total == pytest.approx(2 * stated.total - stated.seconds["start"])
    assert both.less[0][1] == pytest.approx(2 * seconds[0] - stated.seconds["start"])
