"""Days before against measured skin temperature: each day of a measured month as a day that repeats, and as the last
of some days.

The record as a whole, periodic over the month, is what its days can reach: it knows all that came before.
"""

import numpy as np
import pytest
from test_surface_measured import STEFAN_BOLTZMANN, albedo, bsrn, canopy

from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.days import solve_days
from skyshine.mat.surface.record import Record, record_forcing
from skyshine.mat.surface.solver import solve_columns

pytestmark = [pytest.mark.validation, pytest.mark.shared_data]

STEPS = 144  # of ten minutes in a day
HISTORIES = (0, 1, 3, 7)


def part_of(forcing, day):
    """A day of a forcing of one column."""
    rows = {name: np.asarray(values) for name, values in forcing.given.items()}
    chosen = slice(day * STEPS, (day + 1) * STEPS)
    return Forcing(**{name: row if row.shape[-1] == 1 else row[:, chosen] for name, row in rows.items()})


def test_grass_of_payerne_in_june(shared_data):
    """Days 9 to 30 over grass, as `test_surface_measured` takes it. A day that repeats is worst in its first hours,
    for which it takes its own evening."""
    measured = bsrn(shared_data / "heat" / "bsrn" / "bsrn-pay0616.dat.gz")
    material = canopy("grass of Payerne", "grass_green", solar_absorptance=1 - albedo(measured))
    seconds = np.arange(len(measured["time"])) * 600.0
    names = {"air": "air_temperature", "humidity": "relative_humidity", "wind": "wind_speed"}
    values = {names.get(name, name): measured[name] for name in ("sw_down", "lw_down", *names, "pressure")}
    for series in values.values():
        known = np.isfinite(series)
        series[~known] = np.interp(seconds[~known], seconds[known], series[known])
    values["air_temperature"] = values["air_temperature"] + 273.15
    values["pressure"] = values["pressure"] * 100.0
    record = Record.of(seconds, values | {"wind_height": np.full(len(seconds), 2.0)})
    total = record.values["sw_down"]
    whole = record_forcing(record, (0 * total, total, 0 * total), 0.0)
    emitted = measured["lw_up"] - (1 - material.thermal_emissivity) * measured["lw_down"]
    truth = (emitted / (material.thermal_emissivity * STEFAN_BOLTZMANN)) ** 0.25
    ((_, periodic),) = solve_columns(
        material, lambda _: whole, steps=record.steps, fine_steps=None, period=record.period
    )
    first, last = max(HISTORIES) + 1, record.steps // STEPS
    chosen = slice(first * STEPS, last * STEPS)
    error = {"whole month": periodic.temperature[0, chosen] - truth[chosen]}
    for history in HISTORIES:
        found = []
        for day in range(first, last):
            days = [part_of(whole, before) for before in range(day - history, day + 1)]
            ((_, solution),) = solve_days(
                material, [lambda _, part=part: part for part in days], steps=STEPS, fine_steps=None
            )
            found.append(solution.temperature[0])
        error[f"{history} days before"] = np.concatenate(found) - truth[chosen]
    rms = {}
    for name, values in error.items():
        by_day = values.reshape(-1, STEPS)
        night = np.sqrt(np.nanmean(by_day[:, : STEPS // 6] ** 2))
        rms[name] = np.sqrt(np.nanmean(values**2))
        print(f"{name:15s} rms {rms[name]:.2f} K, 0 to 4 h UTC {night:.2f} K")
    assert rms["7 days before"] <= rms["0 days before"] and rms["7 days before"] < rms["whole month"] + 0.05
