"""Streams of random numbers: no two purposes share one, and a seed gives the same numbers again."""

from itertools import combinations

import numpy as np

from skyshine.mat.measure.random_streams import NUMBERS, Stream, random_stream


def test_no_two_purposes_share_their_numbers():
    """Also not the seed alone, which numpy gives to [seed, 0] too."""
    assert set(NUMBERS) == set(Stream)
    first = {stream: random_stream(1, stream).random() for stream in Stream}
    first["the seed alone"] = np.random.default_rng(1).random()
    assert all(first[one] != first[other] for one, other in combinations(first, 2))


def test_a_seed_gives_the_same_numbers_again_and_another_others():
    one, again, other = (random_stream(seed, Stream.VIEWS, 1).random(3) for seed in (5, 5, 6))
    assert np.array_equal(one, again) and not np.array_equal(one, other)
