"""Nodes of single quantities: on axes that a job does not write, between the same ends."""

import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.scene.grids import path_grid
from skyshine.mat.tables.gridded import FIELDS, QUANTITIES

JOB = """\
skyshine: 1
name: nodes
site: {latitude_deg: 45, longitude_deg: 0, date: 2026-06-21, utc_offset_h: 0, altitude_km: 0.3}
states:
  - profile: midlatitude_summer
    weather: {air_temperature_c: 15}
bands:
  - wavelength_um: [8, 12]
materials: [asphalt_road]
"""
CLOUD = JOB.replace("    weather", "    clouds: [{type: stratus, height_km: [0.65, 1.15]}]\n    weather")


@pytest.fixture
def load(tmp_path):
    def loaded(more="", text=JOB):
        (tmp_path / "job.yaml").write_text(text + more, encoding="utf-8")
        return load_job(tmp_path / "job.yaml")

    return loaded


def test_each_quantity_has_its_nodes_between_the_ends_of_the_axes(load):
    job = load().trimmed
    shared = path_grid(job)
    for name in QUANTITIES:
        own = path_grid(job, name)
        for field in FIELDS:
            nodes, ends = getattr(own, field), getattr(shared, field)
            assert (nodes[0], nodes[-1]) == (ends[0], ends[-1]), (name, field)
    direct, path = (path_grid(job, name) for name in ("direct_radiance", "path_radiance_ratio"))
    assert direct.source_elevation_deg.size > path.source_elevation_deg.size > shared.source_elevation_deg.size
    assert path.by_scattering_angle and not direct.by_scattering_angle
    assert path.range_km.size < shared.range_km.size == direct.range_km.size
    assert 30.3 in direct.altitude_km and 30.3 not in path.altitude_km  # 30 km above the ground
    assert set(shared.altitude_km) <= set(direct.altitude_km)


@pytest.mark.parametrize("field", FIELDS)
def test_an_axis_that_a_job_writes_is_that_of_all_quantities(field, load):
    nodes = getattr(path_grid(load().trimmed), field).tolist()
    job = load(f"atmosphere_grid: {{{field}: {nodes}}}\n").trimmed
    assert all(getattr(path_grid(job, name), field).tolist() == nodes for name in QUANTITIES)
    assert path_grid(job, "path_radiance_ratio").by_scattering_angle == (field != "source_azimuth_deg")
    others = [other for other in FIELDS if other != field]
    plain = load().trimmed
    for name in QUANTITIES:
        for other in others:
            assert getattr(path_grid(job, name), other).tolist() == getattr(path_grid(plain, name), other).tolist()


def test_edges_of_clouds_are_nodes_of_every_quantity(load):
    job = load(text=CLOUD).trimmed
    edges = set(job.observer_altitudes_km) - set(load().trimmed.observer_altitudes_km)
    assert edges == {0.95, 1.45}
    for name in QUANTITIES:
        assert edges <= set(path_grid(job, name).altitude_km)


def test_under_query_limits_all_quantities_end_where_the_axes_end(load):
    needs = {"range_km": (0.3, 6), "observer_altitude_km": (0.32, 11), "elevation_deg": (-8, 3.5)}
    job = load(f"needs: {{{', '.join(f'{key}: {list(limits)}' for key, limits in needs.items())}}}\n")
    shared = path_grid(job.trimmed)
    for name in QUANTITIES:
        whole, kept = path_grid(job.requested, name), path_grid(job.trimmed, name)
        for field, limits in zip(FIELDS[:3], needs.values(), strict=True):
            ends, nodes = getattr(shared, field)[[0, -1]], getattr(kept, field)
            assert ends[0] <= limits[0] and limits[1] <= ends[1]
            assert nodes[[0, -1]].tolist() == ends.tolist(), (name, field)
            assert nodes[1:-1].tolist() == [node for node in getattr(whole, field) if ends[0] < node < ends[1]]
