"""Exact conduction against closed forms: damping depth, transfer matrices, and the order of the time schemes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skyshine.mat.surface import conduction as module
from skyshine.mat.surface.conduction import Conduction, depth_response, frequencies, surface_admittance
from skyshine.materials.records import Back, Layer, ThermalStack
from skyshine.schemas.errors import InputError

DAY = 86400.0
OMEGA = 2 * np.pi / DAY
NO_SKIN = Layer(0.0, 1.0, 1.0, 1.0)


@pytest.fixture
def solid():
    """Semi-infinite, k = 1 W/mK, rho c = 2e6 J/m3K."""
    return ThermalStack(
        NO_SKIN, (Layer(0.1, 1.0, 2000.0, 1000.0), Layer(np.inf, 1.0, 2000.0, 1000.0)), Back("adiabatic")
    )


@pytest.fixture
def wall():
    """Concrete over insulation, indoor air behind."""
    layers = (Layer(0.1, 1.4, 2100.0, 880.0), Layer(0.05, 0.035, 30.0, 1400.0))
    return ThermalStack(NO_SKIN, layers, Back("convective", 293.0, 8.0))


def test_temperature_wave_in_a_semi_infinite_solid(solid):
    """Damping depth sqrt(2 k / (omega rho c)) = 0.117265 m."""
    (response,), _ = depth_response(solid, [1j * OMEGA], 0.10)
    assert abs(response) == pytest.approx(0.426232, abs=5e-7)
    assert -np.angle(response) / OMEGA / 3600 == pytest.approx(3.2574, abs=5e-5)
    depth = 0.05
    (shallow,), _ = depth_response(solid, [1j * OMEGA], depth)
    assert -depth / np.log(abs(shallow)) == pytest.approx(0.117265, abs=5e-7)


def test_depth_below_the_interface_of_equal_layers(solid):
    (response,), _ = depth_response(solid, [1j * OMEGA], 0.3)
    assert response == pytest.approx(np.exp(-(1 + 1j) * 0.3 / 0.117265), rel=1e-4)


def test_flux_wave_into_a_semi_infinite_solid(solid):
    """The flux leads the temperature by an eighth of a period; |Y| = sqrt(omega k rho c)."""
    (admittance,) = surface_admittance(solid, [1j * OMEGA])
    assert np.degrees(np.angle(admittance)) == pytest.approx(45.0, abs=1e-9)
    assert abs(admittance) == pytest.approx(12.0600, abs=5e-5)


def test_two_layer_wall(wall):
    steady, wave = surface_admittance(wall, [0.0, 1j * OMEGA])
    assert steady.real == pytest.approx(0.61538, abs=5e-6)
    assert abs(wave) == pytest.approx(12.3128, abs=5e-5)
    assert np.degrees(np.angle(wave)) == pytest.approx(70.519, abs=5e-4)


def test_steady_profile_of_the_wall(wall):
    """Resistances in series: 0.1/1.4 of 1/0.61538 lies in the concrete."""
    (interface,), _ = depth_response(wall, [0.0], 0.1)
    assert interface.real == pytest.approx(1 - 0.61538 * 0.1 / 1.4, abs=1e-5)


def test_fixed_back_at_zero_frequency_is_the_series_conductance():
    layers = (Layer(0.1, 1.0, 2000.0, 1000.0), Layer(0.3, 0.5, 1000.0, 1000.0))
    stack = ThermalStack(NO_SKIN, layers, Back("fixed"))
    assert surface_admittance(stack, [0.0])[0] == pytest.approx(1 / 0.7)
    assert np.ravel(depth_response(stack, [0.0], 0.4)) == pytest.approx([0.0, 1.0], abs=1e-12)


def test_thin_stack_is_its_heat_capacity():
    """A millimetre of aluminium stores as one temperature: Y = s C."""
    metal = Layer(5e-4, 200.0, 2700.0, 900.0)
    stack = ThermalStack(metal, (metal, metal), Back("adiabatic"))
    (admittance,) = surface_admittance(stack, [1j * OMEGA])
    assert admittance.imag == pytest.approx(OMEGA * 1.5e-3 * 2.43e6, rel=1e-6)
    assert admittance.real < 1e-6


@pytest.mark.parametrize("thickness", [1e-9, 1e-4, 0.01, 1.0, 1e4])
def test_admittance_is_continuous_across_its_series_and_its_limit(thickness):
    """Halves of a layer make the layer, whatever branch of tanh each falls in."""

    def stack(*parts):
        return ThermalStack(
            NO_SKIN, tuple(Layer(part, 0.5, 1500.0, 1000.0) for part in parts), Back("convective", 290, 5)
        )

    s = 1j * OMEGA * np.logspace(-6, 4, 60)
    whole, halves = (surface_admittance(stack(*parts), s) for parts in ((thickness, 0.0), (thickness / 2,) * 2))
    assert np.allclose(whole, halves, rtol=1e-12)


@given(
    st.floats(-5, 2), st.floats(-2, 2.5), st.floats(-5, 2), st.floats(-2, 2.5), st.sampled_from(["adiabatic", "fixed"])
)
@settings(max_examples=60, deadline=None)
def test_admittance_is_passive(log_d1, log_k1, log_d2, log_k2, kind):
    """No stack gives out more heat than it took: Re Y >= 0 at all frequencies of every scheme."""
    layers = tuple(Layer(10**d, 10**k, 1000.0, 1000.0) for d, k in ((log_d1, log_k1), (log_d2, log_k2)))
    stack = ThermalStack(Layer(1e-3, 1.0, 1000.0, 1000.0), layers, Back(kind))
    for scheme in ("spectral", "bdf2", "euler"):
        admittance = surface_admittance(stack, frequencies(96, DAY, scheme))
        assert np.all(np.isfinite(admittance))
        assert np.all(admittance.real >= -1e-9 * np.abs(admittance))


@pytest.mark.parametrize("scheme, order", [("bdf2", 2), ("euler", 1)])
def test_order_of_convergence(solid, scheme, order):
    """Halving the step divides the error of a daily wave's flux by 2^order; the spectral scheme has none."""
    errors = []
    for steps in (96, 192):
        wave = np.exp(1j * OMEGA * np.arange(steps) * DAY / steps)
        exact = (surface_admittance(solid, [1j * OMEGA])[0] * wave).real
        errors.append(np.abs(Conduction(solid, steps, DAY, scheme).flux(wave.real) - exact).max())
        assert np.allclose(Conduction(solid, steps, DAY, "spectral").flux(wave.real), exact, atol=1e-9)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.06)


def test_matrix_and_relaxation_agree_with_the_transform(wall):
    conduction = Conduction(wall, 96, DAY)
    series = np.random.default_rng(3).normal(size=(4, 96))
    flux = conduction.flux(series)
    assert np.allclose(series @ conduction.matrix.T, flux, atol=1e-9)
    assert np.allclose(conduction.relax(flux + 7.0 * series, 7.0), series, atol=1e-9)


def test_depth_outside_the_stack_is_refused(wall):
    with pytest.raises(InputError, match="allowed: 0 to the thickness"):
        depth_response(wall, [1j * OMEGA], 0.2)


def test_heat_from_inside_arrives_whole_when_steady_and_damped_when_not():
    """Steady heat passes an insulated stack whole; a daily wave through 0.1 m of a solid and an equal layer keeps
    1 / cosh(x), x = (1 + i) d / 0.117265 m, with nothing drawn at the surface but the layer's own."""
    half = Layer(0.05, 1.0, 2000.0, 1000.0)
    stack = ThermalStack(NO_SKIN, (half, half), Back("heated", heat_flux=100.0))
    conduction = Conduction(stack, 96, DAY, "spectral")
    assert conduction.steady_transfer == pytest.approx(1.0) and conduction.steady_conductance == pytest.approx(0.0)
    wave = np.cos(2 * np.pi * np.arange(96) / 96)
    arrived = np.fft.rfft(conduction.from_back(100.0 + 50.0 * wave)) / 48
    assert arrived[0].real / 2 == pytest.approx(100.0)
    assert arrived[1] == pytest.approx(50.0 / np.cosh((1 + 1j) * 0.1 / 0.1172648), rel=1e-5)


def test_deep_temperature_reaches_the_surface_through_resistances():
    """Fixed: k / d of each layer in series; convective: the coefficient in series with them."""
    layers = (Layer(0.1, 1.0, 2000.0, 1000.0), Layer(0.3, 0.5, 1000.0, 1000.0))
    for boundary, resistance in ((Back("fixed", 300.0), 0.7), (Back("convective", 300.0, 5.0), 0.9)):
        conduction = Conduction(ThermalStack(NO_SKIN, layers, boundary), 24, DAY)
        assert conduction.steady_transfer == pytest.approx(1 / resistance)
        assert conduction.steady_conductance == pytest.approx(1 / resistance)
        assert conduction.from_back(np.full(24, 300.0)) == pytest.approx(300.0 / resistance)


def test_the_skin_adds_its_capacity():
    """2 mm of 2e6 J/m3K at the frequency of a day: i omega 4000 J/m2K more."""
    layers = (Layer(0.1, 1.0, 2000.0, 1000.0), Layer(np.inf, 1.0, 2000.0, 1000.0))
    bare, covered = (
        surface_admittance(ThermalStack(skin, layers, Back("adiabatic")), [1j * OMEGA])[0]
        for skin in (NO_SKIN, Layer(2e-3, 1.0, 2000.0, 1000.0))
    )
    assert covered - bare == pytest.approx(1j * OMEGA * (4000.0 - 0.0), rel=1e-9)


def test_transforms_and_matrix_give_one_flux(wall):
    """Above 192 steps the flux is computed by Fourier transforms."""
    series = np.random.default_rng(4).normal(size=(2, 288))
    conduction = Conduction(wall, 288, DAY)
    assert np.allclose(conduction.flux(series), series @ conduction.matrix.T, atol=1e-8)


@pytest.mark.parametrize("steps, coefficients", [(8, (1.5, -2.0, 0.5)), (48, (1.5, -2.0, 0.5))])
def test_bdf2_is_the_backward_difference_of_a_capacity(steps, coefficients):
    """A thin plate of 1000 J/m2K draws C (3/2 T_n - 2 T_n-1 + 1/2 T_n-2) / dt; backward Euler C (T_n - T_n-1) / dt."""
    metal = Layer(1e-6, 400.0, 1000.0, 1e-6 * 1000)
    stack = ThermalStack(Layer(1e-3, 1.0, 1000.0, 1000.0), (metal, metal), Back("adiabatic"))
    series, step = np.random.default_rng(5).normal(size=steps), DAY / steps
    lagged = [np.roll(series, lag) for lag in range(3)]
    exact = 1000.0 * sum(c * values for c, values in zip(coefficients, lagged, strict=True)) / step
    assert Conduction(stack, steps, DAY, "bdf2").flux(series) == pytest.approx(exact, rel=1e-6, abs=1e-9)
    euler = 1000.0 * (lagged[0] - lagged[1]) / step
    assert Conduction(stack, steps, DAY, "euler").flux(series) == pytest.approx(euler, rel=1e-6, abs=1e-9)


def test_an_unknown_scheme_is_named():
    with pytest.raises(ValueError, match="unknown scheme 'rk4': one of spectral, bdf2, euler"):
        frequencies(8, DAY, "rk4")


@pytest.mark.parametrize("size", [9.9e-3, 5e-3, 1e-3])
@pytest.mark.parametrize("angle", [0.0, np.pi / 4])
def test_the_series_of_tanh_is_exact_to_rounding(size, angle):
    """Where the series takes over from the function itself, both agree to 2e-15."""
    x = np.array([size * np.exp(1j * angle)])
    assert abs(module._tanh_ratio(x)[0] - np.tanh(x[0]) / x[0]) < 2e-15
