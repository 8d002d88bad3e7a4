"""Grids at the edge: every range behind the ground, and no range but 0."""

import numpy as np

import skyshine.mat
from skyshine.mat.job.load import load_job
from skyshine.mat.tables.verify import problems


def test_no_point_above_the_ground_is_stated_as_none_measured(build_atmosphere, tiny_job, tmp_path):
    text = tiny_job().replace("range_km: [0.001, 5]", "range_km: [5, 20]")
    text = text.replace("elevation_deg: [-90, 0, 90]", "elevation_deg: [-90, -60]")
    assert "[5, 20]" in text and "[-90, -60]" in text
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    file = build_atmosphere(load_job(tmp_path / "job.yaml"), tmp_path)
    table = skyshine.mat.open(file)
    assert problems(file) == [] and not table.root.groups["grid"].variables["valid"].data.any()
    stated = table.error("beta_star")
    assert stated["points"] == 0 and np.isnan(stated["maximum"]) and np.isnan(stated["rms_kelvin"])


def test_a_table_of_range_0_alone_is_built_and_drawn(build_inline, tiny_job, tmp_path):
    text = tiny_job().replace("range_km: [0.001, 5]", "range_km: [0]")
    text = text.replace("pictures: false", "pictures: true")
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    build_inline(load_job(tmp_path / "job.yaml"))
    table = skyshine.mat.open(tmp_path / "built" / "s01b01.atmq.h5")
    assert problems(table.path) == []
    assert table.transmittance(range=0.0, beta_star=table.root.groups["grid"].variables["beta_star"].data).min() == 1.0
    assert (tmp_path / "built" / "pictures" / "s01b01.atmq.png").stat().st_size > 10_000
