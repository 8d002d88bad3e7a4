"""Fluxes of 50 atmospheres at the ground and at the top by `skyshine.mat.fluxes` against line-by-line fluxes of CKDMIP,
by water vapour.

Evaluation-1 of the Correlated K-Distribution Model Intercomparison Project (Hogan and Matricardi 2020, Geosci. Model
Dev. 13, 6501), present day: LBLRTM 12.8, no particles; longwave over a black ground, sunlight over an albedo of 0.15.
Each atmosphere is a sounding in a file. LBLRTM's water vapour continuum is older than MT_CKD 4.2: longwave is a test of
lines, band model and transfer with `mt_ckd_2.4`; what `mt_ckd_4.3_closure` and `mt_ckd_4.3` change is printed beside.
The profiles are thinned to layers of 100 hPa, which scatters single ones by 1 W m-2. Run with ``-s`` for the tables.
"""

import numpy as np
import pytest
from scipy.io import netcdf_file

import skyshine.mat
from skyshine.mat.atmosphere.state.profiles import GASES
from skyshine.mat.surface.vapour import saturation_pressure

pytestmark = [pytest.mark.validation, pytest.mark.shared_data]  # 4 minutes

# Names in the files of the gases that LBLRTM had; the others are 0.
MEASURED = {
    name: f"{name.lower().replace('-', '')}_mole_fraction_fl"
    for name in ("H2O", "O3", "CO2", "CH4", "N2O", "CFC-11", "CFC-12", "O2", "N2")
}
CLASSES = ((0.0, 5.0), (5.0, 15.0), (15.0, 30.0), (30.0, 45.0), (45.0, 100.0))  # mm of water
CONTINUA = ("mt_ckd_2.4", "mt_ckd_4.3_closure", "mt_ckd_4.3")
ALBEDO = 0.15
EDGE = 0.01  # of a layer, in the logarithm of pressure
GRAVITY, GAS_CONSTANT, WATER_MASS, AIR_MASS = 9.80665, 8.314463, 0.0180153, 0.0289644  # m s-2, J mol-1 K-1, kg mol-1
SUNLIGHT_AT_TOP = 1361.0  # W m-2, of the whole spectrum, part of which the points have (Coddington et al. 2021)
LOWEST_MU = 0.3  # cosine of the Sun's zenith angle; below, a plane layer is no longer a shell
# W m-2, means of a class: longwave down at the ground and up at the top; shares of sunlight down at the ground, up at
# the top.
LONGWAVE_DOWN, LONGWAVE_UP, SUNLIGHT, SUNLIGHT_UP = 1.0, 0.7, 0.005, 0.002


def read(folder, name):
    with netcdf_file(folder / "ckdmip" / f"ckdmip_evaluation1_{name}_present_reduced.nc", mmap=False) as file:
        return {key: variable.data.astype(float) for key, variable in file.variables.items()}


@pytest.fixture(scope="module")
def atmospheres(shared_data, tmp_path_factory):
    """Files of soundings, carbon dioxide [ppm] and precipitable water [mm], 50 each."""
    given, folder = read(shared_data, "concentrations"), tmp_path_factory.mktemp("soundings")
    files, carbon_dioxide, water = [], [], []
    for row in range(len(given["pressure_hl"])):
        edge, kelvin = np.maximum(given["pressure_hl"][row][::-1], 1e-2), given["temperature_hl"][row][::-1]
        fraction = {name: given[key][row][::-1] for name, key in MEASURED.items()}
        water.append(np.sum(fraction["H2O"] * -np.diff(edge)) * WATER_MASS / AIR_MASS / GRAVITY)
        carbon_dioxide.append(1e6 * fraction["CO2"][0])
        files.append(folder / f"{row}.csv")
        files[-1].write_text(sounding(edge, kelvin, fraction))
    return files, carbon_dioxide, np.array(water)


def sounding(edge, kelvin, fraction):
    """Text of a sounding: the layers of LBLRTM, which are even and some 100 hPa thick, have two levels close to each
    edge.
    """
    step = EDGE * -np.diff(np.log(edge))
    logarithm = np.sort(np.concatenate([-np.log(edge[:-1]) + step, -np.log(edge[1:]) - step]))
    logarithm[0], logarithm[-1] = -np.log(edge[[0, -1]])
    pressure, temperature = np.exp(-logarithm), np.interp(logarithm, -np.log(edge), kelvin)
    mole = {name: np.repeat(np.maximum(fraction.get(name, 0.0), 0.0) * np.ones(edge.size - 1), 2) for name in GASES}
    mass = AIR_MASS * (1 - mole["H2O"]) + WATER_MASS * mole["H2O"]
    scale = GAS_CONSTANT * temperature / (mass * GRAVITY)
    height = np.append(0.0, np.cumsum(0.5 * (scale[1:] + scale[:-1]) * np.diff(logarithm)))
    # Means of a layer are above saturation at its colder edge.
    mole["H2O"] = np.minimum(mole["H2O"], saturation_pressure(temperature) / pressure)
    columns = {"altitude[m]": height, "pressure[Pa]": pressure, "temperature[K]": temperature}
    columns |= {f"{name}[1]": values for name, values in mole.items()}
    rows = np.array([*columns.values()]).T[height <= 100e3]
    return "\n".join([",".join(columns), *(",".join(f"{value:.9g}" for value in row) for row in rows)]) + "\n"


def in_air(file, carbon_dioxide, **arguments):
    """Fluxes through a sounding without particles."""
    return skyshine.mat.fluxes(sounding=str(file), aerosol="none", co2_ppm=carbon_dioxide, **arguments)


def by_class(water, values, title, unit):
    """Mean and rms of differences (50, K) in each class of water vapour, printed."""
    print(f"\n{title}, {unit}: mean and rms by mm of water")
    means = []
    for low, high in CLASSES:
        rows = (water >= low) & (water < high)
        means.append(values[rows].mean(axis=0))
        rms = np.sqrt(np.mean(values[rows] ** 2, axis=0))
        cells = "   ".join(f"{mean:+8.3f} {size:7.3f}" for mean, size in zip(means[-1], rms, strict=True))
        print(f"{low:4.0f} to {high:3.0f} mm ({rows.sum():2d}): {cells}")
    return np.array(means)


def test_longwave(shared_data, atmospheres, quoted):
    files, carbon_dioxide, water = atmospheres
    theirs = read(shared_data, "lw_fluxes")
    down, up = np.empty((2, len(files), len(CONTINUA)))
    for row, (file, ppm) in enumerate(zip(files, carbon_dioxide, strict=True)):
        for column, continuum in enumerate(CONTINUA):
            ours = in_air(file, ppm, surface_albedo=0, source="none", water_continuum=continuum)
            down[row, column] = ours.thermal_down[0] - theirs["flux_dn_lw"][row, -1]
            up[row, column] = ours.thermal_up[-1] - theirs["flux_up_lw"][row, 0]
    print(f"\n{CONTINUA}")
    at_ground = by_class(water, down, "longwave down at the ground, ours less LBLRTM", "W m-2")
    at_top = by_class(water, up, "longwave up at the top, ours less LBLRTM", "W m-2")
    for column, continuum in enumerate(CONTINUA):
        for level, means in (("ground", at_ground), ("top", at_top)):
            for (low, _), mean in zip(CLASSES, means[:, column], strict=True):
                quoted(f"air.ckdmip.{continuum.replace('.', '_')}.{level}.from_{low:.0f}_mm", f"{mean:.1f}", "W m-2")
    assert np.abs(at_ground[:, 0]).max() <= LONGWAVE_DOWN
    assert np.abs(at_top[:, 0]).max() <= LONGWAVE_UP


def test_shortwave(shared_data, atmospheres, quoted):
    files, carbon_dioxide, water = atmospheres
    theirs = read(shared_data, "sw_fluxes")
    used = theirs["mu0"] >= LOWEST_MU
    elevation = np.degrees(np.arcsin(theirs["mu0"][used]))
    down, up = np.empty((2, len(files), used.sum()))
    for row, (file, ppm) in enumerate(zip(files, carbon_dioxide, strict=True)):
        ours = in_air(file, ppm, surface_albedo=ALBEDO, source_elevation=elevation)
        top = theirs["flux_dn_sw"][row, used, 0]
        stronger = (top / theirs["mu0"][used]).mean() / SUNLIGHT_AT_TOP
        ground = stronger * (ours.direct[0] + ours.diffuse_down[0])
        down[row] = ground / theirs["flux_dn_sw"][row, used, -1] - 1
        up[row] = (stronger * ours.diffuse_up[-1] - theirs["flux_up_sw"][row, used, 0]) / top
    print(f"\ncosines of the Sun's zenith angle: {theirs['mu0'][used]}")
    at_ground = by_class(water, 100 * down, "sunlight down at the ground, ours over LBLRTM's less 1", "%")
    at_top = by_class(water, 100 * up, "sunlight up at the top, ours less LBLRTM's over that arriving", "%")
    for level, means in (("ground", at_ground), ("top", at_top)):
        quoted(f"air.ckdmip.sunlight.{level}", f"{np.abs(means).max():.2f}", "%")
    assert np.abs(at_ground).max() <= 100 * SUNLIGHT
    assert np.abs(at_top).max() <= 100 * SUNLIGHT_UP
