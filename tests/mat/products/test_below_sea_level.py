"""Sites below sea level: altitudes below 0 are measured and placed like others."""

import numpy as np
import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.measure.random_streams import Stream, random_stream
from skyshine.mat.measure.surface_nodes import refined_axes
from skyshine.mat.products.temperature import StartAxes, _places
from skyshine.mat.scene.atmosphere import atmospheric_state

JOB = """\
skyshine: 1
name: below the sea
site: {{latitude_deg: 31.5, longitude_deg: 35.5, date: 2026-07-15, utc_offset_h: 2, altitude_km: {altitude}}}
states:
  - profile: midlatitude_summer
    weather: {{air_temperature_c: [29, 40]}}
bands: [{{wavelength_um: [8, 12]}}]
materials: [sand_desert]
"""
# The Dead Sea, Death Valley, a Dutch polder.
ALTITUDES = [-0.43, -0.086, -0.006]


@pytest.fixture(params=ALTITUDES)
def job(request, tmp_path):
    (tmp_path / "job.yaml").write_text(JOB.format(altitude=request.param), encoding="utf-8")
    return load_job(tmp_path / "job.yaml").trimmed


@pytest.mark.parametrize("seed", range(20))
def test_the_places_of_the_error_lie_on_the_axes(job, seed):
    axes = StartAxes.of(job).requested
    altitude = _places(axes, True, random_stream(seed, Stream.TEMPERATURE_ERROR), 2)["altitude_km"]
    assert altitude.min() >= axes["altitude_km"][0] and altitude.max() <= axes["altitude_km"][-1]


def test_a_tolerance_places_nodes_below_the_sea():
    base = {
        "altitude_km": np.array([-0.43, -0.1]),
        "azimuth_deg": np.array([0.0]),
        "slope_deg": np.array([0.0]),
        "time_h": np.array([12.0]),
    }

    def temperature(axes):
        assert np.all((axes["altitude_km"] >= -0.43) & (axes["altitude_km"] <= -0.1))
        shape = [1, *(np.size(nodes) for nodes in axes.values())]
        return np.broadcast_to(300 - 6.5 * np.reshape(axes["altitude_km"], (1, -1, 1, 1, 1)), shape)

    refined = refined_axes(temperature, base, 1, 0.1, seed=1, max_nodes=1000)
    assert list(refined.axes["altitude_km"]) == [-0.43, -0.1] and refined.largest < 1e-6


def test_the_air_is_denser_than_at_the_sea(job):
    """Hydrostatic: d ln p = -g M / (R T) dz, 300 K within 10 K."""
    state = atmospheric_state(job.site, job.states[0])
    ground = 1e3 * job.site.altitude_km
    ratio = np.log(state.pressure_at(np.array([ground, 0.0])))
    assert state.altitude[0] == ground
    assert ratio[0] - ratio[1] == pytest.approx(-ground * 9.81 * 0.02896 / (8.314 * 297), rel=0.04)
