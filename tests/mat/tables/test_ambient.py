"""Ambient radiance of faces read from a built table."""

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.job.load import load_job
from skyshine.schemas.errors import InputError

PLACE = {"range": 1.0, "altitude": 0.01, "elevation": -90.0, "source_elevation": 30.0}  # ends on the ground
HARMONICS = "ambient_radiance_harmonics"


@pytest.fixture(scope="module")
def sun(small_build):
    return skyshine.mat.open(small_build / "s01b01.atmq.h5")


@pytest.fixture(scope="module")
def band(small_build):
    return skyshine.mat.open(small_build / "b01.band.h5")


@pytest.fixture(scope="module")
def grounded(build_inline, small_job, tmp_path_factory):
    """Folder of the small job with ground of asphalt, which its materials do not name, and 11 harmonics."""
    text = small_job.read_text(encoding="utf-8").replace("[asphalt_road, grass_green]", "[grass_green]")
    text = text.replace("    visibility_km", "    ground_material: asphalt_road\n    visibility_km")
    file = tmp_path_factory.mktemp("grounded") / "job.yaml"
    more = "sources: [sun]\naccuracy: {tilted_faces_k: 0.1}\n"
    file.write_text(text + more, encoding="utf-8")
    build_inline(load_job(file), jobs=1)
    return file.parent / "built"


def test_a_level_face_has_the_level_quantity(sun):
    level = sun.value("ambient_radiance", **PLACE)
    np.testing.assert_allclose(sun.ambient_radiance(slope=0.0, azimuth=[0.0, 77.0], **PLACE), level, rtol=1e-12)


def test_light_is_continuous_from_level_faces_on(sun):
    near = sun.ambient_radiance(slope=[0.0, 1e-6], azimuth=30.0, **PLACE)
    assert near[1] == pytest.approx(near[0], rel=1e-6)


def test_a_face_that_looks_down_sees_the_ground(sun, band):
    """Of emissivity 0.9 at the day's mean air temperature, 27.5 C; it reflects a tenth of the sky and of the Sun."""
    glow = band.blackbody_radiance(300.65)
    down = sun.ambient_radiance(slope=180.0, **PLACE)
    sky, direct = (sun.value(name, **PLACE) for name in ("ambient_radiance", "direct_radiance"))
    expected = 0.9 * glow + 0.1 * (sky + 0.5 * direct)
    assert down == pytest.approx(expected, rel=0.04)  # of a job with a tolerance of 5 K


def test_the_ground_counts_by_its_temperature_and_view_factor(sun, band):
    """50 K more of ground change a face's light by the emission's change times (1 - cos(slope)) / 2."""
    slope = np.array([0.0, 45.0, 90.0, 135.0, 180.0])
    cold, warm = (
        sun.ambient_radiance(slope=slope, ground_temperature=kelvin, band=band, **PLACE) for kelvin in (280.0, 330.0)
    )
    change = sun.attributes["ground_emissivity"] * (band.blackbody_radiance(330.0) - band.blackbody_radiance(280.0))
    np.testing.assert_allclose(warm - cold, change * (1 - np.cos(np.radians(slope))) / 2, rtol=2e-3, atol=1e-9)


def test_the_stated_ground_is_the_default(sun, band):
    kelvin = 300.65  # the day's mean of the air
    stated, given = (
        sun.ambient_radiance(slope=90.0, **PLACE),
        sun.ambient_radiance(slope=90.0, ground_temperature=kelvin, band=band, **PLACE),
    )
    assert stated == pytest.approx(given, rel=1e-3)


def test_outside_the_axes_it_clamps_or_refuses(sun):
    far = PLACE | {"range": 900.0}
    with pytest.raises(InputError, match="range: found 900"):
        sun.ambient_radiance(slope=90.0, **far)
    found = sun.clamped("range", "source_elevation").ambient_radiance(slope=90.0, **far)
    assert found == sun.ambient_radiance(slope=90.0, **PLACE | {"range": 20.0})


def test_a_ground_temperature_needs_the_band(sun):
    with pytest.raises(InputError, match="give the .band table"):
        sun.ambient_radiance(slope=90.0, ground_temperature=300.0, **PLACE)


def test_ground_of_a_material_has_its_emissivity_and_its_temperature_by_the_hour(grounded):
    """The material is built though no list names it; noon is hotter than midnight."""
    sun, surface, band = (
        skyshine.mat.open(grounded / name) for name in ("s01b01.atmq.h5", "s01.htt.h5", "b01.band.h5")
    )
    assert set(surface.materials) == {"asphalt_road", "grass_green"}
    night, noon = sun.ground_temperature(surface, time=[0.0, 12.0])
    expected = surface.temperature(material="asphalt_road", altitude=0.0, slope=0.0, azimuth=0.0, time=[0.0, 12.0])
    assert [night, noon] == expected.tolist() and noon > night + 15
    light = sun.ambient_radiance(slope=180.0, ground_temperature=[night, noon], band=band, **PLACE)
    emissivity = 1 - float(band.value("reflectance", material="asphalt_road"))
    assert sun.attributes["ground_emissivity"] == pytest.approx(emissivity, abs=1e-6) and emissivity > 0.9
    emitted = emissivity * np.diff(band.blackbody_radiance([night, noon]))[0]
    assert light[1] - light[0] == pytest.approx(emitted, rel=2e-3)
    assert sun.root.axes["harmonic"].values.size == 11


def test_a_job_of_level_faces_leaves_harmonics_out(build_atmosphere, tiny_job, tmp_path):
    text = tiny_job().replace("slope_deg: [0, 45]", "slope_deg: [0]")
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    table = skyshine.mat.open(build_atmosphere(load_job(tmp_path / "job.yaml"), tmp_path))
    assert HARMONICS not in table.quantities and "ground_radiance" not in table.attributes
    assert table.ambient_radiance(slope=0.0, **PLACE) == table.value("ambient_radiance", **PLACE)
    with pytest.raises(InputError, match="has no ambient_radiance_harmonics; allowed: slope 0"):
        table.ambient_radiance(slope=10.0, **PLACE)


def test_needs_of_level_faces_leave_harmonics_out(small_job, tmp_path):
    (tmp_path / "job.yaml").write_text(
        small_job.read_text(encoding="utf-8") + "needs: {slope_deg: [0, 0]}\n", encoding="utf-8"
    )
    loaded = load_job(tmp_path / "job.yaml")
    assert loaded.trimmed.ambient_harmonics == 0 and loaded.requested.ambient_harmonics == 6


def test_the_file_states_its_error_on_random_faces(sun):
    stated = sun.error(HARMONICS)
    assert stated["points"] > 50 and 0 < stated["rms_kelvin"] < stated["maximum_kelvin"] < 2.0
