"""What a job needs: the nodes that reads inside it touch stay, all others go, and both are said."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skyshine.mat.atmosphere.transfer.path_axes import ALL_PATHS
from skyshine.mat.job.load import load_job
from skyshine.mat.job.trim import around, hours_around
from skyshine.mat.plan.plan import make_plan
from skyshine.mat.scene.grids import path_scope
from skyshine.mat.tables.axes import LINEAR, AxisRule
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError

JOB = """\
skyshine: 1
name: needs
site: {latitude_deg: 45, longitude_deg: 0, date: 2026-06-21, utc_offset_h: 0, altitude_km: 0}
states:
  - profile: midlatitude_summer
    weather: {air_temperature_c: 15}
bands:
  - wavelength_um: [8, 12]
materials: [asphalt_road]
"""


def loaded(folder, needs):
    file = folder / "job.yaml"
    file.write_text(JOB + needs, encoding="utf-8")
    return load_job(file)


@given(
    nodes=st.lists(st.integers(-50, 50), min_size=1, max_size=12, unique=True).map(sorted),
    ends=st.tuples(st.floats(-60, 60), st.floats(-60, 60)).map(sorted),
    share=st.floats(0, 1),
)
def test_reads_inside_do_not_change(nodes, ends, share):
    kept = around(nodes, *ends)
    values = {node: np.sin(node) for node in nodes}
    place = np.clip(ends[0] + share * (ends[1] - ends[0]), nodes[0], nodes[-1])
    read = [
        np.interp(np.clip(place, some[0], some[-1]), some, [values[node] for node in some]) for some in (nodes, kept)
    ]
    assert read[0] == pytest.approx(read[1], abs=1e-12)
    assert kept[0] in nodes and set(kept) <= set(nodes)


def test_axes_shrink_and_the_plan_says_so(tmp_path):
    job = loaded(tmp_path, "needs: {range_km: [0.3, 6], observer_altitude_km: [0.1, 2.5], slope_deg: [0, 25]}\n")
    assert job.trimmed.atmosphere_grid.range_km == [0.3, 0.35, 0.5, 0.75, 1, 1.5, 2, 3, 4, 5, 6]
    assert job.trimmed.observer_altitudes_km == [0.1, 0.2, 0.5, 1, 2, 2.5]
    assert job.trimmed.surface_grid.slope_deg == [0, 9, 18, 25]
    assert job.requested.atmosphere_grid.range_km[-1] == 1000
    plan = make_plan(job, load_library())
    said = {item.what: item.restore for item in plan.left_out}
    assert (
        said["18 of 29 ranges"] == "a wider needs.range_km, or none"
        and "6 of 12 observer altitudes" in said
        and "17 of 21 slopes" in said
    )
    assert plan.bytes < make_plan(loaded(tmp_path, ""), load_library()).bytes


@given(
    nodes=st.lists(st.integers(0, 95), min_size=1, max_size=40, unique=True).map(
        lambda quarters: sorted(q / 4 for q in quarters)
    ),
    hours=st.tuples(st.integers(0, 1439), st.integers(0, 1439)).map(lambda minutes: tuple(m / 60 for m in minutes)),
    share=st.floats(0, 1),
)
def test_hours_inside_do_not_change(nodes, hours, share):
    """Periodic in the whole day, linear in the part: the same value at every time between the two hours, also over
    midnight.
    """
    kept = hours_around(nodes, hours)
    length = (hours[1] - hours[0]) % 24.0
    time = hours[0] + share * length
    value = {node: np.sin(node) for node in nodes}
    if kept == nodes:
        return
    assert len(kept) < len(nodes) and kept == sorted(kept) and 0 <= kept[0] < 24.0
    assert {node % 24.0 for node in kept} <= set(nodes)
    whole = np.interp(time, nodes, [value[node] for node in nodes], period=24.0)
    rule = AxisRule("time", np.array(kept), LINEAR, 24.0)
    lower, upper, weight = rule.locate(np.array([time, time % 24.0]))
    read = [
        value[kept[a] % 24.0] * (1 - w) + value[kept[b] % 24.0] * w
        for a, b, w in zip(lower, upper, weight, strict=True)
    ]
    assert read == pytest.approx([whole, whole], abs=1e-9)


def test_only_the_bands_that_are_named_are_built(tmp_path):
    bands = "needs: {bands: [long, b02]}\n"
    text = JOB.replace(
        "  - wavelength_um: [8, 12]",
        "  - {name: long, wavelength_um: [8, 12]}\n  - wavelength_um: [4, 5]\n  - wavelength_um: [3, 4]",
    )
    (tmp_path / "job.yaml").write_text(text + bands, encoding="utf-8")
    job = load_job(tmp_path / "job.yaml")
    plan = make_plan(job, load_library())
    assert job.trimmed.needed_bands == [1, 2]
    assert {task.band for task in plan.tasks if task.kind != "temperature"} == {
        1,
        2,
    }
    assert [(item.what, item.restore) for item in plan.left_out][-1] == (
        "all files of the band b03",
        "b03 in needs.bands, or none",
    )


def test_noon_needs_no_low_sun_and_night_none_at_all(tmp_path):
    """Highest Sun at 45 degree north on the solstice: 68.4 degree; at midnight it is 21.6 degree below the horizon."""
    noon = loaded(tmp_path, 'sources: [sun]\nneeds: {hours: ["11:30", "12:30"]}\n').trimmed
    low, high = noon.atmosphere_grid.source_elevation_deg
    assert 60 < low < 68.4 < high < 75
    night = loaded(tmp_path, 'needs: {hours: ["23:30", "00:30"]}\n')
    assert night.trimmed.sources == ["moon"]
    assert any(item.what == "tables of the sun" for item in make_plan(night, load_library()).left_out)
    assert loaded(tmp_path, 'needs: {hours: ["00:00", "23:59"]}\n').trimmed.sources == ["sun", "moon"]


def test_needs_in_the_wrong_order_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"needs.range_km: found \[6, 0.3\]; allowed: \[least, most\]; swap them"):
        loaded(tmp_path, "needs: {range_km: [6, 0.3]}\n")


def test_needs_outside_of_the_jobs_tables_are_refused_with_their_place(tmp_path):
    for needs, words in (
        ("range_km: [2000, 3000]", r"job.yaml:\d+:\d+: needs.range_km: found \[2000, 3000\]; .* 0.001 to 1000; change"),
        (
            "surface_altitude_km: [5, 6]",
            r"needs.surface_altitude_km: found \[5, 6\]; .* part of the range of surface_grid.altitude_km",
        ),
        ("materials: [concrete]", r"needs.materials.0: found 'concrete'; .*asphalt_road"),
        ("sources: [moon]", r"needs.sources.0: found 'moon'; .*sun"),
    ):
        with pytest.raises(InputError, match=words):
            loaded(tmp_path, f"sources: [sun]\nneeds: {{{needs}}}\n")


def test_a_tolerance_ends_the_axes_where_the_reads_end(tmp_path):
    limits = "needs: {range_km: [0.3, 6], elevation_deg: [-12, -8], surface_altitude_km: [0.1, 0.2]}\n"
    job = loaded(tmp_path, "accuracy: 0.5 K\n" + limits).trimmed
    assert job.atmosphere_grid.range_km == [0.3, 0.35, 0.5, 0.75, 1, 1.5, 2, 3, 4, 5, 6]
    assert job.atmosphere_grid.elevation_deg == [-12, -10, -8]
    assert job.surface_altitudes_km == [0.1, 0.2]


def test_faces_replace_slopes_and_azimuths(tmp_path):
    job = loaded(tmp_path, "needs: {faces_deg: [[0, 77], [90, 360], [90, 120.5], [180, 5]]}\n").trimmed
    assert job.surface_grid.slope_deg == [0, 90, 180]
    assert job.surface_grid.azimuth_deg == [0, 120.5]
    level = loaded(tmp_path, "needs: {faces_deg: [[0, 77]]}\n").trimmed
    assert level.surface_grid.azimuth_deg == [0] and level.ambient_harmonics == 0


def test_the_ground_around_faces_stays(tmp_path):
    text = JOB.replace("    weather:", "    ground_material: asphalt_road\n    weather:")
    (tmp_path / "job.yaml").write_text(text + "needs: {faces_deg: [[90, 10]]}\n", encoding="utf-8")
    assert load_job(tmp_path / "job.yaml").trimmed.surface_grid.slope_deg == [0, 90]


def test_faces_and_a_span_of_slopes_exclude_each_other(tmp_path):
    with pytest.raises(InputError, match="found faces_deg and slope_deg; allowed: one of them"):
        loaded(tmp_path, "needs: {faces_deg: [[0, 0]], slope_deg: [0, 90]}\n")
    many = [[slope, azimuth] for slope, azimuth in zip(range(1, 71), range(70), strict=True)]
    with pytest.raises(InputError, match="70 slopes and 70 azimuths, 4900 orientations; allowed: at most 4096"):
        loaded(tmp_path, f"needs: {{faces_deg: {many}}}\n")


def test_materials_that_are_not_needed_are_not_built(tmp_path):
    text = JOB.replace("[asphalt_road]", "[asphalt_road, grass_green, concrete]")
    (tmp_path / "job.yaml").write_text(text + "needs: {materials: [concrete]}\n", encoding="utf-8")
    plan = make_plan(load_job(tmp_path / "job.yaml"), load_library())
    assert plan.materials == ("concrete",)
    assert any(item.what == "all other materials" for item in plan.left_out)


def test_a_source_that_is_named_stays_in_a_polar_night(tmp_path):
    text = JOB.replace("latitude_deg: 45", "latitude_deg: 88").replace("2026-06-21", "2026-12-21")
    for needs, sources in (("", ["moon"]), (", sources: [sun]", ["sun"])):
        (tmp_path / "job.yaml").write_text(text + f'needs: {{hours: ["12:00", "13:00"]{needs}}}\n', encoding="utf-8")
        job = load_job(tmp_path / "job.yaml").trimmed
        assert job.sources == sources
        if sources == ["sun"]:
            assert job.atmosphere_grid.source_elevation_deg == [-10]


def test_narrow_paths_are_sampled_as_densely_as_all(tmp_path):
    every = path_scope(loaded(tmp_path, "needs: {bands: [b01], hours: ['10:00', '12:00'], shade: false}\n"))
    assert every.share == 1.0 and not every.is_part
    assert every.highest_surface > 1e6
    needs = "needs: {range_km: [0.1, 0.2], observer_altitude_km: [0.05, 0.05], elevation_deg: [-30, 30]}\n"
    part = path_scope(loaded(tmp_path, needs))
    assert part.share == pytest.approx(1 / 28 * 1 / 11 * 18 / 24)
    # 50 m up, and 200 m along a line that rises by 30 degree.
    assert part.highest_surface == pytest.approx(150.0, abs=0.01)
    assert part.heights([0.0, 100.0, 200.0, 300.0]).tolist() == [0.0, 100.0, 200.0]
    assert part.lines(400) == 100 and part.lines(20) == 16 and ALL_PATHS.lines(400) == 400
