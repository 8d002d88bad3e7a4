"""The streams of random numbers of a job's seed, by purpose."""

from __future__ import annotations

from enum import StrEnum

import numpy as np


class Stream(StrEnum):
    """Purposes of random numbers."""

    ATMOSPHERE_ERROR = "lines of sight on which the atmospheric tables are measured"
    PIXELS = "pixels of the ground on which they are measured too"
    TEMPERATURE_ERROR = "places at which the temperature table is measured"
    VIEWS = "views of the error budget, by source"
    BUDGET = "what the error budget draws for its views"
    TEMPERATURE_NODES = "places by which nodes of the temperature table are placed"
    SHADE_ERROR = "shadows under which the response of surfaces is measured"
    TILTED_FACES = "faces on which harmonics of ambient light are measured"
    CIRCUMSTANCES = "shadows and walls around the faces of the error budget"
    CHANNELS = "lines of sight of tables in channels: of absorbers, of source directions, of their error"
    UNMODELLED = "buildings before the Sun and edges of materials in the error budget"
    BAND_ERROR = "temperatures and angles at which the table of a band is measured"
    VERTICES = "faces in textures, and the materials of their vertices, in the error budget"


# Joined to the seed, each once. None is 0: numpy gives [seed, 0] the numbers of the seed alone, which belongs to layers
# below: the choice of spectral points (`skyshine.mat.atmosphere.band`).
NUMBERS: dict[Stream, int] = {
    Stream.ATMOSPHERE_ERROR: 6,
    Stream.TEMPERATURE_ERROR: 7,
    Stream.VIEWS: 1,
    Stream.BUDGET: 2,
    Stream.TEMPERATURE_NODES: 4,
    Stream.SHADE_ERROR: 9,
    Stream.TILTED_FACES: 10,
    Stream.CIRCUMSTANCES: 11,
    Stream.CHANNELS: 12,
    Stream.BAND_ERROR: 13,
    Stream.UNMODELLED: 14,
    Stream.VERTICES: 15,
    Stream.PIXELS: 16,
}


def random_stream(seed: int, stream: Stream, *parts: int) -> np.random.Generator:
    """A generator of random numbers.

    Parameters
    ----------
    seed : int
        Seed of the job.
    parts : int
        Identifiers of streams that are divided further: the number of the quantity or source.
    """
    return np.random.default_rng([seed, NUMBERS[stream], *parts])
