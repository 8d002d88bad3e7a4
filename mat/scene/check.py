"""Whether all that a job names can be read and computed."""

from __future__ import annotations

from skyshine.mat.job.load import LoadedJob
from skyshine.mat.scene.atmosphere import air_key, atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.schemas.errors import InputError
from skyshine.tmm.job.model import TextureJob


def check_scene(loaded: LoadedJob) -> None:
    """Check what the models alone cannot: that the band model covers each band, that the air of each state can be
    made, that measured light fits the Sun, and that images are there.

    Raises
    ------
    InputError
        At the place in the job.
    """
    _check_images(loaded)
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
            if state.weather.measured:
                from skyshine.mat.scene.surface import check_measured_light  # slow to import

                check_measured_light(loaded.trimmed, i + 1)
            if (air := air_key(state)) not in checked:
                checked.add(air)
                atmospheric_state(loaded.trimmed.site, state)
        except InputError as error:
            if error.file is not None:  # in a file of its own
                raise
            raise loaded.document.error(("states", i), f"states.{i}: {error.message}") from None


def _check_images(loaded: LoadedJob) -> None:
    """Refuse a texture whose image, label image or seeds do not exist."""
    for i, texture in enumerate(loaded.trimmed.textures):
        if not isinstance(texture, TextureJob):
            continue
        sources = [source for source in (texture.seeds, texture.overrides) if source is not None]
        names = [texture.image, *(source.file for source in sources)]
        names += [source.labels.image for source in sources if source.labels is not None]
        missing = next((name for name in names if name and not (loaded.folder / name).is_file()), None)
        if missing is not None:
            raise loaded.document.error(
                ("textures", i), f"textures.{i}: found '{missing}', which does not exist; name a file that is there"
            )
