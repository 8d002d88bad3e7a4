"""Sky irradiance against PythonicDISORT: what first-order scattering and the two-stream thermal source leave out.

Plane-parallel DISORT with 32 streams over the same layers, thermal and solar, for mid-latitude summer with rural aerosol.
``pip install pythonicdisort`` brings it.
"""

import numpy as np
import pytest

from skyshine.mat.atmosphere.absorption import AbsorptionTable
from skyshine.mat.atmosphere.air import SpectralAir
from skyshine.mat.atmosphere.optics import PHASE_ANGLES, rayleigh_phase
from skyshine.mat.atmosphere.sky import sky_irradiance
from skyshine.mat.atmosphere.state import AtmosphericState
from skyshine.mat.radiometry import planck_wavenumber

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
        bottom, np.minimum(albedo, 1 - 1e-9), STREAMS, moments, mu0, beam, 0.0, NLeg=STREAMS, b_pos=surface,
        only_flux=True, f_arr=np.maximum(moments[:, STREAMS], 0.0), s_poly_coeffs=source,
    )  # fmt: skip
    return down(bottom[-1])[0]


@pytest.mark.parametrize("band", list(BANDS))
@pytest.mark.parametrize("visibility", [23.0, 5.0])
def test_sky_irradiance(band, visibility, record_property):
    pytest.importorskip("PythonicDISORT")
    state = AtmosphericState.from_profile(
        "midlatitude_summer", co2_ppm=420, visibility_km=visibility, surface_albedo=0.0
    )
    points = AbsorptionTable.open().points(*BANDS[band])
    air = SpectralAir.of(state, points.subset(np.arange(0, points.wavenumber.size, 6)))
    elevations = np.radians([20.0, 45.0, 75.0])
    ours = sky_irradiance(air, np.zeros(1), elevations, zeniths=24, azimuths=16)
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
    assert np.all(np.abs(scattered) < (0.05 if visibility > 10 else 0.15))
