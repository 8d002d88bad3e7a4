"""Scattered light and thermal sky against PythonicDISORT: what few streams leave out.

Plane-parallel DISORT with 32 streams over the same layers: the sky of mid-latitude summer in the infrared, and haze and
a thin cloud at 1 um by optical depth and albedo of the ground. ``pip install pythonicdisort`` brings it; the tables are
printed with ``-s``.
"""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol import AerosolModel, AerosolOptics
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.state import AerosolComponent, AtmosphericState
from skyshine.mat.atmosphere.transfer import geometry
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES, rayleigh_phase
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance, sky_irradiance
from skyshine.mat.radiometry.blackbody import planck_wavenumber

pytestmark = pytest.mark.validation

STREAMS = 32
MOMENTS = 400  # of the phase function: the correction of DISORT's radiances needs them all
BANDS = {"3.9": (2540.0, 2580.0), "8.5": (1160.0, 1190.0), "11": (900.0, 930.0)}


def layers(air, point):
    """Optical depths, single-scattering albedos and Legendre moments of the layers from the top down, at one point."""
    optics, state = air.optics, air.state
    depth, albedo, moments = [], [], []
    node, weight = np.polynomial.legendre.leggauss(1000)
    legendre = np.polynomial.legendre.legvander(node, MOMENTS) * (weight / 2)[:, None]
    molecular = rayleigh_phase(node, optics.rayleigh_anisotropy[point])
    for low in range(state.altitude.size - 2, -1, -1):
        pair = slice(low, low + 2)
        density = state.number_density[pair]
        step = np.diff(state.altitude[pair])[0]
        column = step * (density[0] - density[1]) / np.log(density[0] / density[1])
        extinction, molecules, particles = (
            column * part[pair, point].mean()
            for part in (optics.extinction, optics.rayleigh, optics.aerosol_scattering)
        )
        shape = optics.phase[:, pair].mean(axis=1) @ optics.phase_share[:, point]
        phase = np.interp(np.arccos(node), PHASE_ANGLES, shape)
        mixed = (molecules * molecular + particles * phase) / (molecules + particles)
        depth.append(extinction)
        albedo.append((molecules + particles) / extinction)
        coefficients = mixed @ legendre
        moments.append(coefficients / coefficients[0])
    return np.array(depth), np.array(albedo), np.array(moments)


def disort(air, point, mu0, beam, emission, surface):
    """Diffuse downward flux at the ground."""
    from PythonicDISORT.pydisort import pydisort

    depth, albedo, moments = layers(air, point)
    bottom = np.cumsum(depth)
    source = np.zeros((depth.size, 2))
    if emission is not None:
        from_top = emission[::-1]  # the blackbody radiance: pydisort itself takes the absorbed part of it
        slope = np.diff(from_top) / depth
        start = from_top[:-1] - slope * np.append(0.0, bottom[:-1])
        source = np.stack([start, slope], axis=1)
    _, _, down, *_ = pydisort(
        bottom,
        np.minimum(albedo, 1 - 1e-9),
        STREAMS,
        moments,
        mu0,
        beam,
        0.0,
        NLeg=STREAMS,
        b_pos=surface,
        only_flux=True,
        f_arr=np.maximum(moments[:, STREAMS], 0.0),
        s_poly_coeffs=source,
    )
    return down(bottom[-1])[0]


@pytest.mark.parametrize("band", list(BANDS))
@pytest.mark.parametrize("visibility", [23.0, 5.0])
def test_sky_irradiance(band, visibility, record_property):
    pytest.importorskip("PythonicDISORT")
    state = AtmosphericState.from_profile(
        "midlatitude_summer",
        gas_amounts=GasAmounts(ppm={"CO2": 420}),
        aerosol=Aerosol(visibility_km=visibility),
        surface_albedo=0.0,
    )
    points = AbsorptionTable.open().points(*BANDS[band])
    air = SpectralAir.of(state, points.subset(np.arange(0, points.wavenumber.size, 6)))
    elevations = np.radians([20.0, 45.0, 75.0])
    ours = sky_irradiance(air, np.zeros(1), elevations, zeniths=24)
    count = air.optics.wavenumber.size
    ground = planck_wavenumber(air.optics.wavenumber, state.surface_temperature)
    thermal = np.array([disort(air, p, 0.5, 0.0, air.optics.emission[:, p], ground[p]) for p in range(count)])
    solar = np.array([[disort(air, p, np.sin(e), 1.0, None, 0.0) for p in range(count)] for e in elevations])
    difference = ours.thermal[0].sum() / thermal.sum() - 1
    scattered = ours.scattered[0].sum(axis=1) / solar.sum(axis=1) - 1
    total = -np.log(np.mean(np.exp(-np.array([layers(air, p)[0].sum() for p in range(count)]))))
    print(
        f"\n{band} um, {visibility:g} km, optical depth {total:.2f}: thermal {100 * difference:+.2f} %, scattered",
        end=" ",
    )
    print(", ".join(f"{100 * s:+.1f} %" for s in scattered), "(source at 20, 45, 75 degree)")
    record_property("thermal", float(difference))
    assert abs(difference) < (0.01 if visibility > 10 else 0.03)
    assert np.all(np.abs(scattered) < (0.015 if visibility > 10 else 0.035))


DEPTHS = (0.05, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
OBSERVER = 6e3  # m, above all particles
AZIMUTHS = np.radians([0.0, 60.0, 120.0, 180.0])


class OnePoint:
    """A spectral point at 1 um at which no gas absorbs."""

    interval_edges = np.array([[9999.0, 10001.0]])
    interval, weight, wavenumber = np.zeros(1, int), np.array([2.0]), np.array([1e4])

    def cross_sections(self, pressure, temperature, h2o_mole_fraction, gases=None):
        return {"CO2": np.zeros((len(pressure), 1))}


class Droplets:
    """Particles of a cloud: Henyey and Greenstein's phase function of asymmetry 0.85, next to no absorption."""

    asymmetry = 0.85

    def optics(self, wavenumber, relative_humidity):
        one = np.ones((len(relative_humidity), len(wavenumber)))
        return AerosolOptics(one, 0.9999 * one, self.asymmetry * one)

    def phase_function(self, cos_angle, wavenumber, relative_humidity):
        phase = (1 - self.asymmetry**2) / (1 + self.asymmetry**2 - 2 * self.asymmetry * cos_angle) ** 1.5
        return np.tile(phase[:, None, None], (1, len(relative_humidity), len(wavenumber)))


def particles(kind, depth, albedo):
    """Air with particles of one vertical optical depth: haze to 5 km or a cloud at 1 to 1.5 km."""
    state = AtmosphericState.from_profile("us_standard", aerosol=Aerosol("none"), surface_albedo=albedo)
    altitude = state.altitude
    if kind == "cloud":
        model, shape = Droplets(), ((altitude >= 1000) & (altitude <= 1500)) * 1e-9
    else:
        model, shape = (
            AerosolModel.load("rural", 70.0),
            np.where(altitude <= 5000, np.exp(-altitude / 1200), 0.0) * 1e-9,
        )
    for _ in range(2):  # the first time to find the optical depth
        air = SpectralAir.of(replace(state, aerosols=(AerosolComponent(model, shape),)), OnePoint())
        up = Segments.of(geometry.trace(air.shells, np.zeros(1), np.array([np.pi / 2])), 0)
        shape = shape * depth / up.column(air.optics.aerosol_extinction).sum()
    return air


def reference(air, mu0, albedo):
    """DISORT's cosines, radiances at the observer and the ground (direction, azimuth), and diffuse flux at the
    ground.
    """
    from PythonicDISORT.pydisort import pydisort

    depth, single, moments = layers(air, 0)
    above = np.flatnonzero(air.state.altitude[::-1][1:] >= OBSERVER)
    below = np.arange(above.size, depth.size)
    groups = [above, *(below[k : k + 2] for k in range(0, below.size, 2))]
    total = np.array([depth[g].sum() for g in groups])
    scattering = np.array([(depth[g] * single[g]).sum() for g in groups])
    shape = np.array([(depth[g] * single[g]) @ moments[g] for g in groups]) / scattering[:, None]
    bottom = np.cumsum(total)
    cosine, _, down, _, radiance = pydisort(
        bottom,
        np.minimum(scattering / total, 1 - 1e-9),
        STREAMS,
        shape,
        mu0,
        1.0,
        0.0,
        NLeg=STREAMS,
        NT_cor=True,
        f_arr=np.maximum(shape[:, STREAMS], 0.0),
        BDRF_Fourier_modes=[albedo] if albedo else [],
    )
    return cosine, radiance(bottom[0], AZIMUTHS), radiance(bottom[-1], AZIMUTHS), down(bottom[-1])[0]


def seen(air, altitude, cosine, elevation):
    """Our scattered radiance of light that travels at a cosine (positive up), by azimuth, and the transmittance of its
    path.
    """
    rays = geometry.trace(air.shells, np.array([altitude]), -np.arcsin([cosine]))
    segments = Segments.of(rays, 0)
    ends = np.append(segments.index, segments.index[-1] + 1)
    sources = np.full(AZIMUTHS.size, elevation), AZIMUTHS
    angles = (f(rays, *sources)[0, ends] for f in (geometry.source_cosine, geometry.scattering_cosine))
    depth = segments.column(air.optics.extinction)
    return air.scattered_radiance(segments, Depths(depth), *angles)[:, 0], np.exp(-depth.sum())


@pytest.mark.parametrize("kind", ["haze", "cloud"])
@pytest.mark.parametrize("albedo", [0.0, 0.5])
@pytest.mark.parametrize("mu0", [0.34, 0.87])
@pytest.mark.filterwarnings("ignore")
def test_flux_and_radiance_by_optical_depth(kind, albedo, mu0):
    pytest.importorskip("PythonicDISORT")
    elevation = np.arcsin(mu0)
    print(
        f"\n{kind}, albedo {albedo:g}, source at {np.degrees(elevation):.0f} degree; difference in %: sky irradiance;"
        " radiance"
    )
    print("optical depth    sky   down rms  mean   aureole    up rms  mean")
    for depth in DEPTHS:
        air = particles(kind, depth, albedo)
        cosine, rising, falling, flux = reference(air, mu0, albedo)
        sky = sky_irradiance(air, np.zeros(1), np.array([elevation])).scattered[0, 0, 0]
        direct = direct_transmittance(air.source_paths, np.zeros(1), np.array([elevation]))[0, 0, 0]
        ground = albedo / np.pi * (sky + mu0 * direct)
        down, up = np.flatnonzero(cosine < -0.25), np.flatnonzero(cosine > 0.25)
        ours = np.array([seen(air, 0.0, cosine[k], elevation)[0] for k in down])
        across = np.sqrt(1 - cosine[down] ** 2)[:, None] * np.sqrt(1 - mu0**2) * np.cos(AZIMUTHS)
        near = -cosine[down][:, None] * mu0 + across > np.cos(np.radians(15.0))
        error_down = ours / falling[down] - 1
        above = [seen(air, OBSERVER, cosine[k], elevation) for k in up]
        error_up = np.array([path + ground * through for path, through in above]) / rising[up] - 1
        error = sky / flux - 1
        aureole = error_down[near].mean() if near.any() else np.nan
        far, bias = error_down[~near], ours[~near].sum() / falling[down][~near].sum() - 1
        bias_up = np.sum([path + ground * through for path, through in above]) / rising[up].sum() - 1
        figures = (error, np.sqrt(np.mean(far**2)), bias, aureole, np.sqrt(np.mean(error_up**2)), bias_up)
        print(f"{depth:13g} {''.join(f'{100 * x:+9.1f}' for x in figures)}")
        # Haze of any depth here and thin cloud; 15 degree around the source, and thick cloud, are printed only.
        assert abs(error) < 0.03
        if kind == "haze" or depth <= 1:
            assert np.sqrt(np.mean(far**2)) < 0.08 and np.sqrt(np.mean(error_up**2)) < 0.08
            assert abs(bias) < 0.08 and abs(bias_up) < 0.08
