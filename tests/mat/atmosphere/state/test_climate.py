"""Profiles by place and date: the report's own places and months give its profiles, others lie between."""

import datetime

import numpy as np
import pytest

from skyshine.mat.atmosphere.state.climate import WEIGHT_STEP, blended_profile, profile_weights
from skyshine.mat.atmosphere.state.humidity import saturation_pressure
from skyshine.mat.atmosphere.state.profiles import LATITUDES, load_profile
from skyshine.schemas.errors import InputError

JANUARY, JULY = datetime.date(2026, 1, 15), datetime.date(2026, 7, 16)


@pytest.mark.parametrize("name", [name for name in LATITUDES if name != "us_standard"])
def test_the_places_and_months_of_the_report_give_its_profiles(name):
    """Anderson et al. 1986: 15 N all year, 45 N and 60 N in July and January; half a year later in the south."""
    summer, winter = (JULY, JANUARY) if not name.endswith("winter") else (JANUARY, JULY)
    assert profile_weights(LATITUDES[name], summer) == {name: 1.0}
    assert profile_weights(-LATITUDES[name], winter) == {name: 1.0}
    assert np.array_equal(blended_profile({name: 1.0}).temperature, load_profile(name).temperature)


def test_weights_are_halves_between_belts_and_in_spring_and_autumn():
    assert profile_weights(30.0, JULY) == {"tropical": 0.5, "midlatitude_summer": 0.5}
    assert profile_weights(45.0, datetime.date(2026, 4, 16)) == {"midlatitude_summer": 0.5, "midlatitude_winter": 0.5}
    assert profile_weights(0.0, JANUARY) == profile_weights(-8.0, JULY) == {"tropical": 1.0}
    assert profile_weights(90.0, JANUARY) == {"subarctic_winter": 1.0}


def test_weights_of_any_day_and_latitude_are_steps_with_the_sum_1():
    days = [datetime.date(2024, 1, 1) + datetime.timedelta(days=number) for number in range(366)]
    for latitude in np.linspace(-90, 90, 37):
        for date in days[::7]:
            weights = np.array(list(profile_weights(latitude, date).values()))
            assert weights.sum() == pytest.approx(1.0, abs=1e-12) and np.all(weights > 0)
            assert np.allclose(weights / WEIGHT_STEP, np.rint(weights / WEIGHT_STEP))
    year = {tuple(profile_weights(50.0, date).items()) for date in days}
    assert 40 < len(year) < 90  # a year has as many airs, not 366


def test_a_blend_lies_between_its_parts_and_is_not_saturated():
    weights = {"midlatitude_summer": 0.5, "subarctic_winter": 0.5}
    blend, parts = blended_profile(weights), [load_profile(name) for name in weights]
    assert blend.name == "0.5 midlatitude_summer + 0.5 subarctic_winter"
    assert blend.temperature[0] == pytest.approx((294.2 + 257.2) / 2)
    for gas, fraction in blend.mole_fraction.items():
        low, high = (edge([part.mole_fraction[gas] for part in parts], axis=0) for edge in (np.min, np.max))
        assert np.all(fraction >= low * (1 - 1e-12)) and np.all(fraction <= high * (1 + 1e-12)), gas
    low = blend.altitude < 12e3
    vapour = blend.mole_fraction["H2O"] * blend.pressure / saturation_pressure(blend.temperature)
    parts_vapour = [p.mole_fraction["H2O"] * p.pressure / saturation_pressure(p.temperature) for p in parts]
    assert np.all(vapour[low] <= np.max(parts_vapour, axis=0)[low])


def test_a_blend_is_nearly_in_hydrostatic_balance():
    """Weight of the air between two levels, g p / (R T), within 2 % of the fall of pressure, as in its parts."""
    blend = blended_profile({"tropical": 0.3, "midlatitude_winter": 0.7})
    thickness, mean = np.diff(blend.altitude[:26]), 0.5 * (blend.temperature[1:26] + blend.temperature[:25])
    fall = 287.05 * mean / 9.78 * -np.diff(np.log(blend.pressure[:26]))
    assert fall / thickness == pytest.approx(1.0, abs=0.02)


def test_a_name_that_is_none_is_refused():
    with pytest.raises(InputError, match="did you mean 'tropical'"):
        blended_profile({"tropic": 0.5, "us_standard": 0.5})
