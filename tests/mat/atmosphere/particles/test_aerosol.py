"""Aerosol models against published figures, conservation and bounds."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles import aerosol_column, windblown
from skyshine.mat.atmosphere.particles.aerosol import FOGS, MODELS, AerosolModel
from skyshine.mat.atmosphere.particles.aerosol_column import SEASONS, Aerosol, aerosol_extinction_550, aerosol_layers
from skyshine.mat.atmosphere.particles.particles import between_wavelengths
from skyshine.schemas.errors import InputError

WAVELENGTHS = np.geomspace(0.2, 1000, 80)


@pytest.fixture(params=MODELS)
def model(request):
    return AerosolModel.load(request.param)


def test_rural_figures_of_shettle_and_fenn():
    """AFGL-TR-79-0214: rural extinction at 10 um; single-scattering albedo at 0.55 um 0.94 dry, 0.985 to 0.99 at 99
    %.
    """
    rural = AerosolModel.load("rural")
    optics = rural.optics(1e4 / np.array([0.55, 10.0, 10.591]), [0.0, 70.0, 80.0, 99.0])
    np.testing.assert_allclose(optics.extinction[:, 0], 1.0)
    np.testing.assert_allclose(optics.extinction[:, 1], [0.09152, 0.09032, 0.08741, 0.11070], rtol=1e-6)
    np.testing.assert_allclose(optics.single_scattering_albedo[[0, 3], 0], [0.941, 0.987], atol=3e-3)


@pytest.mark.parametrize(
    ("name", "humidity", "wavelength", "extinction", "absorption", "asymmetry"),
    # Printed by LOWTRAN7 itself (subroutines EXABIN and AEREXT).
    [
        ("rural", 95.0, 0.8, 6.90150e-1, 2.25031e-2, 7.14697e-1),
        ("rural", 95.0, 11.3, 8.41496e-2, 5.00776e-2, 8.20104e-1),
        ("maritime", 50.0, 4.5, 2.85940e-1, 1.12879e-2, 6.95799e-1),
        ("urban", 75.0, 0.8, 6.86412e-1, 1.93421e-1, 6.88217e-1),
        ("urban", 75.0, 11.3, 8.18667e-2, 5.30344e-2, 7.41943e-1),
    ],
)
def test_optics_of_lowtran7(name, humidity, wavelength, extinction, absorption, asymmetry):
    """LOWTRAN7 is linear between its wavelengths; at these both must agree."""
    model = AerosolModel.load(name)
    optics = model.optics(1e4 / model.wavelength, [humidity])
    absorbed = optics.extinction * (1 - optics.single_scattering_albedo)
    for ours, theirs in ((optics.extinction, extinction), (absorbed, absorption), (optics.asymmetry, asymmetry)):
        assert np.interp(wavelength, model.wavelength, ours[0]) == pytest.approx(theirs, rel=1e-5)


def test_extinction_follows_a_power_law_between_wavelengths():
    """Angstrom 1929: of a table that is one power law, its slope holds everywhere, for absorption too."""
    nodes = np.array([0.3, 0.55, 1.06, 4.0])
    wavelength = np.geomspace(0.3, 4.0, 40)
    extinction, albedo = between_wavelengths(nodes, nodes**-1.3, 0.2 * nodes**-0.9, wavelength)
    np.testing.assert_allclose(extinction, wavelength**-1.3, rtol=1e-13)
    np.testing.assert_allclose(extinction * (1 - albedo), 0.2 * wavelength**-0.9, rtol=1e-13)
    beyond, same = between_wavelengths(nodes, nodes**-1.3, 0.2 * nodes**-0.9, np.array([8.0]))
    assert beyond[0] == pytest.approx(0.5 * 4.0**-1.3) and same[0] == pytest.approx(albedo[-1])


def test_beside_a_wavelength_without_absorption_albedo_stays_between_its_ends():
    nodes = np.array([0.5, 1.0, 2.0, 4.0])
    wavelength = np.geomspace(0.5, 4.0, 31)
    _, albedo = between_wavelengths(nodes, np.array([1.0, 5.0, 1.0, 0.1]), np.array([0.0, 0.0, 1.0, 0.1]), wavelength)
    np.testing.assert_array_equal(albedo[wavelength <= 1.0], 1.0)
    assert np.all(np.diff(albedo) <= 0)
    assert albedo[-1] == 0
    assert np.interp(np.sqrt(2.0), wavelength, albedo) == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize(
    ("season", "visibility", "altitude", "extinction"),
    # Printed by LOWTRAN7 itself (subroutine AERPRF), km^-1.
    [
        ("spring_summer", 15.0, 1e3, 2.13931e-1),
        ("spring_summer", 15.0, 7e3, 6.23000e-3),
        ("spring_summer", 15.0, 20e3, 5.89000e-4),
        ("fall_winter", 60.0, 1e3, 3.33222e-2),
        ("fall_winter", 60.0, 3e3, 9.15679e-3),
        ("fall_winter", 60.0, 45e3, 4.01000e-6),
    ],
)
def test_profile_of_lowtran7(season, visibility, altitude, extinction):
    assert aerosol_extinction_550([altitude], visibility, season)[0] * 1e3 == pytest.approx(extinction, rel=1e-5)


def test_optics_are_bounded(model):
    optics = model.optics(1e4 / WAVELENGTHS, [0.0, 35.0, 70.0, 98.0, 99.9, 100.0, 150.0])
    assert np.all((optics.extinction > 0) & np.isfinite(optics.extinction))
    assert np.all((optics.single_scattering_albedo >= 0) & (optics.single_scattering_albedo <= 1))
    assert np.all(np.abs(optics.asymmetry) < 1)
    np.testing.assert_allclose(
        optics.extinction[-3], optics.extinction[-1], rtol=1e-12
    )  # beyond 99 %; rows of a product may round apart


def test_phase_function_conserves_energy(model):
    """Mean over the sphere is 1 at any wavelength and humidity, between the tabulated ones too."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    edges = np.radians(model.phase_angle)  # a kink at each: integrate piecewise
    half = 0.5 * np.diff(edges)
    theta = (edges[:-1] + half)[:, None] + half[:, None] * nodes
    measure = 0.5 * np.sin(theta) * half[:, None] * weights
    phase = model.phase_function(np.cos(theta.ravel()), 1e4 / WAVELENGTHS, [0.0, 63.0, 90.0, 100.0])
    np.testing.assert_allclose(np.tensordot(measure.ravel(), phase, 1), 1.0, rtol=1e-6)
    assert phase.min() > 0


def test_phase_function_is_continuous_and_forward(model):
    cosine = np.cos(np.radians(np.linspace(0, 180, 3601)))
    phase = model.phase_function(cosine, [1e4 / 0.55], [50.0])[:, 0, 0]
    # No jump in a twentieth of a degree; droplets of fog have forward peaks of a degree.
    assert np.abs(np.diff(np.log(phase))).max() < (0.3 if model.name in FOGS else 0.15)
    assert phase[0] > 10 * phase[-1]


def test_phase_function_belongs_to_its_model(model):
    """The mean cosine follows the tabulated asymmetry: no model has another's phase functions."""
    edges = np.radians(np.arange(0, 180.01, 0.1))
    middle = 0.5 * (edges[1:] + edges[:-1])
    measure = 0.5 * np.sin(middle) * np.diff(edges)
    wavenumber = 1e4 / model.phase_wavelength
    phase = model.phase_function(np.cos(middle), wavenumber, model.humidity)
    mean_cosine = np.tensordot(measure * np.cos(middle), phase, 1)
    assert np.abs(mean_cosine - model.optics(wavenumber, model.humidity).asymmetry).max() < 0.15


@pytest.mark.parametrize("visibility", [0.1, 1.0, 5.0, 23.0, 50.0, 300.0])
@pytest.mark.parametrize("season", SEASONS)
def test_visibility_at_the_ground(visibility, season):
    """Koschmieder: the contrast of a dark object at the visibility is 2 %."""
    ground = aerosol_extinction_550([0.0], visibility, season)[0]
    assert np.exp(-(ground + 1.159e-5) * visibility * 1e3) == pytest.approx(0.02, rel=1e-3)
    profile = aerosol_extinction_550(np.linspace(0, 100e3, 401), visibility, season)
    # The upper troposphere keeps its 1e-2 km-1 however clear the ground is.
    assert np.all((profile > 0) & (profile <= max(ground, 1e-5)))


def test_visibility_orders_extinction():
    altitude = np.linspace(0, 9e3, 50)
    profiles = np.array(
        [aerosol_extinction_550(altitude, v, "spring_summer") for v in (0.1, 0.7, 2, 5, 8, 10, 23, 40, 50, 90, 300)]
    )
    assert np.all(np.diff(profiles, axis=0) <= 0)


def test_profile_ends():
    values = aerosol_extinction_550([-400.0, 0.0, 100e3, 100.001e3, 1e7], 23.0, "fall_winter")
    assert values[0] == values[1]
    assert values[2] == pytest.approx(9.31e-13, rel=1e-6, abs=0)
    assert np.all(values[3:] == 0)


def test_high_ground_squeezes_the_profile():
    flat = aerosol_extinction_550([0.0, 7e3], 23.0, "spring_summer")
    high = aerosol_extinction_550([1500.0, 7e3], 23.0, "spring_summer", ground_altitude=1500.0)
    np.testing.assert_allclose(high, flat)


def test_layers_share_out_the_whole_extinction():
    altitude = np.array([0.0, 1999.0, 2500.0, 5e3, 10.4e3, 20e3, 32e3, 60e3, 120e3])
    layers = aerosol_layers(altitude, Aerosol("urban"), 23.0, "spring_summer")
    assert [model.name for model, _ in layers] == ["urban", "tropospheric", "stratospheric_background", "meteoric_dust"]
    total = sum(extinction for _, extinction in layers)
    np.testing.assert_allclose(total, aerosol_extinction_550(altitude, 23.0, "spring_summer"))
    assert layers[0][1][3] == 0 and layers[1][1][0] == 0
    troposphere = layers[1][0]
    np.testing.assert_array_equal(
        troposphere.optics([1000.0], [99.0]).extinction,
        AerosolModel.load("tropospheric").optics([1000.0], [70.0]).extinction,
    )


def test_vertical_optical_depth():
    """A 23 km rural column has an optical depth near 0.3 at 0.55 um (LOWTRAN7 user guide, spring-summer)."""
    altitude = np.linspace(0, 100e3, 20001)
    depth = np.trapezoid(aerosol_extinction_550(altitude, 23.0, "spring_summer"), altitude)
    assert 0.28 < depth < 0.36


def test_no_aerosol():
    assert aerosol_layers(np.array([0.0, 1e3]), Aerosol("none"), 23.0, "spring_summer") == []


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: AerosolModel.load("rurl"), "did you mean 'rural'"),
        (lambda: aerosol_extinction_550([0.0], 0.05, "spring_summer"), "visibility 0.05 km is outside 0.1 to 300 km"),
        (lambda: aerosol_extinction_550([0.0], np.nan, "spring_summer"), "visibility"),
        (lambda: aerosol_extinction_550([0.0], 23.0, "summer"), "spring_summer, fall_winter"),
        (lambda: aerosol_extinction_550([np.nan], 23.0, "fall_winter"), "altitude"),
        (lambda: aerosol_extinction_550([7e3], 23.0, "fall_winter", ground_altitude=6.5e3), "ground altitude"),
        (lambda: AerosolModel.load("rural").optics([60000.0], [50.0]), "up to 50000 cm-1"),
        (lambda: AerosolModel.load("rural").optics([0.0], [50.0]), "cm-1"),
        (lambda: AerosolModel.load("rural").optics([1000.0], [np.nan]), "humidity"),
        (lambda: AerosolModel.load("rural").phase_function([1.1], [1000.0], [50.0]), "cosine"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError, match=message):
        call()


# LOWTRAN7's own table (BLOCK DATA DSTDTA): extinction at 0.55 and 10.591 um for winds of 10 and 20 m/s, km^-1.
def test_desert_aerosol_follows_the_wind():
    for wind, visible, infrared in ((10.0, 5.7144e-2, 2.1475e-2), (20.0, 2.2773e-1, 2.0910e-1)):
        model = windblown.desert_model(wind)
        optics = model.optics(np.array([1e4 / 0.55, 1e4 / 10.591]), np.array([50.0]))
        assert optics.extinction[0] == pytest.approx([1.0, infrared / visible], rel=1e-3)
        assert aerosol_column.default_visibility("desert", wind) == pytest.approx(3.912 / (visible + 0.01159))
    between = windblown.desert_model(15.0).optics(np.array([1e4 / 10.591]), np.array([50.0]))
    assert between.extinction[0, 0] == pytest.approx(np.sqrt(2.1475 * 20.910) / np.sqrt(5.7144 * 22.773), rel=1e-3)
    with pytest.raises(InputError, match="outside 0 to 30 m/s"):
        windblown.desert_model(31.0)


@pytest.mark.parametrize("name", aerosol_column.STRATOSPHERES)
def test_volcanoes_lade_the_stratosphere_alone(name):
    altitude = np.array([0.0, 5e3, 20e3, 40e3, 90e3])
    layers = aerosol_layers(altitude, Aerosol(stratosphere=name), 23.0, "spring_summer")
    background = aerosol_layers(altitude, Aerosol(), 23.0, "spring_summer")
    ours, plain = (sum(extinction for _, extinction in part) for part in (layers, background))
    assert ours[[0, 1, 3, 4]] == pytest.approx(plain[[0, 1, 3, 4]])
    # Extinction at 20 km, spring and summer, km^-1: BASTSS, VUMOSS, HIVUSS, EXVUSS of LOWTRAN7.
    at_20_km = {"background": 5.89e-4, "moderate": 1.35e-3, "high": 1.17e-2, "extreme": 1.00e-1}
    assert ours[2] == pytest.approx(at_20_km[name.split("_")[0]] * 1e-3)


def test_each_boundary_model_has_a_visibility_and_a_phase_function():
    cosine = np.cos(np.radians(np.linspace(0, 180, 3601)))
    for name in aerosol_column.BOUNDARY_MODELS:
        assert 0.1 <= aerosol_column.default_visibility(name) <= 300
        model = aerosol_column.boundary_model(name)
        phase = model.phase_function(cosine, np.array([1000.0, 18182.0]), np.array([0.0, 90.0]))
        assert np.all(phase > 0)
        assert 0.5 * np.trapezoid(phase, -cosine, axis=0) == pytest.approx(1.0, abs=3e-3)


def test_sea_spray_grows_with_wind_and_humidity():
    """Gathman 1983: its amounts grow with air mass and wind, its particles with humidity."""
    sight = [aerosol_column.default_visibility("navy_maritime", wind, 80.0) for wind in (2.0, 10.0, 20.0)]
    assert sight[0] > sight[1] > sight[2] > 1.0
    moist = [aerosol_column.default_visibility("navy_maritime", 10.0, humidity) for humidity in (50.0, 80.0, 98.0)]
    assert moist[0] > moist[1] > moist[2]
    coasts = [aerosol_column.default_visibility("navy_maritime", 10.0, 80.0, air_mass) for air_mass in (1, 5, 10)]
    assert coasts[0] > coasts[1] > coasts[2]
    for arguments, message in (((-1.0, 3), "wind speed -1"), ((5.0, 11), "air mass 11 is not allowed")):
        with pytest.raises(InputError, match=message):
            windblown.navy_maritime_model(*arguments)


def test_models_change_over_at_the_heights_of_lowtran():
    """LOWTRAN7's regions: 0 to 2, 2 to 10, 10 to 30 and 30 to 100 km, with the level above each for the change."""
    levels = np.array([0.0, 2e3, 3e3, 10e3, 11e3, 30e3, 35e3, 60e3])
    extinctions = [part for _, part in aerosol_layers(levels, Aerosol("rural"), 23.0, "spring_summer")]
    assert [np.flatnonzero(part > 0).tolist() for part in extinctions] == [[0, 1], [2, 3], [4, 5], [6, 7]]
    total = aerosol_extinction_550(levels, 23.0, "spring_summer", 0.0, "background")
    np.testing.assert_allclose(sum(extinctions), total, rtol=1e-12)
