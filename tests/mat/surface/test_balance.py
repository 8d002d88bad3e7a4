"""The surface fluxes against published values, limits and their own derivatives."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack
from skyshine.schemas.errors import InputError

LAYER = Layer(0.1, 1.0, 2000.0, 1000.0)
STACK = ThermalStack(LAYER, (LAYER, LAYER), Back("adiabatic"))
SMOOTH = SurfaceProperties(1e-6, 0.0, 0.0, False, False, "plate")


def material(surface=SMOOTH, absorptance=0.7, emissivity=0.9):
    return SurfaceMaterial("plate", STACK, surface, absorptance, emissivity)


def forcing(**changes):
    values = {
        "shortwave_direct": 400.0,
        "shortwave_diffuse": 80.0,
        "shortwave_reflected": 20.0,
        "longwave_sky": 250.0,
        "longwave_ground": 100.0,
        "air_temperature": 290.0,
        "vapour_pressure": 1000.0,
        "pressure": 101325.0,
        "wind_speed": 2.0,
        "cos_slope": 1.0,
    }
    values.update(changes)
    return Forcing(**{name: np.atleast_2d(np.asarray(value, float)) for name, value in values.items()})


@given(st.floats(0, 611), st.floats(0.01, 1), st.floats(0, 40), st.floats(3e4, 1.05e5))
@settings(max_examples=60, deadline=None)
def test_freezing_leaves_the_loss_increasing(vapour, wetness, wind, pressure):
    """However dry the air: a surface with two equilibria would have no one temperature."""
    surface = SurfaceProperties(1e-3, wetness, 0.0, False, False)
    air = forcing(vapour_pressure=vapour, wind_speed=wind, pressure=pressure, air_temperature=272.0)
    _, slope = Balance(air, material(surface)).loss_and_slope(np.linspace(270, 275, 51)[None, :])
    assert np.all(slope > 0)


def test_frost_forms_from_air_that_is_dry_over_water():
    """At -20 C and 90 % over water the air is saturated over ice: frost grows and warms the surface."""
    wet = SurfaceProperties(1e-3, 1.0, 0.0, False, False)
    vapour = 0.9 * saturation_pressure(253.15)
    balance = Balance(forcing(vapour_pressure=vapour, air_temperature=253.15), material(wet))
    assert balance.fluxes(np.array([[253.15]]))["evaporation"][0, 0] < 0


@pytest.mark.parametrize("exposure", ["field", "plate", "roof", "wall"])
@given(st.floats(220, 380), st.floats(0, 1), st.floats(0, 400), st.floats(0, 40), st.floats(-1, 1), st.floats(0, 4000))
@settings(max_examples=60, deadline=None)
def test_slope_is_the_derivative(exposure, temperature, wetness, resistance, wind, tilt, vapour):
    assume(abs(temperature - 290.0) > 0.05)  # at air temperature stability bends like a root: differences err there
    surface = SurfaceProperties(1e-3, wetness, resistance, False, False, exposure)
    balance = Balance(forcing(wind_speed=wind, cos_slope=tilt, vapour_pressure=vapour), material(surface))
    around = np.array([[temperature - 1e-3, temperature, temperature + 1e-3]])
    loss, slope = balance.loss_and_slope(around)
    assert slope[0, 1] == pytest.approx((loss[0, 2] - loss[0, 0]) / 2e-3, rel=2e-3, abs=1e-3)


def test_slope_has_no_step_at_air_temperature():
    surface = SurfaceProperties(1e-3, 0.0, 0.0, False, False, "field")
    balance = Balance(forcing(wind_speed=0.5), material(surface))
    _, slope = balance.loss_and_slope(290.0 + np.array([[-1e-9, 0.0, 1e-9]]))
    assert slope[0, [0, 2]] == pytest.approx(slope[0, 1], rel=1e-4)


def test_convection_never_stands_still_in_air():
    temperature = np.linspace(285, 295, 201)[None, :]
    difference = temperature - 290.0
    ground = material(SurfaceProperties(1e-3, 0.0, 0.0, False, False))
    for kind, cosine, least in ((material(), 1.0, 2.0), (ground, 1.0, 1.0), (ground, -1.0, 2.0)):
        fluxes = Balance(forcing(wind_speed=0.0, cos_slope=cosine), kind).fluxes(temperature)
        size = np.abs(fluxes["convection"])
        assert np.all(size >= least * np.abs(difference) - 1e-9) and np.any(size < 1.2 * least * np.abs(difference))


def test_vacuum_has_neither_convection_nor_evaporation():
    wet = SurfaceProperties(1e-3, 1.0, 0.0, False, False)
    fluxes = Balance(forcing(pressure=0.0), material(wet)).fluxes(np.full((1, 1), 350.0))
    assert fluxes["convection"] == 0 and fluxes["evaporation"] == 0


def test_dew_warms_and_evaporation_cools():
    wet = SurfaceProperties(1e-3, 1.0, 0.0, False, False)
    balance = Balance(forcing(vapour_pressure=1500.0), material(wet))
    colder, warmer = balance.fluxes(np.array([[280.0, 295.0]]))["evaporation"][0]
    assert colder < 0 < warmer


@pytest.mark.parametrize(
    "name, value", [("air_temperature", np.nan), ("shortwave_direct", -5.0), ("wind_speed", np.inf)]
)
def test_forcing_that_cannot_be_is_refused(name, value):
    series = np.full((1, 4), 1.0 if name != "air_temperature" else 290.0)
    series[0, 2] = value
    with pytest.raises(InputError, match=f"{name} = .* in column 0 at time step 2"):
        forcing(**{name: series}).check()


def test_air_in_some_columns_only_is_refused():
    with pytest.raises(InputError, match="pressure 0 in some columns"):
        Balance(forcing(pressure=[[0.0], [1e5]]), material())


def test_absorptance_outside_its_range_is_refused():
    with pytest.raises(InputError, match="solar_absorptance 1.2"):
        material(absorptance=1.2)


SIGMA = 5.670374419e-8


def test_every_part_of_the_light_is_absorbed():
    """0.7 of 400 + 80 + 20 W/m2 of sunlight and 0.9 of 250 + 100 W/m2 of longwave; 0.9 sigma T^4 is emitted."""
    fluxes = Balance(forcing(), material()).fluxes(np.array([[300.0]]))
    assert fluxes["shortwave_absorbed"] == pytest.approx(350.0)
    assert fluxes["longwave_absorbed"] == pytest.approx(315.0)
    assert fluxes["longwave_emitted"] == pytest.approx(0.9 * SIGMA * 300.0**4)


@pytest.mark.parametrize("emissivity", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_a_grey_surface_in_an_isothermal_enclosure_neither_gains_nor_loses(emissivity, share):
    """Kirchhoff: whatever the view of sky and ground, at the temperature of both the net longwave is zero."""
    black = SIGMA * 290.0**4
    enclosure = forcing(
        longwave_sky=share * black,
        longwave_ground=(1 - share) * black,
        shortwave_direct=0.0,
        shortwave_diffuse=0.0,
        shortwave_reflected=0.0,
    )
    loss = Balance(enclosure, material(emissivity=emissivity)).loss(np.array([[290.0]]))
    assert loss == pytest.approx(0.0, abs=1e-6)


def test_the_loss_is_the_sum_of_its_fluxes():
    wet = SurfaceProperties(1e-3, 0.6, 80.0, False, False)
    balance = Balance(forcing(), material(wet))
    temperature = np.linspace(250.0, 330.0, 17)[None]
    fluxes = balance.fluxes(temperature)
    outward = fluxes["longwave_emitted"] + fluxes["convection"] + fluxes["evaporation"]
    net = outward - fluxes["shortwave_absorbed"] - fluxes["longwave_absorbed"]
    assert np.allclose(balance.loss(temperature), net, rtol=0, atol=1e-9)


def test_convection_by_hand():
    """h^3 = 8 + (7.19 (0.723 x 2)^0.78)^3 + (9.482 / 6.238)^3 x 10 for a smooth plate, 10 K warmer, in 2 m/s at 10 m;
    10 K colder the free part is (1.810 / 2.382)^3 x 10."""
    forced = 5.678 * 0.50 * (0.7229474 * 2.0 / 0.3048) ** 0.78
    for temperature, natural in ((300.0, 9.482 / 6.238), (280.0, 1.810 / 2.382)):
        convection = Balance(forcing(), material()).fluxes(np.array([[temperature]]))["convection"][0, 0]
        coefficient = np.cbrt(8.0 + forced**3 + natural**3 * 10.0)
        assert convection == pytest.approx((temperature - 290.0) * coefficient, rel=1e-4)


def test_evaporation_of_a_canopy_by_hand():
    """Penman and Monteith with FAO Paper 56's numbers: grass of 12 cm in 2 m/s, air of 20 C and 50 %, the leaf at air
    temperature: rho cp / gamma (es - e) / (ra + rs). r_s of the stomata is 70 s/m in light of 500 W/m2:
    r_least (1 + 36.35 dq) / (light (1 - 0.0016 5^2)), light = (y + r_least 3 / 5000) / (1 + y), y = 500 / 272.7."""
    vapour = 0.5 * saturation_pressure(293.15)
    dryness, light = 1 + 36.35 * 0.622 * 0.5 * 2339.2 / 101325.0, 500 / (300 / 1.1)
    least = 70.0 * 0.96 * light / (dryness * (1 + light) - 70.0 * 0.96 * 3 / 5000)
    grass = SurfaceProperties(0.123 * 0.12, 1.0, least, True, False)
    air = forcing(air_temperature=293.15, vapour_pressure=vapour, wind_speed=2.0, open_light=500.0)
    evaporation = Balance(air, material(grass)).fluxes(np.array([[293.15]]))["evaporation"][0, 0]
    volumetric = 101325.0 / (287.053 * 293.15) * 1013.0
    resistance = np.log1p(10 / 0.01476) * np.log1p(2 * np.e**2 / 0.01476) / (0.16 * 2.0)
    least = (1.0 + (volumetric / resistance) ** 3 + 0.5 * (9.482 / 6.238) ** 3 * 0.1) ** (1 / 3)
    exact = volumetric / (0.665e-3 * 101325.0) * 0.5 * 2339.2 / (volumetric / least + 70.0)
    assert evaporation == pytest.approx(exact, rel=3e-3)


def test_half_as_wet_evaporates_half_as_much():
    evaporation = [
        Balance(forcing(), material(SurfaceProperties(1e-3, wetness, 50.0, False, False))).fluxes(np.array([[295.0]]))
        for wetness in (1.0, 0.5)
    ]
    assert evaporation[0]["evaporation"] == pytest.approx(2 * evaporation[1]["evaporation"])


def test_single_precision_is_the_same_balance():
    wet = SurfaceProperties(1e-3, 0.6, 80.0, False, False)
    balance = Balance(forcing(), material(wet))
    temperature = np.linspace(265.0, 330.0, 14)[None]
    single = balance.single().loss(temperature.astype(np.float32))
    assert single.dtype == np.float32
    assert np.allclose(single, balance.loss(temperature), rtol=0, atol=6e-3)


def test_columns_of_a_forcing_keep_their_rows():
    several = forcing(air_temperature=[[280.0], [290.0], [300.0]])
    chosen = several.columns(np.array([2, 0]))
    assert chosen.air_temperature[:, 0] == pytest.approx([300.0, 280.0])
    assert chosen.pressure.shape == (1, 1) and chosen.shape == (2, 1)


@pytest.mark.parametrize("difference", [1.0, -1.0])
def test_one_kelvin_from_the_air_the_turn_of_convection_is_over(difference):
    """In still air h^3 = 8 + c^3 |dT| with Walton's c of that side: smoothing changes h by less than 0.1 %."""
    factor = 9.482 / 6.238 if difference > 0 else 1.810 / 2.382
    convection = Balance(forcing(wind_speed=0.0), material()).fluxes(np.array([[290.0 + difference]]))["convection"]
    assert convection == pytest.approx(difference * np.cbrt(8.0 + factor**3), rel=1e-3)
