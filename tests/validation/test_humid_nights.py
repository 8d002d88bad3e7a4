"""Longwave of clear humid nights measured in Oklahoma, by water vapour continuum: what the default is chosen by.

18 June to 17 July 1997 (ARM; Zhang et al. 2001, Mon. Weather Rev. 129, 295): means over three hours and several
stations of soundings and pyrgeometers, 22 to 41 mm of water. Pyrgeometers of that time are good to 5 W m-2; those of
Payerne (`test_payerne.py`), to 2 to 4, say the same. Run with ``-s`` for the table.
"""

import numpy as np
import pytest

pytest.importorskip("netCDF4")

from skyshine.mat.atmosphere.gases.absorption import default_water_continuum
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.spectra.fluxes import broadband_fluxes, packaged_points
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.profiles import load_profile
from skyshine.mat.atmosphere.state.sounding import read_sounding
from skyshine.mat.atmosphere.state.state import AtmosphericState

pytestmark = [pytest.mark.validation, pytest.mark.shared_data]

GROUND = 318.0  # m
CLOUD, DARK = 5.0, 5.0  # %, of both cloud products; W m-2 of sunlight
CLOUDY = (15 * 24, 16 * 24)  # hours from 18 June: 3 July, which neither product calls cloudy and radiation does
CO2, DEPTH = 364.0, 0.15  # ppm, 1997 (NOAA); optical depth of aerosol at 0.55 um, Great Plains in summer
HIGHEST = 150.0  # hPa, of the soundings' humidity
CONTINUA = {"mt_ckd_4.3_closure": -2.2, "mt_ckd_4.3": -4.9, "mt_ckd_2.4": -1.1}  # mean of the nights, W m-2
SCATTER = 2.0  # W m-2, standard deviation of the nights


@pytest.fixture(scope="module")
def nights(shared_data):
    """Soundings as text, and measured longwave [W m-2], of clear nights."""
    import netCDF4

    with netCDF4.Dataset(shared_data / "humid_sky" / "sgp_1997_iop.nc") as file:
        given = {name: np.ma.filled(item[...].astype(float), np.nan) for name, item in file.variables.items()}
    hours = given["time"]
    clear = (given["goes_cloud"] <= CLOUD) & (np.nanmax(given["arscl_cloud"], axis=1) <= CLOUD)
    clear &= ~((hours >= CLOUDY[0]) & (hours < CLOUDY[1])) & (given["shortwave_down"] < DARK)
    return [(sounding(given, row), given["longwave_down"][row]) for row in np.flatnonzero(clear)]


def sounding(given, row):
    """Levels of a sounding over the air at the ground, with hydrostatic heights."""
    order = np.argsort(-given["pressure"])
    above, kelvin, ratio = given["pressure"][order], given["temperature"][row][order], given["mixing_ratio"][row][order]
    at_ground, celsius = given["surface_pressure"][row], given["air_temperature"][row]
    inside = (above < at_ground - 3.0) & (above > HIGHEST) & np.isfinite(kelvin) & np.isfinite(ratio)
    vapour = 6.112 * np.exp(17.62 * celsius / (243.12 + celsius)) * given["relative_humidity"][row] / 100  # WMO No. 8
    ratio = 1e-3 * ratio[inside]
    vapour = np.append(vapour, np.maximum(ratio / (0.62198 + ratio) * above[inside], 1e-5))
    pressure, kelvin = np.append(at_ground, above[inside]), np.append(celsius + 273.15, kelvin[inside])
    virtual = kelvin / (1 - 0.378 * vapour / pressure)
    steps = 287.05 / 9.807 * 0.5 * (virtual[1:] + virtual[:-1]) * np.log(pressure[:-1] / pressure[1:])
    height = GROUND + np.append(0.0, np.cumsum(steps))
    logarithm = np.log(vapour / 6.112)
    dew = 243.12 * logarithm / (17.62 - logarithm)
    rows = [
        f"{h:.1f},{p:.4f},{t - 273.15:.2f},{d:.2f}" for h, p, t, d in zip(height, pressure, kelvin, dew, strict=True)
    ]
    return "\n".join(["altitude[m],pressure[hPa],temperature[C],dew_point[C]", *rows]) + "\n"


def test_longwave_of_humid_nights(nights, quoted):
    assert len(nights) == 9
    errors = {name: [] for name in CONTINUA}
    print(f"\nmeasured, and computed less measured, W m-2: {', '.join(CONTINUA)}")
    for text, measured in nights:
        profile = read_sounding(text, "oklahoma.csv", load_profile("midlatitude_summer"))
        state = AtmosphericState.from_profile(
            profile,
            surface_altitude=GROUND,
            gas_amounts=GasAmounts(ppm={"CO2": CO2}),
            aerosol=Aerosol("rural", optical_depth=DEPTH),
        )
        for name in CONTINUA:
            light = broadband_fluxes(state, [GROUND], [-30.0], 0.2, points=packaged_points(name))
            errors[name].append(light.longwave_down[0] - measured)
        print(f"{measured:8.1f}  " + "   ".join(f"{values[-1]:+.1f}" for values in errors.values()))
    for name, mean in CONTINUA.items():
        quoted(f"air.humid_nights.{name.replace('.', '_')}", f"{np.mean(errors[name]):.1f}", "W m-2")
        assert np.mean(errors[name]) == pytest.approx(mean, abs=0.5) and np.std(errors[name]) < SCATTER, name
    assert abs(np.mean(errors[default_water_continuum()])) < 3.0
