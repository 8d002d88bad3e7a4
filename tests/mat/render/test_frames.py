"""Frames: their pixels are the library's, shade is where a roof hides the Sun, extremes are finite or one line."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.quantities.lines_of_sight import LinesOfSight, direction
from skyshine.mat.render.exposure import exposure_of
from skyshine.mat.render.frames import Renderer, check_hours
from skyshine.mat.render.rays import ray_caster
from skyshine.mat.render.scene_file import load_scene
from skyshine.mat.runtime.equivalent_temperature import equivalent_temperature
from skyshine.mat.runtime.pixel import Faces, View, pixel_radiance
from skyshine.mat.surface.forcing import plane_irradiance, sun_cosine
from skyshine.mat.surface.surroundings import Exposure, Surroundings
from skyshine.mat.tables.loader import open_table
from skyshine.mat.tables.response import forcing_hours
from skyshine.mat.tables.shade import AUREOLE, DIFFUSE, DIRECT, SUN_AZIMUTH, SUN_ELEVATION
from skyshine.schemas.errors import InputError
from skyshine.tmm.database.reader import TmmFile

SKY = (AUREOLE, DIFFUSE, DIRECT, SUN_AZIMUTH, SUN_ELEVATION)
GROUND, ROOF_HEIGHT, ROOF_HALF = 40.0, 3.0, 2.0  # m


def level(half, height):
    """Two triangles of a level square, y up."""
    low, high = -half, half
    return np.array(
        [
            [[low, height, high], [high, height, high], [high, height, low]],
            [[low, height, high], [high, height, low], [low, height, low]],
        ],
        float,
    )


@pytest.fixture
def roofed(small_build, write_glb, tmp_path):
    """Factory of a scene of level asphalt under a square roof of grass, with changes of its top keys."""
    mesh = write_glb(
        [("ground", level(GROUND, 0.0), None), ("roof", level(ROOF_HALF, ROOF_HEIGHT), None)], tmp_path / "roof.glb"
    )
    materials = {"ground": "asphalt_road", "roof": "grass_green"}

    def make(**changes):
        content = {
            "skyshine_scene": 1,
            "name": "roofed",
            "databases": str(small_build),
            "surface": {"altitude_km": 0.1, "mesh": {"file": str(mesh), "materials": materials}},
            "camera": {
                "perspective": {
                    "field_of_view_deg": 50.0,
                    "size": [24, 16],
                    "position_m": [0.0, -25.0, 30.0],
                    "look_at_m": [0.0, 0.0, 0.0],
                }
            },
            "hours": [10.0],
        }
        return load_scene(content | changes)

    return make


@pytest.fixture
def plan(small_build, scene_of):
    """Factory of a scene of the plain texture over the small build."""
    return lambda **changes: scene_of(**({"databases": str(small_build), "hours": [10.0]} | changes))


def frames_of(scene):
    with Renderer(scene) as renderer:
        return list(renderer.frames())


def tables_of(folder):
    return (open_table(folder / f"{name}.h5") for name in ("s01.htt", "b01.band", "s01b01.atmq"))


def library_pixel(
    folder, *, hour, distance, elevation, azimuth, altitude, surface_altitude, kelvin=None, tilt=(0.0, 0.0), **faces
):
    """Radiance [W m^-2 sr^-1] of one pixel of asphalt by the library's own call; `tilt` is slope and azimuth."""
    surface, band, air = tables_of(folder)
    sun = surface.source_track("sun", time=hour)

    def one(value):
        return np.array([float(value)])

    view = View(
        LinesOfSight(*(one(value) for value in (distance, altitude, elevation, sun.elevation, sun.azimuth - azimuth))),
        one(distance),
        normal=direction(90.0 - tilt[0], tilt[1])[None],
        to_source=direction(sun.elevation, sun.azimuth)[None],
        to_observer=-direction(elevation, azimuth)[None],
        source_heading=one(sun.azimuth),
    )
    code = surface.materials["asphalt_road"]
    return pixel_radiance(
        surface,
        band,
        air,
        Faces(
            np.array([[code]]),
            np.array([[1.0]]),
            one(surface_altitude),
            one(tilt[1]),
            one(tilt[0]),
            one(hour),
            temperature=kelvin,
            **faces,
        ),
        view,
    ).radiance[0]


def test_a_pixel_of_a_plan_is_the_pixel_of_the_library(plan, small_build):
    (frame,) = frames_of(plan())
    expected = library_pixel(
        small_build, hour=10.0, distance=0.5, elevation=-90.0, azimuth=0.0, altitude=0.6, surface_altitude=0.1
    )
    assert frame.radiance == pytest.approx(expected, rel=1e-6)
    band = open_table(small_build / "b01.band.h5")
    assert frame.apparent_temperature == pytest.approx(equivalent_temperature(band, expected), rel=1e-9)


@pytest.mark.parametrize("azimuth", [180.0, 90.0])
def test_a_pixel_of_a_tilted_face_is_the_pixel_of_the_library(roofed, small_build, write_glb, tmp_path, azimuth):
    """A slope of 45 degrees that faces south, or east once its file is turned: by the harmonics of the sky."""
    corners = np.array([[[-9, -9, 9], [9, -9, 9], [9, 9, -9]], [[-9, -9, 9], [9, 9, -9], [-9, 9, -9]]], float)
    file = write_glb([("slope", corners, None)], tmp_path / "slope.glb")
    mesh = {"file": str(file), "materials": {"slope": "asphalt_road"}, "x_azimuth_deg": azimuth - 90.0}
    camera = {"plan_view": {"height_m": 500.0, "size": [3, 3], "width_m": 6.0}}
    (frame,) = frames_of(roofed(surface={"altitude_km": 0.1, "mesh": mesh}, camera=camera))
    expected = library_pixel(
        small_build,
        hour=10.0,
        distance=0.5,
        elevation=-90.0,
        azimuth=0.0,
        altitude=0.6,
        surface_altitude=0.1,
        tilt=(45.0, azimuth),
    )
    assert frame.radiance[1, 1] == pytest.approx(expected, rel=1e-6)


def test_a_face_is_seen_from_both_of_its_sides(roofed, write_glb, tmp_path):
    sides = {"front": level(9.0, 0.0), "back": level(9.0, 0.0)[:, ::-1]}
    camera = {"plan_view": {"height_m": 500.0, "size": [2, 2], "width_m": 6.0}}
    frames = []
    for name, corners in sides.items():
        file = write_glb([("ground", corners, None)], tmp_path / f"{name}.glb")
        mesh = {"file": str(file), "materials": {"ground": "asphalt_road"}}
        frames += frames_of(roofed(surface={"altitude_km": 0.1, "mesh": mesh}, camera=camera))
    assert frames[0].radiance == pytest.approx(frames[1].radiance, rel=1e-12)


def test_a_pixel_of_many_rays_is_the_mean_of_their_radiances(roofed):
    """Under the edge of the roof, where rays of one pixel differ."""
    camera = roofed().document.data["camera"]["perspective"]
    (fine,) = frames_of(roofed(camera={"perspective": camera}))
    (coarse,) = frames_of(roofed(camera={"perspective": camera | {"size": [12, 8], "samples": 2}}))
    mean = fine.radiance.reshape(8, 2, 12, 2).mean(axis=(1, 3))
    assert coarse.radiance == pytest.approx(mean, rel=1e-9)
    assert coarse.range == pytest.approx(fine.range.reshape(8, 2, 12, 2).min(axis=(1, 3)))
    assert coarse.apparent_temperature.shape == (8, 12)
    assert np.ptp(fine.radiance) > 0


def test_the_roof_shades_the_points_from_which_it_hides_the_sun(roofed):
    """Against the plane geometry of a square that the line to the Sun crosses or not."""
    with Renderer(roofed()) as renderer:
        place = renderer._see(0, np.array([10.0]))
        track = renderer.tables.surface.source_track("sun", time=forcing_hours())
        exposure = exposure_of(
            place.points, renderer.surface, ray_caster(renderer.surface), track.elevation, track.azimuth
        )
    ground = place.points.point[:, 2] < 1.0
    up = track.elevation > 1.0
    towards = direction(track.elevation, track.azimuth)[up]
    crossing = place.points.point[ground, None, :2] + ROOF_HEIGHT * towards[None, :, :2] / towards[None, :, 2:]
    beside = np.abs(crossing).max(axis=-1) - ROOF_HALF
    clear_cut = np.abs(beside) > 0.05
    assert (exposure.shaded[ground][:, up] == (beside < 0))[clear_cut].all()
    assert exposure.shaded[ground].any() and not exposure.shaded[~ground].any()
    assert not exposure.shaded[:, track.elevation <= 0].any()


def test_without_sun_nothing_is_shaded(roofed):
    """In the polar night, say."""
    with Renderer(roofed()) as renderer:
        place = renderer._see(0, np.array([10.0]))
        dark = np.full(288, -20.0)
        exposure = exposure_of(place.points, renderer.surface, ray_caster(renderer.surface), dark, np.zeros(288))
    assert not exposure.shaded.any()


def test_the_sky_view_under_the_roof_is_its_view_factor(roofed):
    """Of a square of half side a at height h from below its middle: Howell, Configuration Factors, B-3, four times."""
    camera = {
        "perspective": {
            "field_of_view_deg": 1.0,
            "size": [1, 1],
            "position_m": [0.0, -8.0, 1.0],
            "look_at_m": [0.0, 0.0, 0.0],
        }
    }
    with Renderer(roofed(camera=camera)) as renderer:
        view = renderer._see(0, np.array([10.0])).exposure.sky_view
    a = ROOF_HALF / ROOF_HEIGHT
    corner = 2 * a / np.sqrt(1 + a * a) * np.arctan(a / np.sqrt(1 + a * a)) / (2 * np.pi)
    assert view == pytest.approx(1 - 4 * corner, abs=0.03)


def shines_as_grass(folder, kelvin, lit=0.0):
    """Temperature (1,) of the wall of .95 that sends, under the sky of 10:00, what grass sends at `kelvin` [K] with the
    share `lit` of the direct light on it.
    """
    surface, band, air = tables_of(folder)
    dark = 1 - band.value("reflectance_planck", material="grass_green", planck_temperature=kelvin)
    track = surface.source_track("sun", time=10.0)
    line = {"range": 0.04, "altitude": 0.13, "elevation": -50.0, "source_elevation": track.elevation}
    level, direct = (air.value(name, **line) for name in ("ambient_radiance", "direct_radiance"))
    around = 0.5 * (level + band.blackbody_radiance(air.ground_temperature(surface, time=10.0)))
    sent = dark * band.blackbody_radiance(kelvin) + (1 - dark) * around
    sent += band.value("reflectance", material="grass_green") * lit * direct
    return np.atleast_1d(equivalent_temperature(band, (sent - 0.05 * around) / 0.95))


def reflected_by_grass(surface, slope):
    """Sunlight (288,) that grass facing south reflects [W m^-2]."""
    sky = {name: np.asarray(surface.root.variables[name].data, float) for name in SKY}
    light = plane_irradiance(
        slope, 180.0, sky[SUN_ELEVATION], sky[SUN_AZIMUTH], sky[DIRECT][0], sky[DIFFUSE][0],
        surface.attributes.get("ground_albedo", 0.0), sky[AUREOLE],
    )  # fmt: skip
    return (1 - surface.value("solar_absorptance", material="grass_green")) * sum(light)


def test_a_pixel_at_the_foot_of_a_slope_sees_it_as_warm_and_bright_as_it_is(roofed, write_glb, small_build, tmp_path):
    """Against the temperature, sunlight and reflection of the slope's own plane."""
    corners = np.array([[[-40, 0, 0], [40, 0, 0], [40, 40, -40]], [[-40, 0, 0], [40, 40, -40], [-40, 40, -40]]], float)
    parts = [("ground", level(GROUND, 0.0), None), ("slope", corners, None)]
    mesh = {"file": str(write_glb(parts, tmp_path / "slope.glb"))}
    mesh["materials"] = {"ground": "asphalt_road", "slope": "grass_green"}
    camera = {"perspective": {"field_of_view_deg": 1.0, "size": [1, 1], "position_m": [0, -25, 30]}}
    camera["perspective"]["look_at_m"] = [0, -2, 0]
    scene = roofed(surface={"altitude_km": 0.1, "mesh": mesh}, camera=camera)
    (frame,) = frames_of(scene)
    with Renderer(scene) as renderer:
        place = renderer._see(0, np.array([10.0]))
    view = place.exposure.sky_view
    assert 0.75 < view[0] < 0.95  # of a plane of 45 degrees without end: .854
    surface, _, _ = tables_of(small_build)
    grass = {"material": "grass_green", "altitude": 0.1 + 0.02, "slope": 45.0, "azimuth": 180.0}
    kelvin_of_slope = surface.temperature(**grass, time=forcing_hours())
    reflected = reflected_by_grass(surface, 45.0)
    assert reflected.max() > 100  # W m^-2
    shaded = place.exposure.shaded.astype(float)  # early and late, by the slope
    exposure = Exposure(shaded, view[:, None], kelvin_of_slope[None], wall_light=reflected[None])
    asphalt = {"material": np.array(["asphalt_road"]), "altitude": np.array([0.1])}
    change = surface.exposed_change(exposure, **asphalt)
    kelvin = surface.temperature(material="asphalt_road", altitude=0.1, time=10.0, absorbed_change=change[0])
    assert frame.surface_temperature[0, 0] == pytest.approx(float(kelvin), abs=0.02)
    sun = surface.source_track("sun", time=10.0)
    pixel = library_pixel(
        small_build,
        hour=10.0,
        distance=place.points.range[0],
        elevation=place.rays.elevation[0],
        azimuth=place.rays.azimuth[0],
        altitude=0.13,
        surface_altitude=0.1,
        kelvin=np.array([[float(kelvin)]]),
        sky_view=view,
        wall_temperature=shines_as_grass(
            small_build, kelvin_of_slope[120], float(sun_cosine(45.0, 180.0, sun.elevation, sun.azimuth))
        ),
    )
    assert frame.radiance[0, 0] == pytest.approx(pixel, rel=1e-4)


def test_a_shaded_pixel_is_the_pixel_of_the_library_under_the_same_shade(roofed, small_build):
    scene = roofed()
    (frame,) = frames_of(scene)
    with Renderer(scene) as renderer:
        place = renderer._see(0, np.array([10.0]))
    seen, shaded = place.points, place.exposure.shaded
    now = shaded[:, 120]  # 10:00
    chosen = int(np.flatnonzero(now & (seen.point[:, 2] < 1.0))[0])
    hours = forcing_hours()[shaded[chosen]]
    assert np.ptp(hours) == pytest.approx(hours.size / 12 - 1 / 12)  # one interval
    interval = (hours[0] - 1 / 24, hours[-1] + 1 / 24)
    surface, _, _ = tables_of(small_build)
    view = float(place.exposure.sky_view[chosen])
    place_of = {"material": "asphalt_road", "altitude": 0.1}
    # The table has no faces that hang: the roof is as warm as the air; it reflects what the ground does.
    light = reflected_by_grass(surface, 180.0)
    exposure = Exposure(Surroundings((interval,)).shaded(forcing_hours(), 1 / 12)[None], np.array([[view]]))
    change = surface.exposed_change(
        replace(exposure, wall_light=light[None]), material=np.array(["asphalt_road"]), altitude=np.array([0.1])
    )
    kelvin = surface.temperature(**place_of, time=10.0, absorbed_change=change[0])
    pixel = seen.pixel[chosen]
    rows, columns = divmod(pixel, 24)
    assert frame.surface_temperature[rows, columns] == pytest.approx(float(kelvin), abs=1e-5)
    air = surface.value("air_temperature", altitude=0.1, forcing_time=10.0)
    expected = library_pixel(
        small_build,
        hour=10.0,
        distance=seen.range[chosen],
        elevation=place.rays.elevation[pixel],
        azimuth=place.rays.azimuth[pixel],
        altitude=0.13,
        surface_altitude=0.1,
        kelvin=np.array([[float(kelvin)]]),
        lit_share=np.array([0.0]),
        sky_view=np.array([view]),
        wall_temperature=shines_as_grass(small_build, float(air)),
    )
    assert frame.radiance[rows, columns] == pytest.approx(expected, rel=1e-5)
    lit = np.flatnonzero(~now & (seen.point[:, 2] < 1.0) & (place.exposure.sky_view > 0.95))
    warm = frame.surface_temperature.ravel()[seen.pixel[lit]]
    assert warm.min() > float(kelvin) + 2.0


def test_shade_that_has_left_still_cools(roofed):
    """A point that the shadow left an hour ago is colder than one that had none, by the kernel of the table."""
    scene = roofed()
    (frame,) = frames_of(scene)
    with Renderer(scene) as renderer:
        place = renderer._see(0, np.array([10.0]))
    shaded, ground = place.exposure.shaded, place.points.point[:, 2] < 1.0
    left = ground & ~shaded[:, 117:122].any(axis=1) & shaded[:, 100:117].any(axis=1)
    never = ground & ~shaded.any(axis=1) & (place.exposure.sky_view > 0.97)
    assert left.any() and never.any()
    kelvin = frame.surface_temperature.ravel()[place.points.pixel]
    assert kelvin[left].max() < kelvin[never].min() - 0.1


def test_lines_that_meet_nothing_show_the_air(roofed):
    camera = {
        "perspective": {
            "field_of_view_deg": 60.0,
            "size": [6, 6],
            "position_m": [0.0, 0.0, 10.0],
            "look_at_m": [100.0, 0.0, 10.0],
        }
    }
    (frame,) = frames_of(roofed(camera=camera))
    missed = ~np.isfinite(frame.range)
    assert missed.any() and not missed.all()
    assert np.all(np.isfinite(frame.radiance)) and np.all(frame.radiance > 0)
    assert np.array_equal(np.isnan(frame.surface_temperature), missed)
    assert frame.radiance[0].mean() < frame.radiance[2].mean()  # the zenith is colder than the horizon


def test_a_camera_that_sees_no_surface_shows_the_air_alone(roofed):
    camera = roofed().document.data["camera"]["perspective"] | {"look_at_m": [0.0, 0.0, 90.0]}
    (frame,) = frames_of(roofed(camera={"perspective": camera}))
    assert not np.isfinite(frame.range).any()
    assert np.all(np.isfinite(frame.apparent_temperature))


def test_a_day_of_a_track_and_a_night_with_the_moon_are_finite(roofed):
    stations = [
        {"hour": hour, "position_m": [x, -20.0, 30.0], "look_at_m": [0.0, 0.0, 0.0]}
        for hour, x in ((0.0, 0.0), (5.5, 5.0), (17.0, 5.0))
    ]
    camera = {"perspective": {"field_of_view_deg": 50.0, "size": [5, 4], "track": stations}}
    content = roofed().document.data | {"camera": camera, "source": "moon"}
    content.pop("hours")
    frames = frames_of(load_scene(content))
    assert [frame.hour for frame in frames] == [0.0, 5.5, 17.0]
    assert all(np.all(np.isfinite(frame.radiance)) for frame in frames)
    assert not np.array_equal(frames[1].range, frames[0].range)


def test_a_grazing_camera_sees_finite_pixels(roofed):
    camera = {
        "perspective": {
            "field_of_view_deg": 20.0,
            "size": [8, 8],
            "position_m": [-39.0, 0.0, 10.0],
            "look_at_m": [3000.0, 0.0, 0.0],
        }
    }
    (frame,) = frames_of(roofed(camera=camera))
    assert np.all(np.isfinite(frame.apparent_temperature))
    assert np.all((frame.apparent_temperature > 150) & (frame.apparent_temperature < 400))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"hours": [13.5]}, "found the sun at 75.4 degree at 13:30; s01b01.atmq.h5 has up to 60"),
        ({"state": 2}, "has no state 2; allowed: 1"),
        ({"bands": ["b07"]}, "bands.0: found the band 'b07'"),
        ({"databases": "nowhere"}, "contains no catalog.json; run mat build"),
        ({"sensors": {"b03": {"gain": 1.0}}}, "sensors.b03: found the band 'b03'"),
        ({"camera": {"plan_view": {"height_m": 50000.0, "size": [2, 2]}}}, "km of the observer; s01b01.atmq.h5 has"),
    ],
)
def test_what_the_databases_do_not_hold_is_one_line(plan, changes, words):
    with pytest.raises(InputError, match=words):
        frames_of(plan(**changes))


@pytest.mark.parametrize(
    "text",
    [
        "no JSON",
        "{}",
        '{"files": [1]}',
        '{"files": []}',
        '{"files": [{"file": "s01.htt.h5", "filetype": "htt"}]}',
        '{"files": [{"file": "../s01.htt.h5", "filetype": "htt", "state": 1}]}',
    ],
)
def test_a_damaged_catalogue_is_refused(plan, tmp_path, text):
    (tmp_path / "catalog.json").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"catalog\.json: is no catalogue of databases"):
        frames_of(plan(databases=str(tmp_path)))


def test_hours_that_the_temperatures_lack_are_refused_at_their_key(plan, small_build):
    surface = open_table(small_build / "s01.htt.h5")
    axis = surface.root.axes["time"]
    evening = {"interpolation": "linear", "out_of_range": "error", "period": 24.0}
    part = replace(axis, values=np.array([18.0, 22.0, 27.0]), attributes=evening)
    surface = replace(surface, root=replace(surface.root, axes=surface.root.axes | {"time": part}))
    check_hours(plan(hours=[18.0, 23.5, 3.0]), surface)
    with pytest.raises(InputError, match=r"hours: found 03:30, at which s01\.htt\.h5 has no temperatures"):
        check_hours(plan(hours=[2.0, 3.5]), surface)


def test_a_material_that_the_databases_lack_is_refused_at_its_key(roofed):
    surface = roofed().document.data["surface"]
    surface = surface | {"mesh": surface["mesh"] | {"materials": {"ground": "asphalt_road", "roof": "grass_dry"}}}
    with pytest.raises(InputError, match=r"surface\.mesh\.materials\.roof.*did you mean 'grass_green'"):
        frames_of(roofed(surface=surface))


def test_a_surface_below_the_tables_is_refused(plan, plain_texture):
    surface = {"altitude_km": -0.2, "plan": {"texture": str(plain_texture), "metres_per_texel": 2.0}}
    with pytest.raises(InputError, match="altitude: found -0.2"):
        frames_of(plan(surface=surface))


def test_progress_is_reported(roofed):
    from contextlib import contextmanager

    done = {}

    @contextmanager
    def progress(total, text):
        done[text] = [total, 0]

        def advance(count):
            done[text][1] += count

        yield advance

    with Renderer(roofed(), progress) as renderer:
        list(renderer.frames())
    assert set(done) == {"tracing shadows", "surface temperatures", "radiance"}
    assert all(total == count for total, count in done.values())


def test_materials_in_the_shade_all_day_are_the_library_s_under_that_shade(roofed, small_build):
    surface_of = roofed().model.surface.model_dump(exclude_unset=True, mode="json")
    plain, shaded = (
        frames_of(roofed(surface=surface_of | changes))[0]
        for changes in ({}, {"shaded_materials": {"grass_green": 0.4}})
    )
    with Renderer(roofed()) as renderer:
        seen = renderer._see(0, np.array([10.0])).points
    roof = seen.pixel[seen.point[:, 2] > ROOF_HEIGHT - 0.1]
    table, _, _ = tables_of(small_build)
    place = {"material": "grass_green", "altitude": 0.1 + ROOF_HEIGHT / 1e3}
    change = table.absorbed_change(**place, shade=[(0.0, 24.0)], sky_view=0.4)
    kelvin = float(table.temperature(**place, time=10.0, absorbed_change=change))
    assert shaded.surface_temperature.ravel()[roof] == pytest.approx(kelvin, abs=1e-6)
    assert np.all(plain.radiance.ravel()[roof] > shaded.radiance.ravel()[roof])
    others = np.setdiff1d(np.arange(plain.radiance.size), roof)
    np.testing.assert_array_equal(plain.radiance.ravel()[others], shaded.radiance.ravel()[others])


def test_shaded_materials_that_the_surface_lacks_are_refused(roofed):
    surface = roofed().model.surface.model_dump(exclude_unset=True, mode="json")
    with pytest.raises(InputError, match="found 'concrete'; allowed: the materials of the surface: asphalt_road"):
        frames_of(roofed(surface=surface | {"shaded_materials": {"concrete": 0.5}}))


def test_the_shade_of_a_photograph_is_in_the_shade_all_day(plan, small_build, monkeypatch):
    """Right of the middle all of a texel is in the shade, left of it half of one: the mean of both."""
    lit = frames_of(plan())[0]
    monkeypatch.setattr(TmmFile, "has_shade", property(lambda file: True))
    monkeypatch.setattr(TmmFile, "shade", lambda file, x, y, level=0: np.where(np.asarray(x) > 4, 1.0, 0.5))
    surface = plan().model.surface.model_dump(exclude_unset=True, mode="json")
    shaded = frames_of(plan(surface=surface | {"shaded_sky": 0.4}))[0]
    table, _, _ = tables_of(small_build)
    change = table.absorbed_change(material="asphalt_road", altitude=0.1, shade=[(0.0, 24.0)], sky_view=0.4)
    dark = float(table.temperature(material="asphalt_road", altitude=0.1, time=10.0, absorbed_change=change))
    sunny = float(lit.surface_temperature[0, 0])
    assert shaded.surface_temperature[:, 4:] == pytest.approx(dark, abs=1e-6)
    assert shaded.surface_temperature[:, :4] == pytest.approx(0.5 * (sunny + dark), abs=1.0)
    dark_half, half_dark = shaded.radiance[:, 4:], shaded.radiance[:, :4]
    assert np.all(dark_half < half_dark) and np.all(half_dark < lit.radiance[:, :4])
    with Renderer(plan(surface=surface | {"shaded_sky": 0.4})) as renderer:
        assert renderer._materials.in_shade
        seen = renderer._see(0, np.array([10.0]))
        assert seen.lit_share.reshape(4, 8)[:, 4:] == pytest.approx(0.0) and seen.lit_share[0] == pytest.approx(0.5)


def test_a_frame_as_xarray(plan):
    (frame,) = frames_of(plan())
    data = frame.to_xarray()
    assert data.radiance.shape == frame.radiance.shape and data.apparent_temperature.attrs["units"] == "K"
    np.testing.assert_array_equal(data.range.values, frame.range)
    assert data.attrs["hour"] == 10.0 and data.attrs["band"] == frame.band
