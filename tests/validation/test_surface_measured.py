"""Measured skin temperature: the solver under measured radiation and weather, with parameters from books, not fitted.

Truth is the upwelling longwave irradiance less the reflected part of the downwelling one. The day is taken as periodic,
which its own change from end to end breaks: no result can be better than that allows.
"""

import numpy as np
import pytest

from skyshine.mat.surface import column
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack

pytestmark = [pytest.mark.validation, pytest.mark.shared_data]

STEFAN_BOLTZMANN = 5.670374419e-8
HEADER = "time,sw_down,lw_down,air_temperature[C],relative_humidity,wind_speed,pressure[hPa]"
FORCING = ("sw_down", "lw_down", "air", "humidity", "wind", "pressure")
SURFRAD_COLUMNS = {
    "sw_down": 8,
    "sw_up": 10,
    "lw_down": 16,
    "lw_up": 22,
    "air": 38,
    "humidity": 40,
    "wind": 42,
    "pressure": 46,
}


def soil(name, absorptance, conductivity, capacity, roughness, wetness=0.0, resistance=0.0):
    """A uniform soil over a constant deep temperature; density carries the volumetric heat capacity."""

    def layer(thickness):
        return Layer(thickness, conductivity, 1600.0, capacity / 1600.0)

    stack = ThermalStack(layer(0.002), (layer(0.1), layer(0.9)), Back("fixed"))
    return SurfaceMaterial(
        name, stack, SurfaceProperties(roughness, wetness, resistance, False, False), absorptance, 0.97
    )


def compare(material, measured, folder):
    """Root mean square error [K] of the model, and of air temperature alone."""
    whole = np.flatnonzero(np.all([np.isfinite(measured[name]) for name in FORCING + ("lw_up",)], axis=0))
    measured = {name: values[whole] for name, values in measured.items()}
    rows = [
        f"{time}Z," + ",".join(f"{measured[name][i]:.4f}" for name in FORCING)
        for i, time in enumerate(np.datetime_as_string(measured["time"], unit="s"))
    ]
    file = folder / "record.csv"
    file.write_text("\n".join([HEADER, *rows]) + "\n")
    found = column.from_record(material, file, 0.0, 0.0, None, 0.2)
    emitted = measured["lw_up"] - (1 - material.thermal_emissivity) * measured["lw_down"]
    truth = (emitted / (material.thermal_emissivity * STEFAN_BOLTZMANN)) ** 0.25
    error, air_error = found.temperature[whole - whole[0]] - truth, measured["air"] + 273.15 - truth
    rms, air_rms = np.sqrt(np.mean(error**2)), np.sqrt(np.mean(air_error**2))
    print(
        f"\n{material.name}: rms {rms:.2f} K, bias {error.mean():+.2f} K, largest {np.abs(error).max():.2f} K; "
        f"air temperature alone {air_rms:.2f} K; end to end of the day {truth[-30:].mean() - truth[:30].mean():+.1f} K"
    )
    return rms, air_rms


def albedo(measured):
    bright = measured["sw_down"] > 0.3 * np.nanmax(measured["sw_down"])
    return float(np.nansum(measured["sw_up"][bright]) / np.nansum(measured["sw_down"][bright]))


def test_surfrad_alamosa(shared_data, tmp_path):
    """A clear winter day on a high semi-desert: moist frozen sandy clay, half-way between dry and saturated clay soil
    (Oke 1987, table 2.1: k 0.915 W/mK, C 2.26 MJ/m3K), sparse low brush (z0 2 cm), albedo as measured that day."""
    table = np.loadtxt(shared_data / "heat" / "surfrad" / "surfrad-slv16001.dat", skiprows=2)
    measured = {name: table[:, index] for name, index in SURFRAD_COLUMNS.items()}
    measured["time"] = np.datetime64("2016-01-01T00:00:00") + np.arange(len(table)) * np.timedelta64(60, "s")
    material = soil("alamosa", 1 - albedo(measured), 0.915, 2.26e6, 0.02)
    rms, air = compare(material, measured, tmp_path)
    assert rms < 2.5 and rms < 0.6 * air


def test_arm_e13(shared_data, tmp_path):
    """An overcast, windy winter day on dormant pasture: dead grass mat over moist loam (Oke 1987, table 2.1: clay
    soil half-way between dry and saturated), short grass z0 2 cm, albedo as measured that day."""
    netcdf = pytest.importorskip("netCDF4")
    folder = shared_data / "heat" / "arm_e13"
    with (
        netcdf.Dataset(folder / "sgpsirsE13.b1.20190101.000000.cdf") as sky,
        netcdf.Dataset(folder / "sgpmetE13.b1.20190101.000000.cdf") as met,
    ):
        measured = {
            "sw_down": sky["down_short_hemisp"][:].filled(np.nan),
            "sw_up": sky["up_short_hemisp"][:].filled(np.nan),
            "lw_down": sky["down_long_hemisp_shaded"][:].filled(np.nan),
            "lw_up": sky["up_long_hemisp"][:].filled(np.nan),
            "air": met["temp_mean"][:].filled(np.nan),
            "humidity": met["rh_mean"][:].filled(np.nan),
            "wind": met["wspd_arith_mean"][:].filled(np.nan),
            "pressure": 10 * met["atmos_pressure"][:].filled(np.nan),
        }
    measured["time"] = np.datetime64("2019-01-01T00:00:00") + np.arange(1440) * np.timedelta64(60, "s")
    material = soil("arm e13", 1 - albedo(measured), 0.915, 2.26e6, 0.02)
    rms, air = compare(material, measured, tmp_path)
    assert rms < 2.5
