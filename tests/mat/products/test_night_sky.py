"""The night sky in tables: more ambient light where the job asks for it, and nothing else."""

import copy

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.job.load import load_job

JOB = {
    "skyshine": 1,
    "name": "night",
    "site": {"latitude_deg": 35, "longitude_deg": 139, "date": "2026-06-21", "utc_offset_h": 9},
    "states": [{"profile": "midlatitude_summer", "weather": {"air_temperature_c": [18, 29]}}],
    "bands": [{"wavelength_um": [1.5, 1.7]}],
    "sources": ["moon"],
    "materials": ["concrete"],
    "atmosphere_grid": {
        "tolerance": "5 K",
        "range_km": [0.01, 1],
        "altitude_km": [0.01, 0.1, 1],
        "elevation_deg": [-90, -30, -5, 0, 90],
        "source_elevation_deg": [0, 20, 45, 80],
        "source_azimuth_deg": [0, 90, 180],
    },
    "surface_grid": {"altitude_km": [0], "azimuth_deg": [180], "slope_deg": [0]},
    "output": {"folder": "built", "pictures": False},
}


@pytest.fixture(scope="module")
def tables(tmp_path_factory, build_atmosphere):
    def built(factor):
        job = copy.deepcopy(JOB)
        job["states"][0]["night_sky"] = factor
        folder = tmp_path_factory.mktemp("night")
        return skyshine.mat.open(build_atmosphere(load_job(job, folder=folder), folder))

    return built(0.0), built(1.0)


MOONLESS = {"range": 0.01, "altitude": 0.01, "elevation": 0.0, "source_elevation": -80.0}


def test_ambient_light_alone_changes(tables):
    dark, lit = (table.root.groups["grid"].variables for table in tables)
    for name in ("beta_star", "path_radiance_ratio", "direct_radiance"):
        np.testing.assert_array_equal(lit[name].data, dark[name].data)
    assert np.all(lit["ambient_radiance"].data > dark["ambient_radiance"].data)
    without, with_airglow = (table.value("ambient_radiance", **MOONLESS) for table in tables)
    assert with_airglow > 10 * without


def test_it_is_the_airglow_of_the_band(tables):
    """H at 14.42 mag arcsec^-2: 8.3e-5 W m^-2 sr^-1 um^-1 in the zenith, more over the whole sky, less through air."""
    without, with_airglow = (table.value("ambient_radiance", **MOONLESS) for table in tables)
    assert 0.6 < (with_airglow - without) / (8.3e-5 * 0.2) < 2.0


def test_the_file_says_so(tables):
    dark, lit = tables
    assert lit.attributes["night_sky"] == "1" and "night_sky" not in dark.attributes
