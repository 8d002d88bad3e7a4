"""One number for the pixel, and what it gives the other keys of a job."""

from itertools import pairwise

import pytest

from skyshine.mat.job.load import load_job
from skyshine.schemas.errors import InputError

JOB = {
    "skyshine": 1,
    "name": "pixel",
    "site": {"latitude_deg": 45, "longitude_deg": 0, "date": "2026-07-15", "utc_offset_h": 0},
    "states": [
        {
            "profile": "midlatitude_summer",
            "weather": {
                "air_temperature_c": [14, 27],
                "relative_humidity_percent": 60,
                "wind_speed_m_s": 3,
                "ground_albedo": 0.2,
            },
        }
    ],
    "bands": [{"wavelength_um": [8, 12]}],
    "sources": ["sun"],
    "materials": ["concrete"],
}


def job_of(**keys):
    return load_job(JOB | keys).requested


def test_a_number_alone_is_that_of_the_pixel():
    assert job_of(accuracy="0.3 K") == job_of(accuracy={"pixel": "0.3 K"})


def test_finer_pixels_take_no_coarser_parts():
    jobs = [job_of(accuracy=f"{kelvin} K") for kelvin in (5, 2, 1, 0.5, 0.3, 0.1, 0.05)]
    for coarse, fine in pairwise(jobs):
        assert fine.accuracy.solver_steps >= coarse.accuracy.solver_steps
        for key in ("spectral_tolerance", "tilted_faces_k", "negligible_k"):
            assert getattr(fine.accuracy, key) <= getattr(coarse.accuracy, key)
        for grid in ("atmosphere_grid", "surface_grid"):
            one, other = (getattr(job, grid).tolerance for job in (fine, coarse))
            assert float(one.split()[0]) < float(other.split()[0])


def test_no_part_may_take_more_than_the_pixel():
    job = job_of(accuracy="0.5 K")
    assert job.atmosphere_grid.tolerance == "0.5 K"
    assert float(job.surface_grid.tolerance.removesuffix(" K")) <= 0.5
    assert job.accuracy.tilted_faces_k < 0.5
    # 1 % of transmittance is 0.27 K of a black body at 300 K in 3-5 um, 0.65 K in 8-12 um.
    assert 65 * job.accuracy.spectral_tolerance < 0.5


def test_keys_that_are_written_keep_their_values():
    job = job_of(
        accuracy={"pixel": "1 K", "solver_steps": 288, "spectral_tolerance": 1e-4},
        atmosphere_grid={"tolerance": "0.2 K"},
        surface_grid={"slope_deg": [0]},
    )
    assert (job.accuracy.solver_steps, job.accuracy.spectral_tolerance) == (288, 1e-4)
    assert job.atmosphere_grid.tolerance == "0.2 K"
    assert job.surface_grid.slope_deg == [0] and job.surface_grid.tolerance == "1 K"
    assert job.accuracy.tilted_faces_k == job_of(accuracy="1 K").accuracy.tilted_faces_k


def test_a_job_that_says_nothing_has_half_a_kelvin():
    assert job_of() == job_of(accuracy={}) == job_of(accuracy="0.5 K")
    assert job_of(accuracy={"solver_steps": 288}).atmosphere_grid.tolerance == "0.5 K"


def test_axes_of_temperatures_are_kept_unless_the_job_writes_an_accuracy():
    axes = {"surface_grid": {"slope_deg": [0, 45], "azimuth_deg": [0, 180]}}
    assert job_of(**axes).surface_grid.tolerance is None
    assert job_of(**axes, accuracy="0.5 K").surface_grid.tolerance == "0.5 K"
    assert job_of(surface_grid={"altitude_km": [0]}).surface_grid.tolerance == "0.5 K"


def test_tables_on_five_axes_are_written_where_all_five_are_named():
    axes = {
        "range_km": [0.1, 5],
        "altitude_km": [0.1, 1],
        "elevation_deg": [-90, 90],
        "source_elevation_deg": [0, 60],
        "source_azimuth_deg": [0, 180],
    }
    assert job_of(atmosphere_grid=axes).atmosphere_grid.writes_tables
    for name in axes:
        others = {key: nodes for key, nodes in axes.items() if key != name}
        assert not job_of(atmosphere_grid=others).atmosphere_grid.writes_tables


@pytest.mark.parametrize(
    ("accuracy", "message"),
    [
        ("9 K", r"found '9 K'; allowed: 0.05 K to 5 K"),
        ("0.01 K", r"allowed: 0.05 K to 5 K"),
        ("1 %", r"found '1 %'; allowed: 0.05 K to 5 K"),
        ("half", r"found 'half'; allowed: a number and its unit"),
        (0.3, r"found 0.3; allowed: a number and its unit, or keys"),
        (True, r"found True; allowed: a number and its unit, or keys"),
        ({"pixel": 0.3}, "pixel"),
        ([1], "accuracy"),
    ],
)
def test_other_values_are_refused_in_one_line(accuracy, message):
    with pytest.raises(InputError, match=message) as refused:
        job_of(accuracy=accuracy)
    assert "\n" not in str(refused.value)
