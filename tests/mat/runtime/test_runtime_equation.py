"""Equation (1) for one pixel from the files alone, against the same radiance computed directly without any table."""

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.job.load import load_job
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.radiometry.blackbody import planck_wavelength
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.sources import source_irradiance
from skyshine.mat.scene.surface import scene_inputs, surface_materials
from skyshine.mat.surface.table import temperature_table
from skyshine.materials.library import load_library

MATERIAL = "asphalt_road"
# A pixel at nodes of the tables, so that what is compared is the arithmetic and not the interpolation.
VIEW = {"range": 1.0, "altitude": 1.0, "elevation": -5.0}
SOURCE_ELEVATION, SOURCE_AZIMUTH, INCIDENCE, OFF_MIRROR = 60.0, 90.0, 35.0, 4.0  # degree
FACE = {"altitude": 1.0, "azimuth": 180.0, "slope": 45.0, "time": 12.0}


def equation_1(temperature_radiance, tau, path_ratio, ambient, direct, rho, specular, shininess, normalisation):
    """The runtime's sum: thermal (6), path (11), skyshine (19), diffuse (34) and specular (35)."""
    lobe = np.cos(np.radians(OFF_MIRROR / 2)) ** shininess
    light = direct * rho * tau * (np.cos(np.radians(INCIDENCE)) * (1 - specular) + lobe * specular * normalisation)
    return temperature_radiance * (1 - rho) * tau + path_ratio * (1 - tau) + ambient * rho * tau + light


@pytest.fixture(scope="module")
def from_files(small_build):
    surface, band, air = (
        skyshine.mat.open(small_build / name) for name in ("s01.htt.h5", "b01.band.h5", "s01b01.atmq.h5")
    )
    sun = {"source_elevation": SOURCE_ELEVATION}
    tau = air.transmittance(range=VIEW["range"], beta_star=air.value("beta_star", **VIEW))
    of = {
        name: band.value(name, material=MATERIAL)
        for name in ("reflectance", "specular_fraction", "shininess", "normalisation")
    }
    return equation_1(
        band.blackbody_radiance(surface.temperature(material=MATERIAL, **FACE)),
        tau,
        air.value("path_radiance_ratio", **VIEW, **sun, source_azimuth=SOURCE_AZIMUTH),
        air.value("ambient_radiance", **VIEW, **sun),
        air.value("direct_radiance", **VIEW, **sun),
        *of.values(),
    )


@pytest.fixture(scope="module")
def job(small_job):
    return load_job(small_job).trimmed


@pytest.fixture(scope="module")
def exact(job):
    """The air of the job at all points of its band."""
    response = response_of(job.bands[0])
    points = points_of_band(absorption_table(), response)
    return BandAtmosphere.of(atmospheric_state(job.site, job.states[0]), points)


def sunlit(job, exact, *place):
    """The quantities at a place, computed directly."""
    return exact.at_points(LinesOfSight(*place), source_irradiance(job, "sun", exact.band.wavenumber))


def direct(job, exact):
    """The radiance without tables: the heat balance of one surface, one line of sight, integrals over the band."""
    material = load_library()[MATERIAL]
    place = ([1e3 * FACE["altitude"]], [FACE["azimuth"]], [FACE["slope"]], [FACE["time"]])
    solved = temperature_table(surface_materials([material]), *scene_inputs(job, 1), *place)
    low, high = job.bands[0].wavelength_um
    wavelength = np.linspace(low, high, 20_001)
    thermal = np.trapezoid(planck_wavelength(wavelength, solved.temperature.item()), wavelength)
    rho = np.trapezoid(np.interp(wavelength, material.wavelength, material.reflectance), wavelength) / (high - low)
    seen = sunlit(job, exact, *VIEW.values(), SOURCE_ELEVATION, SOURCE_AZIMUTH)
    exponent = np.log(0.5) / np.log(np.cos(np.radians(material.lobe_fwhm / 4)))
    factor = np.mean([normalisation_by_sum(exponent, angle) for angle in (0, 15, 30, 45, 60, 75)])
    return equation_1(
        thermal,
        seen.transmittance[0],
        seen.path_radiance_ratio[0],
        seen.ambient[0],
        seen.direct[0],
        rho,
        material.specular_fraction,
        exponent,
        factor,
    )


def normalisation_by_sum(exponent, incidence, count=1500):
    """Equation (43) by a plain sum over the hemisphere."""
    cosine = (np.arange(count) + 0.5) / count
    azimuth = (np.arange(2 * count) + 0.5) * np.pi / (2 * count)
    sine, source = np.sqrt(1 - cosine**2)[:, None], np.radians(incidence)
    along_mirror = sine * np.cos(azimuth) * np.sin(source) + cosine[:, None] * np.cos(source)
    chi = np.sqrt(np.clip((1 + along_mirror) / 2, 0, 1))  # (41)
    solid_angle = 2 * np.sum(chi**exponent) * (1 / count) * (np.pi / (2 * count))
    return 2 * np.pi * np.cos(source) / solid_angle


def test_one_pixel_from_the_files_alone(job, exact, from_files):
    assert from_files == pytest.approx(direct(job, exact), rel=2e-3)  # the tolerance of the compiled band


def test_off_the_nodes_the_radiance_stays_within_the_stated_errors(job, exact, small_build):
    air = skyshine.mat.open(small_build / "s01b01.atmq.h5")
    place = {"range": 2.7, "altitude": 0.6, "elevation": -4.0, "source_elevation": 47.0, "source_azimuth": 130.0}
    seen = sunlit(job, exact, *place.values())
    read = air.value("path_radiance_ratio", **place)
    assert abs(read - seen.path_radiance_ratio[0]) <= air.error("path_radiance_ratio")["maximum"] * 1.5
