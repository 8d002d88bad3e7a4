"""Chunks that are packed here against those that HDF5 packs and reads itself."""

import zlib

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from skyshine.schemas.array_digest import array_digest, byte_planes
from skyshine.schemas.hdf5 import Axis, Filled, Group, Header, Streamed, Variable, is_current, write_file
from skyshine.schemas.hdf5_chunks import ChunkWriter, Packing, fletcher32, packed

HEADER = Header("tmm", "materials 1.0.0", "name: x\n", "A title")
PACKINGS = [Packing(1, zlib.Z_RLE), Packing(4), Packing(9)]
FILTERS = {"compression": "gzip", "compression_opts": 4, "shuffle": True, "fletcher32": True}


def _dataset(file, shape, dtype, chunks):
    return file.create_dataset("a", shape, dtype, chunks=chunks, **FILTERS)


def _kinds(random, shape):
    yield random.integers(0, 1 << 16, shape).astype("<u2")  # all planes hold something
    yield random.integers(0, 3, shape).astype("<u2")
    yield (random.integers(0, 65, shape) / 64).astype("<f4")
    yield np.full(shape, 65535, "<u2")
    yield np.zeros(shape, "<f4")
    yield random.integers(0, 256, shape).astype("u1")
    yield random.normal(size=shape).astype("<f8")


@pytest.mark.parametrize("packing", PACKINGS)
@pytest.mark.parametrize(
    "shape, chunks", [((96, 64), (32, 32)), ((70, 45), (32, 32)), ((5, 3), (5, 3)), ((1, 9), (1, 4))]
)
def test_hdf5_reads_what_is_packed(tmp_path, packing, shape, chunks):
    for values in _kinds(np.random.default_rng(0), shape):
        with h5py.File(tmp_path / "a.h5", "w", libver=("v110", "v110")) as file:
            writer = ChunkWriter(_dataset(file, shape, values.dtype, chunks), packing)
            for top in range(0, shape[0], chunks[0]):
                writer.write((top, 0), values[top : top + chunks[0]])
        with h5py.File(tmp_path / "a.h5") as file:
            np.testing.assert_array_equal(file["a"][()], values)


def test_mixtures_have_a_third_axis(tmp_path):
    values = np.random.default_rng(1).integers(0, 9, (20, 33, 3)).astype("<u2")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        ChunkWriter(_dataset(file, values.shape, "<u2", (8, 16, 3)), Packing(4)).write((0, 0, 0), values)
        np.testing.assert_array_equal(file["a"][()], values)


def test_an_array_without_chunks_is_written_as_it_is(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        ChunkWriter(file.create_dataset("a", (1, 1), "<u2"), Packing(4)).write((0, 0), np.array([[7]], "u2"))
        assert file["a"][0, 0] == 7


def test_a_chunk_like_the_one_before_is_stored_again_and_another_is_not(tmp_path):
    values = np.concatenate([np.full((8, 8), k, "<u2") for k in (4, 4, 5, 4)])
    with h5py.File(tmp_path / "a.h5", "w") as file:
        ChunkWriter(_dataset(file, values.shape, "<u2", (8, 8)), Packing(4)).write((0, 0), values)
        np.testing.assert_array_equal(file["a"][()], values)


@given(st.binary(min_size=1, max_size=300))
def test_the_checksum_is_that_of_hdf5(data):
    """What HDF5 appends to a chunk behind its filter Fletcher-32 alone."""
    values = np.frombuffer(data, np.uint8)
    with h5py.File("x.h5", "w", driver="core", backing_store=False) as file:
        dataset = file.create_dataset("a", data=values, chunks=values.shape, fletcher32=True)
        file.flush()
        stored = dataset.id.read_direct_chunk((0,))[1]
    assert stored[:-4] == data
    assert stored[-4:] == fletcher32(data).to_bytes(4, "little")


@given(arrays.arrays(np.uint8, st.integers(1, 200).map(lambda n: 4 * n), elements=st.sampled_from([0, 0, 255, 7])))
def test_the_stream_is_one_of_zlib(data):
    planes = byte_planes(data.view("<u4"))
    found = zlib.decompress(packed(planes, Packing(1, zlib.Z_RLE))[:-4])  # raises where Adler-32 is wrong
    assert found == data.reshape(-1, 4).T.tobytes()


def test_a_damaged_chunk_is_noticed(tmp_path):
    values = np.arange(64, dtype="<u2").reshape(8, 8)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        dataset = _dataset(file, values.shape, "<u2", (8, 8))
        chunk = bytearray(packed(byte_planes(values), Packing(4)))
        chunk[10] ^= 1
        dataset.id.write_direct_chunk((0, 0), bytes(chunk))
        with pytest.raises(OSError, match="(?i)checksum|filter"):
            dataset[()]


@pytest.mark.parametrize("planes", [[], byte_planes(np.empty(0, "<u2"))])
def test_a_chunk_without_values_is_refused(planes):
    with pytest.raises(ValueError, match="found a chunk without values"):
        packed(planes, Packing(4))


def test_equal_bytes_of_another_shape_are_another_chunk(tmp_path):
    """The chunks at the right and at the lower border hold the same bytes, which lie elsewhere in a whole chunk."""
    values = np.zeros((10, 10), "<u2")
    values[:8, 8:], values[8:, :8] = np.arange(16).reshape(8, 2), np.arange(16).reshape(2, 8)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        writer = ChunkWriter(_dataset(file, values.shape, "<u2", (8, 8)), Packing(4))
        for place in ((0, 8), (8, 0), (0, 0), (8, 8)):
            writer.write(place, values[place[0] : place[0] + 8, place[1] : place[1] + 8])
        np.testing.assert_array_equal(file["a"][()], values)


@pytest.mark.parametrize("shape", [(300, 520), (256, 256), (17, 600), (600, 17), (300, 270, 3)])
def test_what_is_written_has_the_digest_of_what_is_read(tmp_path, shape):
    values = np.random.default_rng(0).integers(0, 5, shape).astype("<u2")
    values[:256, :256] = 7
    chunks = tuple(min(256, n) for n in shape)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        writer = ChunkWriter(_dataset(file, shape, "<u2", chunks), Packing(4))
        for left in range(0, shape[1], 256):  # columns first: the order of writing is none of the array
            for top in range(0, shape[0], 256):
                assert writer.digest() is None
                writer.write((top, left, 0)[: len(shape)], values[top : top + 256, left : left + 256])
        assert writer.digest() == array_digest(file["a"][()])
        other = file.create_dataset("b", data=values, chunks=tuple(min(100, n) for n in shape))
        assert ChunkWriter(other, Packing(4)).digest() is None


@pytest.mark.parametrize("told", [0, 1])
def test_a_digest_that_is_told_is_that_of_the_array(tmp_path, told):
    """A file whose digest of an array is told as it is holds; one that was told another does not."""
    values = np.arange(12.0, dtype="<f4").reshape(4, 3)

    def fill(file):
        file["a"][...] = values
        return Filled(Group(), {"/a": array_digest(values + np.float32(told))})

    axes = {name: Axis(np.arange(n), "1", "number") for name, n in (("y", 4), ("x", 3))}
    root = Group(axes, {"a": Variable(("y", "x"), Streamed((4, 3), "<f4"), "1", "a")})
    write_file(tmp_path / "a.h5", root, HEADER, fill)
    assert is_current(tmp_path / "a.h5", HEADER) == (not told)
