"""Whether all that a job names can be read and computed."""

from __future__ import annotations

from skyshine.mat.job.load import LoadedJob
from skyshine.mat.scene.atmosphere import air_key, atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.surface import check_measured_light
from skyshine.schemas.errors import InputError


def check_scene(loaded: LoadedJob) -> None:
    """Check what the models alone cannot: that the band model covers each band, that the air of each state can be
    made, and that measured light fits the Sun.

    Raises
    ------
    InputError
        At the place in the job.
    """
    table = absorption_table()
    for i, band in enumerate(loaded.trimmed.bands):
        response = response_of(band)
        low, high = response.wavenumber_range
        if not any(start <= low and high <= end for start, end in table.coverage):
            spans = ", ".join(f"{1e4 / end:.4g} to {1e4 / start:.4g} um" for start, end in table.coverage)
            span = f"{response.lower:g} to {response.upper:g} um"
            raise loaded.document.error(
                ("bands", i), f"bands.{i}: found {span}; allowed: inside {spans}, which the band model covers"
            )
    checked = set()
    for i, state in enumerate(loaded.trimmed.states):
        try:
            check_measured_light(loaded.trimmed, i + 1)
            if (air := air_key(state)) not in checked:
                checked.add(air)
                atmospheric_state(loaded.trimmed.site, state)
        except InputError as error:
            if error.file is not None:  # in a file of its own
                raise
            raise loaded.document.error(("states", i), f"states.{i}: {error.message}") from None
