"""Seeds in the coordinates of the map that an image lies on."""

import json

import numpy as np
import pytest

from skyshine.schemas.errors import InputError
from skyshine.tmm.inputs.load import load_texture
from skyshine.tmm.mapping.texture_map import map_texture

GREEN, GREY = "grass_green", "asphalt_road"
AFFINE = np.array([[0.4, 0.3, 500000.0], [0.3, -0.4, 5500000.0]])  # turned; texels of half a metre


def _ground(points):
    return (np.asarray(points, float) @ AFFINE[:, :2].T + AFFINE[:, 2]).tolist()


@pytest.fixture
def georeferenced(two_halves, tmp_path):
    """The texture of two halves, 40 x 20, with a world file, whose origin is the centre of the first texel."""
    (a, b, c), (d, e, f) = AFFINE
    numbers = (a, d, b, e, c + (a + b) / 2, f + (d + e) / 2)
    (tmp_path / "halves.pgw").write_text("\n".join(f"{n:.6f}" for n in numbers))
    return two_halves


def _write(path, shapes, **more):
    features = [
        {"type": "Feature", "properties": {"material": name}, "geometry": {"type": kind, "coordinates": coordinates}}
        for name, kind, coordinates in shapes
    ]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features, **more}))


def _texels(job, folder, library):
    *_, seeds = load_texture(job, folder, library)
    return {
        name: set(
            zip(seeds.columns[seeds.material == k].tolist(), seeds.rows[seeds.material == k].tolist(), strict=True)
        )
        for k, name in enumerate(seeds.names)
    }


def _map_job(job, image, **more):
    return job(image, seeds={"file": "seeds.geojson", "coordinates": "map", **more})


SQUARE = [[2, 2], [12, 2], [12, 15], [2, 15], [2, 2]]
HOLE = [[4, 4], [8, 4], [8, 8], [4, 8], [4, 4]]


def test_the_same_texels_as_in_pixel_coordinates(job, georeferenced, tmp_path, library):
    _write(tmp_path / "seeds.geojson", [(GREEN, "Polygon", [SQUARE, HOLE]), (GREY, "Point", [30.5, 5.5])])
    pixel = _texels(job(georeferenced, seeds={"file": "seeds.geojson"}), tmp_path, library)
    shapes = [(GREEN, "Polygon", [_ground(SQUARE), _ground(HOLE)]), (GREY, "Point", _ground([30.5, 5.5]))]
    _write(tmp_path / "seeds.geojson", shapes)
    assert _texels(_map_job(job, georeferenced), tmp_path, library) == pixel
    assert pixel[GREY] == {(30, 5)} and (5, 5) not in pixel[GREEN]


def test_what_lies_beyond_the_image_is_left_out(job, georeferenced, tmp_path, library):
    reaching = [[-10, -5], [3, -5], [3, 4], [-10, 4]]
    far = [[35, 15], [60, 15], [60, 50], [35, 50]]
    elsewhere = [[100, 100], [110, 100], [110, 110]]
    shapes = [(GREEN, "Polygon", [_ground(reaching)]), (GREY, "Polygon", [_ground(far)])]
    shapes += [("concrete", "Polygon", [_ground(elsewhere)]), (GREY, "Point", _ground([40.5, 3]))]
    _write(tmp_path / "seeds.geojson", shapes)
    found = _texels(_map_job(job, georeferenced), tmp_path, library)
    assert found == {
        GREEN: {(x, y) for x in range(3) for y in range(4)} | {(3, 4)},  # a vertex names its texel
        GREY: {(x, y) for x in range(35, 40) for y in range(15, 20)},
    }


def test_overrides(job, georeferenced, tmp_path, library):
    _write(tmp_path / "seeds.geojson", [(GREY, "Polygon", [_ground([[-10, -5], [3, -5], [3, 4], [-10, 4]])])])
    overrides = {"file": "seeds.geojson", "coordinates": "map"}
    mapped = map_texture(job(georeferenced, overrides=overrides), tmp_path, library)
    code = next(mapped.windows())[2].code
    assert (code[:4, :3] == library[GREY].code).all() and (code[5:, :15] == library[GREEN].code).all()


@pytest.mark.parametrize("crs", ["urn:ogc:def:crs:EPSG::32633", "EPSG:32633", "urn:ogc:def:crs:EPSG:9.1:32633"])
def test_the_system_that_the_file_names(job, write_image, tmp_path, library, crs):
    import tifffile

    keys = [1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32633]
    tags = [(33550, "d", 3, (1.0, 1.0, 0.0), True), (33922, "d", 6, (0.0, 0.0, 0.0, 100.0, 200.0, 0.0), True)]
    values = np.zeros((8, 9, 3), np.uint8)
    tifffile.imwrite(
        tmp_path / "a.tif", values, photometric="rgb", extratags=[*tags, (34735, "H", len(keys), tuple(keys), True)]
    )
    shapes = [(GREEN, "Point", [103.5, 198.5])]
    _write(tmp_path / "seeds.geojson", shapes, crs={"type": "name", "properties": {"name": crs}})
    assert _texels(_map_job(job, "a.tif"), tmp_path, library) == {GREEN: {(3, 1)}}
    _write(tmp_path / "seeds.geojson", shapes, crs={"type": "name", "properties": {"name": "EPSG:999999"}})
    with pytest.raises(InputError, match=r"seeds.geojson: lies on a map in 'EPSG:999999'; allowed: a system that PROJ"):
        _texels(_map_job(job, "a.tif"), tmp_path, library)


@pytest.mark.parametrize("crs", [None, "urn:ogc:def:crs:OGC:1.3:CRS84", "EPSG:4326", "EPSG:3857"])
def test_seeds_in_another_system_are_reprojected(job, tmp_path, library, crs):
    """At 15 degrees east, where UTM zone 33 has its meridian, and 50 degrees north (Snyder 1987, eq. 8-12 by hand)."""
    import tifffile

    keys = [1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32633]
    tags = [
        (33550, "d", 3, (10.0, 10.0, 0.0), True),
        (33922, "d", 6, (0.0, 0.0, 0.0, 499_965.0, 5_538_640.0, 0.0), True),
        (34735, "H", len(keys), tuple(keys), True),
    ]
    tifffile.imwrite(tmp_path / "a.tif", np.zeros((8, 9, 3), np.uint8), photometric="rgb", extratags=tags)
    # The scale of 0.9996 takes the meridian's arc of 5,540,847.04 m to a northing of 5,538,630.70 m.
    place = [15.0, 50.0] if crs != "EPSG:3857" else [1_669_792.3618991037, 6_446_275.841017158]
    named = {} if crs is None else {"crs": {"type": "name", "properties": {"name": crs}}}
    _write(tmp_path / "seeds.geojson", [(GREEN, "Point", place)], **named)
    assert _texels(_map_job(job, "a.tif"), tmp_path, library) == {GREEN: {(3, 0)}}


def test_nothing_on_the_image(job, georeferenced, tmp_path, library):
    _write(tmp_path / "seeds.geojson", [(GREEN, "Point", [15.0, 47.0])])
    with pytest.raises(InputError, match=r"halves.png: no polygon of seeds.geojson lies on this image"):
        _texels(_map_job(job, georeferenced), tmp_path, library)


def test_an_image_without_a_place(job, two_halves, tmp_path, library):
    _write(tmp_path / "seeds.geojson", [(GREEN, "Point", [15.0, 47.0])])
    with pytest.raises(InputError, match=r"halves.png: has no place on a map, in whose coordinates seeds.geojson is"):
        _texels(_map_job(job, two_halves), tmp_path, library)
