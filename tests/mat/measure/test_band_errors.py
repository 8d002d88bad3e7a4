"""The errors that a ``.band`` table states: against other ways to compute them, and noticed where an array is wrong."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.measure.band_errors import band_accuracy
from skyshine.mat.radiometry.blackbody import SpectralResponse, band_radiance
from skyshine.mat.scene.sources import LONGEST_WAVE, solar_spectrum
from skyshine.mat.tables.band import PLANCK_TEMPERATURES, band_group
from skyshine.materials.library import load_library

MATERIALS = ("asphalt_road", "grass_green", "paint_white_on_metal", "glass_window")
PLANCK = ("reflectance_planck", "emissivity_planck")


def table(lower, upper):
    response = SpectralResponse.rectangular(lower, upper)
    library = load_library()
    materials = sorted((library[name] for name in MATERIALS), key=lambda material: material.code)
    return band_group(response, materials, solar_spectrum(LONGEST_WAVE)), response, materials


@pytest.fixture(scope="module")
def thermal():
    return table(8.0, 12.0)


def stated(root, response, materials, seed=1):
    group = band_accuracy(root, response, materials, seed)
    names = [str(name) for name in group.axes["quantity"].values]
    return {name: {key: values.data[row] for key, values in group.variables.items()} for row, name in enumerate(names)}


def test_radiance_between_nodes_errs_by_the_half_of_its_curvature(thermal):
    """Linear interpolation between nodes h apart errs by h^2 / 8 of the second derivative at most."""
    root, response, _ = thermal
    nodes = np.asarray(root.axes["temperature"].values)
    middle = (nodes[1:] + nodes[:-1]) / 2
    radiance = [band_radiance(response, middle + step) for step in (-1.0, 0.0, 1.0)]
    curvature = radiance[0] - 2 * radiance[1] + radiance[2]
    found = stated(*thermal)["blackbody_radiance"]
    assert found["maximum"] == pytest.approx((curvature * 0.5**2 / 8).max(), rel=0.05)
    slope = (radiance[2] - radiance[0]) / 2
    assert found["maximum_kelvin"] == pytest.approx((curvature * 0.5**2 / 8 / slope).max(), rel=0.15)
    assert found["points"] == 1000


def test_error_in_kelvin_is_that_of_the_emitted_light(thermal):
    """An emissivity that is 0.01 too high makes a body at T warmer by 0.01 L / L'."""
    root, response, materials = thermal
    variable = root.variables["emissivity_planck"]
    wrong = replace(
        root, variables=root.variables | {"emissivity_planck": replace(variable, data=variable.data + 0.01)}
    )
    before, after = (stated(one, response, materials)["emissivity_planck"] for one in (root, wrong))
    assert after["rms"] == pytest.approx(0.01, rel=0.1) and after["p99_percent"] == pytest.approx(1.0, abs=0.2)
    span = np.linspace(PLANCK_TEMPERATURES[0], PLANCK_TEMPERATURES[-1], 801)
    radiance = band_radiance(response, span)
    assert after["maximum_kelvin"] == pytest.approx((0.01 * radiance / np.gradient(radiance, span)).max(), rel=0.2)
    assert before["maximum_kelvin"] < after["maximum_kelvin"] / 3


def test_parts_are_cold_ambient_and_hot(thermal):
    group = band_accuracy(*thermal, 1)
    assert list(group.axes["region"].values) == ["cold", "ambient", "hot"]
    points = group.variables["region_points"].data
    names = list(group.axes["quantity"].values)
    for name in ("blackbody_radiance", *PLANCK):
        assert points[names.index(name)].sum() == group.variables["points"].data[names.index(name)]
    hottest = group.variables["region_p99_kelvin"].data
    assert all(hottest[names.index(name), 2] > hottest[names.index(name), 1] for name in PLANCK)  # cells of 200 K


def test_below_2_5_um_errors_are_relative():
    found = stated(*table(0.4, 0.7))
    for name in ("blackbody_radiance", *PLANCK):
        assert np.isnan(found[name]["maximum_kelvin"]) and 0 < found[name]["p99_percent"] < 1


def test_a_mean_over_angles_errs_more_than_the_table_by_angle(thermal):
    root, response, materials = thermal
    found = stated(root, response, materials)
    assert found["normalisation"]["rms"] > found["normalisation_by_angle"]["rms"] > 0
    assert np.isnan(found["normalisation"]["maximum_kelvin"])


@pytest.mark.parametrize("name", ["blackbody_radiance", *PLANCK, "normalisation_by_angle"])
def test_a_wrong_array_shows(thermal, name):
    root, response, materials = thermal
    variable = root.variables[name]
    wrong = replace(root, variables=root.variables | {name: replace(variable, data=variable.data * 1.05 + 1e-3)})
    assert stated(wrong, response, materials)[name]["rms"] > 3 * stated(*thermal)[name]["rms"]
