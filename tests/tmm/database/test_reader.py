"""The database: what is written comes back, the same input gives the same bytes, other readers open it."""

import warnings

import h5py
import numpy as np
import pytest

from skyshine.schemas.errors import InputError
from skyshine.tmm import map_texture, open_tmm, read_usage, write_texture
from skyshine.tmm.database.levels import LevelStream
from skyshine.tmm.database.usage import library_usage
from skyshine.tmm.mapping.write import is_current

GREEN, GREY = "grass_green", "asphalt_road"


@pytest.fixture
def built(job, two_halves, tmp_path, library):
    mapped = map_texture(job(two_halves), tmp_path, library)
    path = tmp_path / "out" / "halves.tmm.h5"
    write_texture(mapped, path)
    return mapped, path


def _windows(mapped):
    """Codes and confidence of the whole texture."""
    ((_, _, level, found),) = mapped.windows()
    return level.code, found.confidence


def test_round_trip(built, library):
    mapped, path = built
    code, confidence = _windows(mapped)
    with open_tmm(path) as file:
        assert file.materials == {library[name].code: name for name in (GREY, GREEN)}
        assert (file.width, file.height, file.levels) == (40, 20, 6)
        levels = LevelStream(20, 40, mapped.codes)
        for k, _, level in levels.add(code):
            np.testing.assert_array_equal(file.array(f"levels/{k}/code"), level.code)
            np.testing.assert_array_equal(file.array(f"levels/{k}/mix_weight"), level.mix_weight)
        np.testing.assert_allclose(file.array("levels/0/confidence"), confidence, rtol=0, atol=1 / 128)
        assert file.attributes["texture_sha256"] == mapped.texture.sha256
        assert file.group_attributes("quality")["overall_accuracy"] == mapped.quality.quality.overall_accuracy


def test_points(built):
    mapped, path = built
    code, confidence = _windows(mapped)
    with open_tmm(path) as file:
        x, y = np.meshgrid(np.arange(40) + 0.5, np.arange(20) + 0.5)
        np.testing.assert_array_equal(file.code(x, y), code)
        codes, shares = file.mixture(39.9, 0.1, level=5)
        assert shares.sum() == pytest.approx(1) and set(codes.tolist()) == {0, *mapped.codes.tolist()}
        assert file.code(40, 20) == code[-1, -1]
        assert file.code(-5, 99, outside="clamp") == code[-1, 0]
        assert file.confidence(0.5, 0.5) == pytest.approx(confidence[0, 0], abs=1 / 128)
        with pytest.raises(InputError, match=r"the point \(40.1, 3\); allowed: x from 0 to 40"):
            file.code([3, 40.1], 3)
        with pytest.raises(InputError, match="level 6; allowed: 0 to 5"):
            file.code(0, 0, level=6)


def test_usage(built):
    _, path = built
    usage = read_usage(path)
    assert set(usage) == {GREEN, GREY} and sum(usage.values()) == pytest.approx(1)
    total = library_usage([path, path])
    assert total == pytest.approx(usage)
    with h5py.File(path) as file:
        counts = {name: int(file["usage"].attrs[name]) for name in file["usage"].attrs if name.startswith("texels")}
    assert counts == {"texels": 800, "texels_with_data": 800, "texels_with_material": 800}


def test_same_input_same_bytes(built, job, two_halves, tmp_path, library):
    _, path = built
    again = tmp_path / "again.tmm.h5"
    write_texture(map_texture(job(two_halves), tmp_path, library), again)
    assert again.read_bytes() == path.read_bytes()


def test_current_until_anything_changes(built, job, two_halves, tmp_path, library):
    mapped, path = built
    assert is_current(path, mapped.job, tmp_path, library.version)
    assert not is_current(path, mapped.job, tmp_path, library.version + "1")
    assert not is_current(path, job(two_halves, classifier={"radius": 1}), tmp_path, library.version)
    assert not is_current(tmp_path / "other.tmm.h5", mapped.job, tmp_path, library.version)
    image = (tmp_path / two_halves).read_bytes()
    (tmp_path / two_halves).write_bytes(image + b"more")
    assert not is_current(path, mapped.job, tmp_path, library.version)
    (tmp_path / two_halves).write_bytes(image)
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    assert not is_current(path, mapped.job, tmp_path, library.version)


@pytest.mark.parametrize("engine", ["netcdf4", "h5netcdf"])
def test_xarray_opens_every_group_without_a_warning(built, engine):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip({"netcdf4": "netCDF4"}.get(engine, engine))
    mapped, path = built
    (level1,) = [level for k, _, level in LevelStream(20, 40, mapped.codes).add(_windows(mapped)[0]) if k == 1]
    groups = ["/"]
    with h5py.File(path) as file:
        file.visititems(lambda name, item: groups.append(name) if isinstance(item, h5py.Group) else None)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for group in groups:
            with xarray.open_dataset(path, group=group, engine=engine) as content:
                content.load()
    assert len(groups) > 5
    with xarray.open_dataset(path, group="levels/1", engine=engine) as level:
        np.testing.assert_array_equal(level["code"].values, level1.code)
        np.testing.assert_allclose(level["x"].values, np.arange(20) * 2 + 1)
        assert level["mix_weight"].dims == ("y", "x", "component")
    with xarray.open_dataset(path, group="materials", engine=engine) as materials:
        assert materials["name"].values.tolist() == [GREY, GREEN]


def test_not_a_texture_database(tmp_path):
    (tmp_path / "a.tmm.h5").write_bytes(b"nothing")
    with pytest.raises(InputError, match="not a readable HDF5 file"):
        open_tmm(tmp_path / "a.tmm.h5")
    with pytest.raises(InputError, match="does not exist"):
        read_usage(tmp_path / "b.tmm.h5")


def test_a_level_as_xarray(built):
    _, path = built
    with open_tmm(path) as file:
        fine, coarse = file.to_xarray(), file.to_xarray(2)
        assert fine.code.shape == (20, 40) and coarse.mix_code.shape == (5, 10, 3) and "confidence" not in coarse
        assert int(fine.code.sel(row=3, column=30)) == int(file.code(30.5, 3.5))
        assert dict(zip(fine.attrs["material_codes"], fine.attrs["material_names"], strict=True)) == file.materials
        with pytest.raises(InputError, match="found level 9"):
            file.to_xarray(9)
