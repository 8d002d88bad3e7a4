"""Laws that light among particles obeys whatever the particles are: one temperature, Kirchhoff's law, reciprocity.

The ground is black, and the air plane where a law wants it (`plane_earth`). What leaves an enclosure at one temperature
is Planck's radiance; air under a cold space lacks the light that space would send, and sunlight tells how much that is
(Chandrasekhar 1950, sections 13 and 52).
"""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.particles.rain import RainLayer
from skyshine.mat.atmosphere.spectra.spectrum import line_spectrum
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.radiometry.blackbody import planck_wavenumber

pytestmark = pytest.mark.validation

TOLERANCE = 1e-4
TEMPERATURE = 285.0
SUN = 1e6  # W m^-2 per cm^-1: no thermal light beside it
CLOUD = CloudLayer("water", 1e3, 2e3, 10.0, 3.0)
TOP = 12e3  # m; low, so that angles at the observer are those in the cloud
# Elevations of Sun and observer and the azimuth between, degree; more than 15 degrees between the directions.
DIRECTIONS = ((70, 45, 0), (62, 46, 90), (50, 47, 180), (85, 48, 30))
AIRS = {
    "fog": {"aerosol": Aerosol("fog_radiation")},
    "cloud": {"clouds": [CLOUD]},
    "haze": {"aerosol": Aerosol("rural", visibility_km=5.0)},
    "rain": {"rain": RainLayer(10.0, 3e3)},
}


def isothermal(**about):
    """A state of one temperature over a black ground of the same."""
    state = AtmosphericState.from_profile("midlatitude_summer", surface_albedo=0.0, **about)
    return replace(state, temperature=np.full_like(state.temperature, TEMPERATURE), surface_temperature=TEMPERATURE)


def cut(state, top):
    """The state without the air above a level."""
    kept = state.altitude <= top

    def parts(components):
        return tuple(replace(part, extinction_550=part.extinction_550[kept]) for part in components)

    return replace(
        state,
        altitude=state.altitude[kept],
        pressure=state.pressure[kept],
        temperature=state.temperature[kept],
        mole_fraction={gas: values[kept] for gas, values in state.mole_fraction.items()},
        aerosols=parts(state.aerosols),
        hydrometeors=parts(state.hydrometeors),
    )


def point_at(micron):
    """The spectral point of the interval at a wavelength at which air absorbs least."""
    points = AbsorptionTable.open().points(1e4 / micron - 0.5, 1e4 / micron + 0.5)
    sections = points.cross_sections([1e5], [288.0], [0.01])
    parts = {"H2O": 0.01, "H2O_continuum": 0.01, "CO2": 4e-4, "CH4": 2e-6, "N2O": 3e-7}
    return points.subset(np.array([np.argmin(sum(sections[gas][0] * part for gas, part in parts.items()))]))


def along(state, point, altitude, elevation, *, irradiance=0.0, sun=45.0, azimuth=0.0):
    """Values of `line_spectrum` at a point, by name; elevation of the line of sight and of the Sun in degree."""
    line = line_spectrum(
        state,
        point,
        np.array([irradiance]),
        altitude=altitude,
        elevation=np.radians(elevation),
        distance=np.inf,
        source_elevation=np.radians(sun),
        source_azimuth=np.radians(azimuth),
    )
    names = ("transmittance", "path_thermal", "path_scattered", "sky_irradiance", "direct_irradiance")
    return {name: float(getattr(line, name)[point.interval[0]]) for name in names}


def planck(point):
    return float(planck_wavenumber(point.interval_edges.mean(axis=1)[point.interval], TEMPERATURE)[0])


@pytest.mark.parametrize("micron", [3.85, 8.5, 10.6])
def test_thick_cloud_of_one_temperature_is_an_enclosure(micron):
    """Under it and inside it every direction shows Planck's radiance: no light of space comes through."""
    state, point = isothermal(clouds=[CloudLayer("water", 1e3, 2e3, 10.0, 400.0)]), point_at(micron)
    errors = []
    for altitude, elevations in ((0.0, (5, 20, 45, 90)), (1500.0, (-90, -45, -10, 10, 45, 90))):
        for elevation in elevations:
            line = along(state, point, altitude, elevation)
            ground = line["transmittance"] * planck(point) if elevation < 0 else 0.0
            errors.append((line["path_thermal"] + ground) / planck(point) - 1)
    sky = along(state, point, 0.0, 90.0)["sky_irradiance"] / (np.pi * planck(point)) - 1
    print(f"\n{micron:g} um: radiance {np.abs(errors).max():.1e}, irradiance {sky:+.1e}")
    assert np.abs(errors).max() < TOLERANCE and abs(sky) < TOLERANCE


@pytest.mark.usefixtures("plane_earth")
@pytest.mark.parametrize("micron", [3.85, 10.6])
@pytest.mark.parametrize("air", ["clear", *AIRS])
def test_emission_and_transmission_of_the_sky_add_up_to_one(air, micron):
    """Thermal irradiance of the ground over that of an enclosure, and the share of a uniform space that reaches it, by
    sunlight of all elevations."""
    state = isothermal(**AIRS.get(air, {"aerosol": Aerosol("none")}))
    point = point_at(micron)
    emitted = along(state, point, 0.0, 90.0)["sky_irradiance"] / (np.pi * planck(point))
    node, weight = np.polynomial.legendre.leggauss(20)
    root, passed = 0.5 * (node + 1), 0.0
    for s, w in zip(root, 0.5 * weight, strict=True):
        sine = s**2  # more nodes near the horizon
        line = along(state, point, 0.0, 90.0, irradiance=SUN, sun=np.degrees(np.arcsin(sine)))
        scattered = line["sky_irradiance"] / SUN - emitted * np.pi * planck(point) / SUN
        passed += 2 * s * w * 2 * (scattered + sine * line["direct_irradiance"] / SUN)
    print(f"\n{air}, {micron:g} um: emitted {emitted:.5f}, passed {passed:.5f}, sum less 1 {emitted + passed - 1:+.1e}")
    # Sunlight that a cloud passes depends on the number of ordinates: 4, 6 (these), 8, 12, 16, 24 and 32 in each
    # hemisphere give sums of 1 + 1.8, 2.2, 1.4, -1.3, -1.2, -1.3 and -1.3e-4 at 3.85 um; what it emits is the same to
    # 2e-5. What remains is of the size of the planet's curvature: 4 times the radius takes 0.6e-4 from the sum.
    assert abs(emitted + passed - 1) < (2.5 * TOLERANCE if air == "cloud" else TOLERANCE)


def swapped(state, point, altitude, sign, first, second, azimuth):
    """Bidirectional reflection (sign 1) or transmission (-1) and the same with the directions swapped; elevations."""
    pair = []
    for source, view in ((first, second), (second, first)):
        line = along(state, point, altitude, -sign * view, irradiance=SUN, sun=source, azimuth=azimuth)
        pair.append(line["path_scattered"] / SUN / np.sin(np.radians(source)))
    return pair


@pytest.mark.usefixtures("plane_earth")
@pytest.mark.parametrize("micron", [0.65, 1.6, 3.85])
@pytest.mark.parametrize("air", list(AIRS))
def test_reflection_is_reciprocal(air, micron):
    state, point = cut(isothermal(**AIRS[air]), TOP), point_at(micron)
    errors = []
    for first, second, azimuth in DIRECTIONS:
        one, other = swapped(state, point, state.altitude[-1], 1, first, second, azimuth)
        errors.append(one / other - 1)
    print(f"\n{air}, {micron:g} um: reflection swapped, largest difference {np.abs(errors).max():.1e}")
    assert np.abs(errors).max() < TOLERANCE


@pytest.mark.usefixtures("plane_earth")
def test_transmission_of_an_even_cloud_is_reciprocal():
    """The cloud alone, without gas; molecules hardly scatter at 3.85 um, so that the layer is the same from both
    sides."""
    state, point = isothermal(aerosol=Aerosol("none"), clouds=[CLOUD]), point_at(3.85)
    state = replace(state, mole_fraction={gas: np.zeros_like(part) for gas, part in state.mole_fraction.items()})
    errors = []
    for first, second, azimuth in DIRECTIONS:
        one, other = swapped(state, point, 0.0, -1, first, second, azimuth)
        errors.append(one / other - 1)
    print(f"\ntransmission swapped, largest difference {np.abs(errors).max():.1e}")
    assert np.abs(errors).max() < TOLERANCE
