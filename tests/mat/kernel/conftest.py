"""Air and lines of sight, each solved once."""

import os
from pathlib import Path

import light_cases
import pytest

BUILT = "SKYSHINE_SMALL_BUILD"  # names a finished build, for runs under sanitizers


@pytest.fixture(scope="package")
def built(request):
    """Folder of the small build."""
    given = os.environ.get(BUILT)
    return Path(given) if given else request.getfixturevalue("small_build")


@pytest.fixture(scope="package")
def case(synthetic_points):
    """Of the name of a state: air at a few spectral points and lines through it."""
    made = {}

    def of(name, points=light_cases.FEW):
        if (name, points) not in made:
            air = light_cases.air_of(name, points, synthetic_points)
            made[name, points] = air, light_cases.lines_through(air)
        return made[name, points]

    return of
