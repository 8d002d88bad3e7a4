"""Which places are asked about: those that cover the ground, or those where two materials are nearly alike."""

import numpy as np
import pytest

from skyshine.tmm.classify.graph import survey
from skyshine.tmm.features.colour import DistinctColours
from skyshine.tmm.images.texture import Texture
from skyshine.tmm.mapping.suggest import Known, ask

WIDTH, NARROW = 160, 24


@pytest.fixture(scope="module")
def strips():
    """A narrow strip of sand beside a wide one of grass."""
    values = np.full((96, WIDTH, 3), (70, 130, 60.0))
    values[:, :NARROW] = (200, 180, 140)
    pixels = np.clip(values + np.random.default_rng(6).normal(0, 6, values.shape), 0, 255).astype(np.uint8)
    texture = Texture(pixels, np.ones(pixels.shape[:2], bool), "srgb")
    return survey(texture, DistinctColours(texture), None)


@pytest.mark.parametrize("vouched, seeds, narrow", [(True, True, True), (False, True, False), (True, False, False)])
def test_what_is_contested_is_asked_where_seeds_and_a_library_speak(strips, vouched, seeds, narrow):
    """The narrow strip is as likely either material, the wide one rather certain: more of it is expected wrong."""
    columns = strips.superpixels.mean(np.broadcast_to(np.arange(WIDTH), (1, 96, WIDTH)))[:, 0]
    in_narrow, seeded = columns < NARROW - 4, np.zeros(len(columns), bool)
    shares = np.where(in_narrow[:, np.newaxis], (0.5, 0.5), (0.7, 0.3))
    seeded[columns.argmax()] = seeds
    known = Known(("sand", "grass"), shares, np.ones(len(columns)), seeded, vouched)
    ((_, _, column, _, gain),), wrong = ask(strips, known, [], [], 1)
    assert (column < NARROW) == narrow and 0 < gain <= wrong < 0.6
