"""A user's sounding, continued to space by a standard profile."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.soundings.files import levels_in_text
from skyshine.mat.atmosphere.soundings.levels import Levels
from skyshine.mat.atmosphere.state.hydrostatics import DRY_AIR_MOLAR_MASS, gravity
from skyshine.mat.atmosphere.state.profiles import Profile
from skyshine.mat.radiometry.constants import GAS_CONSTANT
from skyshine.mat.surface.vapour import saturation_pressure

# The air at the lowest level is continued down this far at its own temperature; above the highest level its difference
# from the standard profile fades out over the other.
_BELOW = 500.0  # m
_FADE = 5e3  # m


def read_sounding(text: str, file: str | os.PathLike[str], above: Profile) -> Profile:
    """Read the sounding of a text.

    Parameters
    ----------
    text : str
        CSV, or another format that `levels_in_text` reads.
    file : path
        Named in messages.
    above : Profile
        Continues the sounding to space, and contains the gases that it does not name.

    Returns
    -------
    Profile
        From 500 m below the lowest level.

    Raises
    ------
    InputError
        With file:line:column of a missing or misspelt column, an unknown unit, levels out of order, pressure that does
        not fall or does not fit altitude and temperature, supersaturation, or a value no air has.
    """
    return continued(levels_in_text(text, Path(file)), above)


def continued(sounding: Levels, above: Profile) -> Profile:
    """The sounding with one level below it and the levels of a standard profile above; where its humidity or gases end
    before its levels do, those of the profile.
    """
    scale = DRY_AIR_MOLAR_MASS * gravity(sounding.altitude[0]) / (GAS_CONSTANT * sounding.temperature[0])
    top = sounding.altitude[-1]
    higher = above.altitude > top
    at_top = np.exp(np.interp(top, above.altitude, np.log(above.pressure)))
    warmer = sounding.temperature[-1] - np.interp(top, above.altitude, above.temperature)
    fade = np.clip(1 - (above.altitude - top) / _FADE, 0.0, 1.0)
    altitude = np.concatenate([[sounding.altitude[0] - _BELOW], sounding.altitude, above.altitude[higher]])
    pressure = np.concatenate(
        [
            [sounding.pressure[0] * np.exp(scale * _BELOW)],
            sounding.pressure,
            above.pressure[higher] * sounding.pressure[-1] / at_top,
        ]
    )
    temperature = np.concatenate(
        [sounding.temperature[:1], sounding.temperature, (above.temperature + warmer * fade)[higher]]
    )
    gases = {}
    for gas, fraction in above.mole_fraction.items():
        if gas in sounding.mole_fraction:
            measured = sounding.mole_fraction[gas]
            standard = np.interp(sounding.altitude, above.altitude, fraction)
            measured = np.where(np.isfinite(measured), measured, standard)
            gases[gas] = np.concatenate([measured[:1], measured, fraction[higher]])
        else:
            gases[gas] = np.interp(altitude, above.altitude, fraction)
    gases["H2O"] = np.minimum(gases["H2O"], saturation_pressure(temperature) / pressure)
    return Profile(sounding.file.name, altitude, pressure, temperature, gases)
