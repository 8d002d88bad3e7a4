"""Direct beams of clear hours at Alamosa (SURFRAD, 2016-01-01) under the typical optical depth and that of 23 km.

Columns of NOAA's SURFRAD files: 4 hour, 5 minute, 12 direct normal, 13 its flag. A clear hour is a straight line of
minutes. The day is far clearer than the month. Run with ``-s`` for the figures.
"""

import datetime

import numpy as np
import pandas as pd
import pvlib
import pytest

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.spectra.fluxes import broadband_fluxes
from skyshine.mat.atmosphere.state.climate import blended_profile, profile_weights
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.state.turbidity import typical_aerosol

pytestmark = [pytest.mark.validation, pytest.mark.shared_data]

LATITUDE, LONGITUDE, STATION = 37.70, -105.92, 2317.0
DATE = datetime.date(2016, 1, 1)


def clear_hours(path):
    """Times in the middle of clear hours, and the direct beam then, W m^-2."""
    minutes = np.array([line.split() for line in path.read_text().splitlines()[2:]], float)
    found = []
    for hour in range(15, 24):
        rows = minutes[minutes[:, 4] == hour]
        beam = rows[:, 12]
        line = np.polyval(np.polyfit(rows[:, 5], beam, 1), rows[:, 5])
        if np.all(rows[:, 13] == 0) and beam.mean() > 300 and np.std(beam - line) < 0.01 * beam.mean():
            found.append((f"{DATE}T{hour:02d}:30Z", beam[25:35].mean()))
    times, beams = zip(*found, strict=True)
    return pd.DatetimeIndex(times), np.array(beams)


def test_the_typical_depth_takes_less_from_a_clear_beam(shared_data):
    times, measured = clear_hours(shared_data / "heat" / "surfrad" / "surfrad-slv16001.dat")
    assert len(times) >= 5
    elevation = pvlib.solarposition.get_solarposition(times, LATITUDE, LONGITUDE, STATION)["elevation"].to_numpy()
    distance = float(np.mean(pvlib.solarposition.nrel_earthsun_distance(times)))
    typical = typical_aerosol(LATITUDE, LONGITUDE, STATION, DATE)
    profile = blended_profile(profile_weights(LATITUDE, DATE))
    bias = {}
    for name, aerosol in (
        ("23 km", Aerosol("rural")),
        ("typical", Aerosol("rural", optical_depth=typical.optical_depth)),
        ("none", Aerosol("none")),
    ):
        state = AtmosphericState.from_profile(profile, surface_altitude=STATION, aerosol=aerosol)
        light = broadband_fluxes(state, [STATION], elevation, 0.2, sun_distance=distance)
        bias[name] = float(np.mean(light.direct_normal[0] - measured))
        print(f"{name:8s} {state.aerosol_optical_depth(550.0, STATION):.3f} {bias[name]:+7.1f} W m-2")
    assert bias["23 km"] < -200 and abs(bias["typical"]) < 0.5 * abs(bias["23 km"]) and abs(bias["none"]) < 40
