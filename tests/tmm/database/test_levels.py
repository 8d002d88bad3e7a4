"""Mip levels against counting by brute force in exact fractions."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from skyshine.tmm.database.layout import in_ratios, in_steps
from skyshine.tmm.database.levels import (
    WEIGHT_TOTAL,
    Composites,
    Level,
    LevelStream,
    integer_weights,
    level_sizes,
    pure_level,
    ranked,
)


def mip_levels(code: np.ndarray, step: int | None = None) -> list[Level]:
    """All levels of an image that comes `step` rows at a time."""
    step, stream = step or len(code), LevelStream(*code.shape, np.unique(np.append(code[code > 0], 9)))
    parts = [[pure_level(code)], *([] for _ in level_sizes(*code.shape)[1:])]
    for top in range(0, len(code), step):
        for level, row, part in stream.add(code[top : top + step]):
            assert row == sum(len(earlier.code) for earlier in parts[level])
            parts[level].append(part)
    names = ("code", "mix_code", "mix_weight")
    return [Level(*(np.concatenate([getattr(part, name) for part in level]) for name in names)) for level in parts]


def _overlaps(cell: int, parts: int, length: int):
    """Texels that a cell covers along one axis, each with the covered part of it."""
    start, end = Fraction(cell * length, parts), Fraction((cell + 1) * length, parts)
    for texel in range(int(start), length):
        covered = min(end, texel + 1) - max(start, texel)
        if covered <= 0:
            break
        yield texel, covered


def _shares(code, row, column, size):
    total = {}
    for y, part_y in _overlaps(row, size[0], code.shape[0]):
        for x, part_x in _overlaps(column, size[1], code.shape[1]):
            if code[y, x]:
                total[int(code[y, x])] = total.get(int(code[y, x]), 0) + part_y * part_x
    return sorted(total.items(), key=lambda item: (-item[1], item[0]))


@pytest.mark.parametrize("shape", [(1, 1), (8, 8), (5, 7), (1, 13), (12, 20), (17, 3), (24, 6)])
@pytest.mark.parametrize("materials, step", [(2, None), (6, None), (6, 1), (6, 3)])
def test_shares_are_exact(shape, materials, step):
    code = np.random.default_rng(materials).integers(0, materials, shape).astype(np.uint16)
    levels = mip_levels(code, step)
    assert [level.code.shape for level in levels] == level_sizes(*shape)
    np.testing.assert_array_equal(levels[0].code, code)
    for level in levels:
        for row, column in np.ndindex(level.code.shape):
            shares = _shares(code, row, column, level.code.shape)
            top = shares[:3]
            expected = [name for name, _ in top] + [0] * (3 - len(top))
            assert level.mix_code[row, column].tolist() == expected
            assert level.code[row, column] == expected[0]
            whole = sum(share for _, share in top)
            for rank, (_, share) in enumerate(top):
                assert abs(level.mix_weight[row, column, rank] - share / whole * WEIGHT_TOTAL) < 1


@pytest.mark.parametrize("shape", [(1, 1), (8, 8), (5, 7), (12, 20), (17, 3)])
@pytest.mark.parametrize("step", [1, 3, 100])
def test_shares_of_mixtures_are_exact(shape, step):
    """Levels of mixed texels, rows of them at a time, against exact fractions."""
    random = np.random.default_rng(sum(shape))
    counts = np.where(random.random((5, *shape)) < 0.5, random.integers(1, 1000, (5, *shape)), 0)
    first = ranked(np.arange(1, 6, dtype=np.uint16), counts)
    stream, parts = LevelStream(*shape, np.arange(1, 6)), [[] for _ in level_sizes(*shape)]
    for top in range(0, shape[0], step):
        rows = slice(top, top + step)
        for level, _, part in stream.add_mixed(Level(first.code[rows], first.mix_code[rows], first.mix_weight[rows])):
            parts[level].append(part)
    planes = {code: np.where(first.mix_code == code, first.mix_weight, 0).sum(axis=-1) for code in range(1, 6)}
    for size, level in zip(level_sizes(*shape)[1:], parts[1:], strict=True):
        mix_code, mix_weight = (np.concatenate([getattr(p, n) for p in level]) for n in ("mix_code", "mix_weight"))
        assert mix_code.shape[:2] == size
        for row, column in np.ndindex(size):
            area = [
                (y, x, part_y * part_x)
                for y, part_y in _overlaps(row, size[0], shape[0])
                for x, part_x in _overlaps(column, size[1], shape[1])
            ]
            total = {code: sum(int(plane[y, x]) * part for y, x, part in area) for code, plane in planes.items()}
            top = sorted(((s, -code) for code, s in total.items() if s), reverse=True)[:3]
            assert mix_code[row, column].tolist() == [-code for _, code in top] + [0] * (3 - len(top))
            whole = sum(share for share, _ in top)
            for rank, (share, _) in enumerate(top):
                assert abs(mix_weight[row, column, rank] - share / whole * WEIGHT_TOTAL) < 1


def test_shares_of_a_huge_image_do_not_overflow():
    """Counts as of 2^18 x 2^18 texels in units of 1 / 65535, far beyond 64 bits once multiplied by 65535."""
    counts = np.array([2**52, 2**51, 2**50], np.int64).reshape(3, 1, 1)
    level = ranked(np.array([1, 2, 3], np.uint16), counts)
    assert np.abs(level.mix_weight[0, 0] / WEIGHT_TOTAL - np.array([4, 2, 1]) / 7).max() < 1 / WEIGHT_TOTAL


def test_levels_in_small_pieces_are_those_in_one(monkeypatch):
    code = np.random.default_rng(5).integers(0, 4, (21, 9)).astype(np.uint16)
    whole = mip_levels(code)
    monkeypatch.setattr("skyshine.tmm.database.levels.PIECE_TEXELS", 10)  # two rows of level 1, and one that is left
    for level, pieced in zip(whole, mip_levels(code, 7), strict=True):
        for name in ("code", "mix_code", "mix_weight"):
            np.testing.assert_array_equal(getattr(pieced, name), getattr(level, name))


def test_level_sizes_end_with_one_texel():
    assert level_sizes(540, 960)[:3] == [(540, 960), (270, 480), (135, 240)]
    assert level_sizes(540, 960)[-1] == (1, 1) and level_sizes(1, 1) == [(1, 1)]


@given(hnp.arrays(np.uint16, hnp.array_shapes(min_dims=2, max_dims=2, max_side=12), elements=st.integers(0, 4)))
@settings(deadline=None, max_examples=60)
def test_no_level_invents_a_material(code):
    present = set(np.unique(code))
    for level in mip_levels(code):
        assert set(np.unique(level.mix_code)) <= present | {0}
        assert (level.mix_weight.sum(axis=-1, dtype=int) == WEIGHT_TOTAL).all()
        assert (np.diff(level.mix_weight.astype(int), axis=-1) <= 0).all()
        assert ((level.mix_weight > 0) | (level.mix_code == 0)).all()


@given(st.lists(st.integers(0, 1 << 30), min_size=3, max_size=3), st.sampled_from([100, 255, WEIGHT_TOTAL]))
def test_integer_weights_sum_exactly(counts, total):
    counts = np.sort(np.array(counts, np.int64))[::-1][:, np.newaxis].copy()
    weights = integer_weights(counts, total)
    assert weights.sum() == total and (weights >= 0).all()
    if counts.sum():
        assert np.abs(weights / total - counts / counts.sum()).max() < 1 / total


def test_composites_list_every_mixture_once():
    code = np.array([[1, 1, 2, 2], [1, 3, 2, 2]], np.uint16)
    composites = Composites()
    for level in mip_levels(code):
        composites.add(level)
    components, weights = composites.mixtures()
    found = {(*map(int, c), *map(int, w)) for c, w in zip(components, weights, strict=True)}
    pure = {(k, 0, 0, 100, 0, 0) for k in (1, 2, 3)}
    assert found == pure | {(1, 3, 0, 75, 25, 0), (2, 1, 3, 50, 38, 12)} and len(components) == len(found)


def test_radiance_of_mixtures():
    """Band radiance from the fractions against the mean over the texels below, with three materials in the scene."""
    code = np.kron(np.random.default_rng(7).integers(1, 4, (9, 11)), np.ones((7, 5), int)).astype(np.uint16)
    # Spectral radiance of blackbodies at 10 um, W m-2 sr-1 um-1, of 260, 300 and 340 K, by Planck's law.
    temperature = np.array([np.inf, 260.0, 300.0, 340.0])
    radiance = 1.191042972e8 / 10.0**5 / np.expm1(14387.76877 / (10.0 * temperature[1:]))
    radiance = np.concatenate([[0.0], radiance])
    for level in mip_levels(code, 16):
        mixed = (radiance[level.mix_code] * level.mix_weight).sum(axis=-1) / WEIGHT_TOTAL
        for row, column in np.ndindex(level.code.shape):
            shares = _shares(code, row, column, level.code.shape)
            exact = float(
                sum(radiance[number] * float(share) for number, share in shares) / float(sum(s for _, s in shares))
            )
            assert mixed[row, column] == pytest.approx(exact, rel=1e-4)


def test_steps_of_stored_doubt():
    """Confidence to 1/128; typicality to a factor of 2, by powers of 4; ends and absent values as they are."""
    values = np.linspace(0, 1, 1001, dtype=np.float32)
    np.testing.assert_allclose(in_steps(values), values, rtol=0, atol=1 / 128)
    assert in_steps(np.float32([0, 0.5, 1])).tolist() == [0, 0.5, 1]
    typical = np.geomspace(1 / 512, 1, 1000).astype(np.float32)
    ratio = in_ratios(typical * np.float32(1 + 1e-6)) / typical
    assert ratio.max() <= 2 * (1 + 1e-5) and ratio.min() >= 0.5 * (1 - 1e-5)
    assert in_ratios(np.float32([0, 1e-9, 0.0019, 0.002, 0.01, 0.3, 1])).tolist() == [0, 0, 0, 4**-4, 4**-3, 0.25, 1]


def test_stored_doubt_is_short():
    """Noise keeps 3 bytes in a float and less than one in a file."""
    noise = np.random.default_rng(0).random(1 << 16, dtype=np.float32)
    for coarse in (in_steps, in_ratios):
        stored = coarse(noise).view(np.uint32)
        assert not (stored & 0xFFFF).any()
