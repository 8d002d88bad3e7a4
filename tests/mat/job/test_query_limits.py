"""What a job needs: the nodes that reads inside it touch stay, all others go, and both are said."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skyshine.mat.job.load import load_job
from skyshine.mat.job.trim import around, hours_around
from skyshine.mat.plan.plan import make_plan
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
    assert job.trimmed.atmosphere_grid.range_km == [0.2, 0.35, 0.5, 0.75, 1, 1.5, 2, 3, 4, 5, 7]
    assert job.trimmed.observer_altitudes_km == [0.05, 0.2, 0.5, 1, 2, 3]
    assert job.trimmed.surface_grid.slope_deg == [0, 10, 20, 30]
    assert job.requested.atmosphere_grid.range_km[-1] == 1000
    plan = make_plan(job, load_library())
    said = {item.what: item.restore for item in plan.left_out}
    assert (
        said["18 of 29 ranges"] == "a wider needs.range_km, or none"
        and "6 of 12 observer altitudes" in said
        and "6 of 10 slopes" in said
    )
    assert plan.bytes < 0.3 * make_plan(loaded(tmp_path, ""), load_library()).bytes


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
    assert noon.atmosphere_grid.source_elevation_deg == [60, 75]
    night = loaded(tmp_path, 'needs: {hours: ["23:30", "00:30"]}\n')
    assert night.trimmed.sources == ["moon"]
    assert any(item.what == "tables of the sun" for item in make_plan(night, load_library()).left_out)
    assert loaded(tmp_path, 'needs: {hours: ["00:00", "23:59"]}\n').trimmed.sources == ["sun", "moon"]


def test_needs_in_the_wrong_order_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"needs.range_km: found \[6, 0.3\]; allowed: \[least, most\]; swap them"):
        loaded(tmp_path, "needs: {range_km: [6, 0.3]}\n")
