"""Look-up tables for ISOFIT: known spherical albedo, reciprocity, radiance over grounds that were not fitted."""

from dataclasses import replace

import h5py
import numpy as np
import pytest
from click.testing import CliRunner
from scipy.special import expn

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.spectra.spectrum import line_points
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.commands.lut import command
from skyshine.mat.exchange.isofit import Channels, Lut, point_terms, read_channels, write_lut
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.schemas.errors import InputError

# class Keys of isofit 4.1.5, atmosphere/atmosphere.py
ALL_DIMENSIONS = {"rhoatm", "sphalb", "transm_down_dir", "transm_down_dif", "transm_up_dir", "transm_up_dif"}
ALL_DIMENSIONS |= {"thermal_upwelling", "thermal_downwelling", "dir-dir", "dif-dir", "dir-dif", "dif-dif"}


def lut_of(wavelength, width, **changes):
    channels = tuple(float(value) for value in wavelength)
    given = {"water": (1.0,), "optical_depth": (0.2,), "solar_zenith": 40.0} | changes
    return Lut(channels, (float(width),) * len(channels), **given)


def terms_of(lut, air, zenith=0.0, azimuth=0.0):
    middle, reach = np.array(lut.wavelength), 1.5 * lut.fwhm[0]
    points = AbsorptionTable.open().points(1e7 / (middle[-1] + reach), 1e7 / (middle[0] - reach))
    channels = Channels.of(points, middle, np.array(lut.fwhm))
    return points, channels, point_terms(air, points, channels, lut, zenith, azimuth)


def clear():
    return AtmosphericState.from_profile("midlatitude_summer", aerosol=Aerosol("none"))


def hazy():
    return AtmosphericState.from_profile("midlatitude_summer", aerosol=Aerosol("rural", optical_depth=0.3))


def test_spherical_albedo_of_molecules_is_that_of_6s():
    """CSALBR of 6S (Vermote et al. 1997), with the optical depth of Hansen and Travis 1974."""
    wavelength = np.array([440.0, 480.0, 520.0])
    _, _, terms = terms_of(lut_of(wavelength, 10, aerosol="none"), clear())
    um = wavelength / 1e3
    tau = 0.008569 * um**-4 * (1 + 0.0113 * um**-2 + 0.00013 * um**-4)
    known = (3 * tau - expn(3, tau) * (4 + 2 * tau) + 2 * np.exp(-tau)) / (4 + 3 * tau)
    assert terms["sphalb"] == pytest.approx(known, rel=0.015)


def test_light_goes_up_as_it_comes_down():
    """Reciprocity: scattered transmittance to the sensor is that of the Sun from the sensor's direction."""
    _, _, terms = terms_of(lut_of([500.0], 10, aerosol="none"), clear(), zenith=39.6)  # 40 degrees at the ground
    assert terms["transm_up_dif"] == pytest.approx(terms["transm_down_dif"], rel=0.03)
    assert terms["transm_up_dir"] == pytest.approx(terms["transm_down_dir"], rel=0.005)


@pytest.mark.parametrize("albedo", [0.15, 0.8])
@pytest.mark.parametrize("wavelength", [550.0, 1130.0])
def test_radiance_over_another_ground(albedo, wavelength):
    """The formula of ISOFIT against the line of sight over that ground itself, in haze, beside and in a water band."""
    lut, air = lut_of([wavelength], 20), hazy()
    points, channels, terms = terms_of(lut, air)
    mu = np.cos(np.radians(40.0))
    values, _ = line_points(
        replace(air, surface_albedo=albedo),
        points,
        channels.irradiance,
        altitude=1e5,
        elevation=-np.pi / 2,
        distance=np.inf,
        source_elevation=np.radians(50.0),
        source_azimuth=0.0,
    )
    arriving = mu * values["direct_irradiance"] + values["sky_scattered"]
    seen = values["path_scattered"] + albedo / np.pi * arriving * values["transmittance"]
    known = channels.weight @ (seen * channels.per_nm)
    coupling = sum(terms[name] for name in ("dir-dir", "dif-dir", "dir-dif", "dif-dif"))
    reflectance = terms["rhoatm"] + coupling * albedo / (1 - terms["sphalb"] * albedo)
    assert reflectance * mu * channels.solar / np.pi == pytest.approx(known, rel=0.003)


def test_thermal_radiance_over_another_ground():
    """8.5 and 10 um in haze: emission of the air, the sky in the ground, and the ground's own."""
    lut, air, albedo = lut_of([8500.0, 10000.0], 100), hazy(), 0.3
    points, channels, terms = terms_of(lut, air)
    values, _ = line_points(
        replace(air, surface_albedo=albedo),
        points,
        0 * channels.irradiance,
        altitude=1e5,
        elevation=-np.pi / 2,
        distance=np.inf,
        source_elevation=np.radians(50.0),
        source_azimuth=0.0,
    )
    glow = planck_wavenumber(points.wavenumber, air.surface_temperature)
    leaving = (1 - albedo) * glow + albedo / np.pi * values["sky_thermal"]
    known = channels.weight @ ((values["path_thermal"] + leaving * values["transmittance"]) * channels.per_nm)
    own = (1 - albedo) * (channels.weight @ (glow * channels.per_nm))
    up = terms["transm_up_dir"] + terms["transm_up_dif"]
    back = albedo / (1 - terms["sphalb"] * albedo)
    # L_s of ISOFIT is the ground's emission before light that comes back from the air: 1 / (1 - S rho) of it leaves.
    seen = terms["thermal_upwelling"] + terms["thermal_downwelling"] * back
    seen = seen + up * own / (1 - terms["sphalb"] * albedo)
    assert seen == pytest.approx(known, rel=0.004)


def test_a_file_has_what_isofit_reads(tmp_path):
    path = tmp_path / "lut.nc"
    asked = ["--wavelengths", "860:880:20", "--water", ".5,2", "--optical-depth", ".05,.3", "--observer-zenith", "0,20"]
    result = CliRunner().invoke(command, [*asked, "--out", str(path)], catch_exceptions=False)
    assert result.exit_code == 0
    with h5py.File(path) as file:
        assert set(file) >= ALL_DIMENSIONS | {"wl", "fwhm", "solar_irr", "coszen", "solzen"}
        assert all(file[name].shape == (2, 2, 2, 2) for name in ALL_DIMENSIONS)
        dims = [dim[0].name for dim in file["rhoatm"].dims]
        assert dims == ["/wl", "/H2OSTR", "/AOT550", "/observer_zenith"]
        assert file.attrs["RT_mode"] == "transm" and file.attrs["ISOFIT status"] == "success"
        assert float(file["coszen"][()]) == pytest.approx(np.cos(np.radians(45.0)))
        assert np.all(np.diff(file["transm_down_dir"][()], axis=2) < 0)  # less through more aerosol
        assert all(np.isfinite(file[name][()]).all() for name in ALL_DIMENSIONS)


def test_an_isofit_wavelength_file_is_read(tmp_path):
    (tmp_path / "w.txt").write_text("0 0.40 0.0085\n1 0.41 0.0085\n")
    assert read_channels(tmp_path / "w.txt") == ((400.0, 410.0), (8.5, 8.5))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (["--wavelengths", "900:400:10"], "LOW:HIGH:STEP"),
        (["--wavelengths", "1200:1300:1"], "interval of the band model"),
        (["--wavelengths", "860:880:20", "--water", "2,1"], "H2OSTR: found"),
        (["--wavelengths", "860:880:20", "--water", "a"], "numbers with commas"),
        (["--wavelengths", "860:880:20", "--water", "40"], "water"),
        (["--wavelengths", "860:880:20", "--solar-zenith", "88"], "solar zenith 88"),
        (["--wavelengths", "no_such.txt"], "does not exist"),
    ],
)
def test_what_cannot_be_computed_is_one_line(tmp_path, given, words):
    asked = given if "--water" in given else [*given, "--water", "1"]
    result = CliRunner().invoke(command, [*asked, "--out", str(tmp_path / "lut.nc")])
    assert isinstance(result.exception, InputError) and words in str(result.exception)
    assert not (tmp_path / "lut.nc").exists()


def test_a_wavelength_file_with_a_wrong_line_is_named(tmp_path):
    (tmp_path / "w.txt").write_text("0 400 10\nnothing\n")
    with pytest.raises(InputError, match=r"w\.txt:2: found 'nothing'"):
        read_channels(tmp_path / "w.txt")


def test_points_are_counted(tmp_path):
    counted = []
    lut = lut_of([870.0], 20, water=(1.0, 2.0))
    write_lut(lut, tmp_path / "lut.nc", counted.append)
    assert counted == [1, 1] and lut.size == 2
