"""Times of the day placed where temperatures bend, and places of an axis that may become nodes."""

import numpy as np
import pytest

from skyshine.mat.measure.surface_nodes import _beside, placed_times, read_temperature

SUNRISE, SUNSET = 6.37, 18.11


def axes(times, **others):
    plain = {"altitude_km": [0.0], "azimuth_deg": [0.0, 180.0], "slope_deg": [0.0, 90.0], "time_h": times}
    return {name: np.asarray(values, float) for name, values in (plain | others).items()}


def thin_sheet(at):
    """Warm by day with a bend at sunrise and at sunset, colder higher up."""
    altitude, azimuth, slope, time = np.meshgrid(*at.values(), indexing="ij")
    day = np.maximum(np.sin(np.pi * (np.mod(time, 24.0) - SUNRISE) / (SUNSET - SUNRISE)), 0.0)
    inside = (np.mod(time, 24.0) > SUNRISE) & (np.mod(time, 24.0) < SUNSET)
    face = 1 + 0.3 * np.cos(np.radians(azimuth)) * np.sin(np.radians(slope))
    return (285 - 6.5 * altitude + 30 * np.where(inside, day, 0.0) * face)[None]


def error(times, period):
    asked = np.linspace(times[0], times[0] + 24.0 if period else times[-1], 3001)
    (truth,) = thin_sheet(axes(asked % 24.0, azimuth_deg=[0.0], slope_deg=[0.0]))[0, 0, 0]
    (nodes,) = thin_sheet(axes(times % 24.0, azimuth_deg=[0.0], slope_deg=[0.0]))[0, 0, 0]
    return np.abs(np.interp(asked, times, nodes, **({"period": 24.0} if period else {})) - truth).max()


def test_as_many_times_err_less_where_the_curve_bends():
    even = np.arange(20) * 1.2
    times = placed_times(thin_sheet, axes(even), whole_day=True, seed=1)
    assert times.size == even.size and times[0] >= 0 and times[-1] < 24 and np.all(np.diff(times) > 0)
    assert error(times, True) < error(even, True) / 3
    for bend in (SUNRISE, SUNSET):
        assert np.abs(times - bend).min() <= 0.1


def test_times_of_a_part_of_the_day_keep_its_ends():
    even = np.linspace(17.0, 30.0, 9)  # from the afternoon to the next morning
    times = placed_times(thin_sheet, axes(even), whole_day=False, seed=1)
    assert times.size == even.size and np.all(np.diff(times) > 0)
    assert times[[0, -1]].tolist() == [17.0, 30.0]
    assert error(times, False) < error(even, False) / 2


@pytest.mark.parametrize("whole_day", [True, False])
@pytest.mark.parametrize("count", [1, 2, 3, 7])
def test_a_day_that_never_changes_keeps_its_number_of_times(count, whole_day):
    times = placed_times(
        lambda at: np.full((2, *(values.size for values in at.values())), 280.0),
        axes(np.arange(count) * 2.5),
        whole_day=whole_day,
        seed=3,
    )
    assert times.size == count and np.all(np.diff(times) > 0)


def test_a_job_without_times_is_the_same_for_the_same_seed():
    even = np.arange(12) * 2.0
    one, same = (placed_times(thin_sheet, axes(even), whole_day=True, seed=7) for _ in range(2))
    assert np.array_equal(one, same)


@pytest.mark.parametrize("whole_day", [True, False])
def test_the_nodes_beside_places_read_as_the_whole_table(whole_day):
    """Azimuths go round, and the places lie in few of the cells; a face without cells keeps its node."""
    generator = np.random.default_rng(4)
    whole = axes(
        np.arange(0.0, 24.0, 1.5),
        altitude_km=np.linspace(0, 3, 9),
        azimuth_deg=np.arange(5.0, 360, 15),
        slope_deg=[30.0],
    )
    places = axes(
        generator.uniform(0, 22.5, 6),
        altitude_km=generator.uniform(0, 3, 2),
        azimuth_deg=np.array([1.0, 200.0, 359.0]),
        slope_deg=[30.0],
    )
    open_axes = () if whole_day else ("time_h",)
    few = _beside(whole, places, open_axes)
    assert few["azimuth_deg"].tolist() == [5, 200, 215, 350] and few["altitude_km"].size <= 4
    read = [read_temperature(thin_sheet(at), at, places, open_axes) for at in (whole, few)]
    assert read[1] == pytest.approx(read[0], abs=1e-9)
