"""Light among particles against PythonicDISORT: fog, rain, water cloud, cirrus and haze, in kelvin and percent.

The truth takes the levels, gases and particles of the same state at one monochromatic point and computes layers,
moments and radiances itself (``plane_parallel.py``), with as many streams as its own radiances ask for. It is plane; so
is the air here, over a planet of forty times the radius of the Earth. ``pip install pythonicdisort`` brings the
truth; the tables are printed with ``-s``.

Close to the Sun discrete ordinates of steep phase functions do not settle: there the truth is a Monte Carlo in the same
layers (``plane_monte_carlo.py``, with numba).
"""

from functools import cache
from itertools import product

import numpy as np
import plane_parallel
import pytest

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.particles.rain import RainLayer
from skyshine.mat.atmosphere.spectra.spectrum import line_spectrum
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.radiometry.blackbody import planck_wavenumber

pytest.importorskip("PythonicDISORT")

pytestmark = [pytest.mark.validation, pytest.mark.usefixtures("plane_earth")]

CASES = {
    "clear": {"aerosol": Aerosol("none")},
    "haze": {"aerosol": Aerosol("rural", visibility_km=5.0)},
    "fog": {"aerosol": Aerosol("fog_radiation")},
    "rain": {"rain": RainLayer(10.0, 3e3)},
    "cloud 1": {"clouds": [CloudLayer("water", 1e3, 2e3, 10.0, 1.0)]},
    "cloud 3": {"clouds": [CloudLayer("water", 1e3, 2e3, 10.0, 3.0)]},
    "cloud 20": {"clouds": [CloudLayer("water", 1e3, 2e3, 10.0, 20.0)]},
    "cirrus": {"clouds": [CloudLayer("ice", 9.5e3, 11e3, 30.0, 0.5)]},
}
THERMAL, SOLAR = (3.85, 8.5, 10.6), (0.65, 1.6, 3.85)  # um
STREAMS = 32
SUN = 1e6  # W m^-2 per cm^-1: no thermal light beside it
OBSERVER = 20e3  # m, above all particles but those of the stratosphere
VIEWS = (0.99, 0.88, 0.73, 0.45, 0.27)  # cosines of five directions; the truth's nodes nearest to them are taken
ASIDE = np.radians([0.0, 60.0, 180.0])  # azimuth of the line of sight from the Sun
# The Sun's zenith angle off that of a line of sight: directions within 3 degrees of it, and next to them.
SUNS = ((0.88, 1.0), (0.45, 2.5))
KELVIN, OUTSIDE, WITHIN = 0.3, 0.03, 0.08
AUREOLE = 3.0  # degree
# Whose light from below, up to this far from the Sun, differs between 32, 64 and 128 streams.
UNSETTLED = 25.0
AUREOLES = [("fog", 0.65), *product(("rain", "cirrus", "cloud 1", "cloud 3"), SOLAR)]
# Beyond the limit of 3 %, all at 3.85 um from below, where light is faintest: 30 degrees from the Sun and more.
BEYOND = {("rain", 3.85): 0.04, ("cloud 1", 3.85): 0.05, ("cloud 3", 3.85): 0.035}
# Degrees from the Sun, in its plane, and photons.
OFF, PHOTONS = (1.0, 2.0, 5.0, 8.0, 12.0), 100000


def state_of(case):
    return AtmosphericState.from_profile("midlatitude_summer", surface_albedo=0.0, **CASES[case])


def point_at(micron, state):
    """The most transparent spectral point of the interval at a wavelength: the one that sees the particles."""
    points = AbsorptionTable.open().points(1e4 / micron - 0.5, 1e4 / micron + 0.5)
    gases = points.cross_sections(state.pressure, state.temperature, state.mole_fraction["H2O"])
    ground = sum(section[0] * state.mole_fraction[gas.removesuffix("_continuum")][0] for gas, section in gases.items())
    return points.subset(np.array([int(np.argmin(ground))]))


@cache
def scene(case, micron):
    """State, spectral point and the truth's layers of a case."""
    state = state_of(case)
    point = point_at(micron, state)
    return state, point, plane_parallel.layers_of(state, point)


def seen(state, point, altitude, cosine, *, sun=0.0, elevation=0.5, azimuth=0.0):
    """Our spectrum of the line of sight along which light of one cosine (positive upward) comes to an altitude."""
    line = line_spectrum(
        state,
        point,
        np.array([sun]),
        altitude=altitude,
        elevation=float(-np.arcsin(cosine)),
        distance=np.inf,
        source_elevation=elevation,
        source_azimuth=azimuth,
    )
    at = point.interval[0]
    return {
        name: float(getattr(line, name)[at])
        for name in ("transmittance", "path_thermal", "path_scattered", "sky_irradiance", "direct_irradiance")
    }


def nodes_of(streams):
    """Numbers of the truth's directions that are looked along."""
    return [int(np.argmin(np.abs(plane_parallel.cosines(streams) - view))) for view in VIEWS]


def observer_of(state):
    """The level nearest the observer."""
    return state.altitude[np.argmin(np.abs(state.altitude - OBSERVER))]


def thermal_truth(state, point, layers, streams=STREAMS):
    ground = planck_wavenumber(point.interval_edges.mean(axis=1)[point.interval], state.surface_temperature)[0]
    return plane_parallel.solve(layers, streams, ground=ground)


def solar_layers(state, layers):
    """The truth's layers, those without much of a particle put together."""
    dense = np.zeros(state.altitude.size, bool)
    for component in state.particles:
        dense |= component.extinction_550 > 0.2 * max(component.extinction_550.max(), 1e-5)
    groups = plane_parallel.by_particles(layers, observer_of(state), (dense[:-1] | dense[1:])[::-1])
    return plane_parallel.merged(layers, groups)


@pytest.mark.parametrize(
    ("depth", "reflected", "diffuse", "direct"),
    [
        (1.0, 2.47374e-1, 1.73849, 1.15573),
        (8.0, 1.59096, 1.54958, 1.05389e-3),
    ],
)
def test_the_truth_gives_the_fluxes_of_disorts_own_test_problem(depth, reflected, diffuse, direct):
    """Problem 3 of DISORT's test suite (Stamnes et al. 2000, DISORT report v1.1): Henyey and Greenstein of 0.75, no
    absorption, beam of irradiance pi from the zenith."""
    phase = (1 - 0.75**2) / (1 + 0.75**2 - 1.5 * np.cos(plane_parallel.ANGLES)) ** 1.5
    moments, core = plane_parallel.moments_of(phase[:, None])
    assert moments[:60, 0] == pytest.approx((0.75 ** np.arange(60) - core) / (1 - core), abs=2e-6)
    depth_kept = depth * (1 - core)
    layers = plane_parallel.Layers(depth_kept, np.ones(1), moments.T, np.zeros(2), depth * core, np.zeros(1))
    _, up, down, *_ = plane_parallel.solve(layers, 32, 1.0, sun=np.pi)
    below, beam = down(depth_kept[0])
    assert up(0.0) == pytest.approx(reflected, rel=5e-5)
    # What the core holds of the beam is diffuse light.
    assert beam * np.exp(-depth * core[0]) == pytest.approx(direct, rel=2e-5)
    assert below + beam - direct == pytest.approx(diffuse, rel=2e-5)


@pytest.mark.parametrize("case", list(CASES))
def test_layers_of_the_truth_are_those_of_the_state(case):
    """Transmittance of slanting paths in our geometry is that of the truth's layers: both see the same air, and it is
    plane."""
    for micron in (*THERMAL, 0.65):
        state, point, layers = scene(case, micron)
        for sine in (1.0, 0.3):
            depth = (layers.depth + layers.forward).sum() / sine
            ours = seen(state, point, 0.0, -sine)["transmittance"]
            assert -np.log(ours) == pytest.approx(depth, rel=1e-3 if sine < 1 else 1e-5)


@pytest.mark.parametrize("case", list(CASES))
def test_thermal_light_from_above_and_below(case):
    print(f"\n{case}: thermal radiance less that of DISORT, K at 300 K; cosines", end=" ")
    errors = []
    for number, micron in enumerate(THERMAL):
        state, point, layers = scene(case, micron)
        wavenumber, observer = point.interval_edges.mean(axis=1)[point.interval], observer_of(state)
        cosine, _, down, _, radiance = thermal_truth(state, point, layers)
        cosine = cosine[: cosine.size // 2]
        if not number:
            print(", ".join(f"{cosine[k]:.2f}" for k in nodes_of(STREAMS)))
        bottom = np.cumsum(layers.depth)
        above = radiance(bottom[np.flatnonzero(layers.bottom == observer)[0]], 0.0)[: cosine.size]
        below = radiance(bottom[-1], 0.0)[cosine.size :]
        per_kelvin = np.diff(planck_wavenumber(wavenumber, np.array([299.5, 300.5])))[0]
        ground = planck_wavenumber(wavenumber, state.surface_temperature)[0]
        up, falling = [], []
        for node in nodes_of(STREAMS):
            line = seen(state, point, observer, cosine[node])
            up.append(line["path_thermal"] + line["transmittance"] * ground - above[node])
            line = seen(state, point, 0.0, -cosine[node])
            falling.append(line["path_thermal"] - below[node])
        sky = line["sky_irradiance"] / np.pi - down(bottom[-1])[0] / np.pi
        total = np.array([*up, *falling, sky]) / per_kelvin
        errors.append(total)
        figures = " ".join(f"{x:+6.2f}" for x in total)
        print(
            f"{micron:5.2f} um, depth {(layers.depth + layers.forward).sum():6.2f}: {figures}   (above 5, below 5, sky)"
        )
    assert np.abs(errors).max() < KELVIN


@pytest.mark.parametrize("micron", SOLAR)
@pytest.mark.parametrize("case", list(CASES))
def test_sunlight_reflected_and_transmitted(case, micron, quoted):
    state, point, whole = scene(case, micron)
    observer, layers = observer_of(state), solar_layers(state, whole)
    errors, skies = [], []
    for view, off in SUNS:
        near = nodes_of(STREAMS)[VIEWS.index(view)]
        zenith = np.arccos(plane_parallel.cosines(STREAMS)[near]) + np.radians(off)
        cosine, _, down, _, radiance = plane_parallel.solve(layers, STREAMS, np.cos(zenith), sun=1.0)
        bottom, half = np.cumsum(layers.depth), cosine.size // 2
        above = radiance(bottom[np.flatnonzero(layers.bottom == observer)[0]], ASIDE)[:half]
        below = radiance(bottom[-1], ASIDE)[half:]
        for k in nodes_of(STREAMS):
            for column, aside in enumerate(ASIDE):
                # DISORT's azimuth is that of travel from the beam's, which is that of the look from the Sun's.
                for height, sign, truth in ((observer, 1, above), (0.0, -1, below)):
                    line = seen(
                        state, point, height, sign * cosine[k], sun=SUN, elevation=np.pi / 2 - zenith, azimuth=aside
                    )
                    across = np.sqrt(1 - cosine[k] ** 2) * np.sin(zenith) * np.cos(aside)
                    angle = np.degrees(np.arccos(min(across - sign * cosine[k] * np.cos(zenith), 1.0)))
                    errors.append((sign, angle, line["path_scattered"] / SUN / truth[k, column] - 1))
        diffuse, beam = down(bottom[-1])
        unscattered = np.cos(zenith) * np.exp(-(layers.depth + layers.forward).sum() / np.cos(zenith))
        skies.append(line["sky_irradiance"] / SUN / (diffuse + beam - unscattered) - 1)
    sign, angle, error = np.array(errors).T
    settled = (sign > 0) | (angle > UNSETTLED) | ((case, micron) not in AUREOLES)
    sign, angle, error = sign[settled], angle[settled], error[settled]
    parts = {
        "above": sign > 0,
        "below": (sign < 0) & (angle > AUREOLE),
        "within 3 degree": angle <= AUREOLE,
    }
    figures = ", ".join(
        f"{name} {100 * np.sqrt(np.mean(error[part] ** 2)):.1f} rms"
        f" {100 * error[part][np.abs(error[part]).argmax()]:+.1f} worst"
        for name, part in parts.items()
        if np.any(part)
    )
    print(f"\n{case}, {micron:g} um, sunlight, %: {figures}; sky {100 * skies[0]:+.1f} {100 * skies[1]:+.1f}")
    if (case, micron) in BEYOND:
        name = f"light.disort.{case}".replace(" ", "_")
        quoted(name, f"{100 * np.abs(error[angle > AUREOLE]).max():.1f}", "%")
    assert np.abs(error[angle > AUREOLE]).max() < BEYOND.get((case, micron), OUTSIDE)
    assert np.abs(error[angle <= AUREOLE]).max(initial=0.0) < WITHIN
    assert np.abs(skies).max() < OUTSIDE


@pytest.fixture(scope="module")
def plane_monte_carlo():
    pytest.importorskip("numba")
    import plane_monte_carlo

    return plane_monte_carlo


def test_the_monte_carlo_is_disort_where_that_settles(plane_monte_carlo):
    """Henyey and Greenstein of 0.75 with a little absorption, at 9 to 90 degrees from the Sun."""
    phase = (1 - 0.75**2) / (1 + 0.75**2 - 1.5 * np.cos(plane_parallel.ANGLES)) ** 1.5
    moments, _ = plane_parallel.moments_of(phase[:, None])
    layers = plane_parallel.Layers(*map(np.array, ([0.4, 0.6], [0.9, 0.9], [moments[:, 0]] * 2)), None, None, None)
    sun = np.cos(np.radians(50.0))
    cosine, _, _, _, radiance = plane_parallel.solve(layers, STREAMS, sun, sun=1.0)
    half = cosine.size // 2
    for depth, sign, part in ((0.0, 1, slice(None, half)), (1.0, -1, slice(half, None))):
        for k in (2, 8, 14):
            truth = radiance(depth, ASIDE)[part][k]
            suns = [(sun, azimuth) for azimuth in ASIDE]
            light, error = plane_monte_carlo.radiance(layers, depth, sign * cosine[k], suns, PHOTONS)
            assert error.max() < 0.02 * truth.max()
            assert np.abs(light / truth - 1) == pytest.approx(0.0, abs=4 * (error / truth).max())


@pytest.mark.parametrize(("case", "micron"), AUREOLES)
def test_sunlight_around_the_sun(case, micron, plane_monte_carlo):
    state, point, whole = scene(case, micron)
    layers = solar_layers(state, whole)
    off = np.array(OFF)
    for cosine, _ in SUNS:
        zenith = np.arccos(cosine) + np.radians(off)
        suns = [(np.cos(angle), 0.0) for angle in zenith]
        truth, deviation = plane_monte_carlo.radiance(layers, layers.depth.sum(), -cosine, suns, PHOTONS)
        ours = [
            seen(state, point, 0.0, -cosine, sun=SUN, elevation=np.pi / 2 - angle)["path_scattered"] for angle in zenith
        ]
        error, deviation = np.array(ours) / SUN / truth - 1, deviation / truth
        figures = ", ".join(
            f"{a:g}: {100 * e:+.1f} +- {100 * d:.1f}" for a, e, d in zip(off, error, deviation, strict=True)
        )
        print(f"\n{case}, {micron:g} um, %, by degrees from the Sun, cosine {cosine}: {figures}")
        assert deviation[off <= AUREOLE].max() < OUTSIDE
        assert np.all(np.abs(error) < np.where(off <= AUREOLE, WITHIN, OUTSIDE) + 3 * deviation)
