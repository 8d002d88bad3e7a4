"""Standard profiles by place and date: the five of Anderson et al. blended by latitude and season.

The report gives its profiles for 15 degrees (tropical, the whole year), 45 degrees and 60 degrees (July and January).
Between these latitudes, and between mid-January and mid-July, weights are linear in latitude and in the cosine of the
season; the southern hemisphere has them half a year later. Nearer to the equator and to the poles the nearest is taken.
"""

from __future__ import annotations

import datetime
from collections.abc import Mapping

import numpy as np

from skyshine.mat.atmosphere.state.profiles import LATITUDES, Profile, load_profile
from skyshine.schemas.arrays import Floats

COLDEST_DAY, _YEAR = 15.0, 365.25  # 15 January: the middle of the month that the winter profiles represent
WEIGHT_STEP = 0.02  # step of the weights, so that days of the same fortnight share their air


def profile_weights(latitude: float, date: datetime.date) -> dict[str, float]:
    """Weights of the standard profiles at a place and date.

    Parameters
    ----------
    latitude : float
        [degree], negative in the southern hemisphere.

    Returns
    -------
    dict of str to float
        Weights above 0, multiples of 1/50 with the sum 1.

    References
    ----------
    Anderson et al. 1986, AFGL-TR-86-0110: latitudes and months of the profiles.

    Examples
    --------
    >>> import datetime
    >>> profile_weights(50.0, datetime.date(2026, 7, 15))
    {'midlatitude_summer': 0.66, 'subarctic_summer': 0.34}
    >>> profile_weights(-33.9, datetime.date(2026, 7, 15))
    {'tropical': 0.38, 'midlatitude_winter': 0.62}
    """
    day = date.timetuple().tm_yday - COLDEST_DAY + (0.0 if latitude >= 0 else _YEAR / 2)
    summer = 0.5 - 0.5 * np.cos(2 * np.pi * day / _YEAR)
    belts = [LATITUDES[name] for name in ("tropical", "midlatitude_summer", "subarctic_summer")]
    tropical, middle, subarctic = (float(np.interp(abs(latitude), belts, unit)) for unit in np.eye(3))
    weights = {
        "tropical": tropical,
        "midlatitude_summer": middle * summer,
        "midlatitude_winter": middle * (1 - summer),
        "subarctic_summer": subarctic * summer,
        "subarctic_winter": subarctic * (1 - summer),
    }
    steps = {name: round(weight / WEIGHT_STEP) for name, weight in weights.items()}
    largest = max(weights, key=weights.__getitem__)
    steps[largest] += round(1 / WEIGHT_STEP) - sum(steps.values())
    return {name: round(count * WEIGHT_STEP, 2) for name, count in steps.items() if count > 0}


def blended_profile(weights: Mapping[str, float]) -> Profile:
    """A profile between standard ones.

    Temperature, the logarithm of pressure and the mole fractions are weighted means at each altitude; water vapour by
    its logarithm, so that the blend of two profiles that are not saturated is not saturated either.

    Parameters
    ----------
    weights : mapping of str to float
        Weights by names of `profiles.PROFILES`, above 0, with the sum 1.

    Returns
    -------
    Profile
        Named by its parts; a standard profile itself where there is one part.

    Raises
    ------
    InputError
        A name is no standard profile's.
    """
    parts = [load_profile(name) for name in weights]
    if len(parts) == 1:
        return parts[0]
    share = np.array(list(weights.values()))

    def mean(values: list[Floats]) -> Floats:
        total: Floats = share @ np.array(values)
        return total

    gases = {
        gas: np.exp(mean([np.log(part.mole_fraction[gas]) for part in parts]))
        if gas == "H2O"
        else mean([part.mole_fraction[gas] for part in parts])
        for gas in parts[0].mole_fraction
    }
    return Profile(
        name=" + ".join(f"{weight:g} {name}" for name, weight in weights.items()),
        altitude=parts[0].altitude,
        pressure=np.exp(mean([np.log(part.pressure) for part in parts])),
        temperature=mean([part.temperature for part in parts]),
        mole_fraction=gases,
    )
