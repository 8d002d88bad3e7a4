"""Files that stopped or misled the readers, where the reference data have them."""

from datetime import date
from pathlib import Path

import numpy as np
import pytest
import yaml

from skyshine.mat.job.load import load_job
from skyshine.mat.job.weather_files import read_weather
from skyshine.mat.radiometry.response_table import parse_response
from skyshine.mat.render.gltf_surface import _parts
from skyshine.materials.spectrum_files import Said, read_spectrum
from skyshine.schemas.csv_table import read_text
from skyshine.schemas.errors import InputError

pytestmark = pytest.mark.shared_data


@pytest.fixture
def failing(shared_data):
    folder = shared_data / "failing"
    if not folder.is_dir():
        pytest.skip("the reference data have no folder of failing files")
    return folder


@pytest.mark.parametrize(
    ("name", "area"), [("quantised.glb", 1600.0), ("gpu_instances.glb", 6400.0), ("blank name.gltf", 1600.0)]
)
def test_areas_of_meshes(failing, name, area):
    corners = np.concatenate([part for _, part, _ in _parts(failing / name)])
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert 0.5 * np.linalg.norm(across, axis=-1).sum() == pytest.approx(area)


def test_texture_coordinates_are_transformed(failing):
    ((_, _, uv),) = _parts(failing / "texture_transform.glb")
    assert (uv.min(axis=(0, 1)), uv.max(axis=(0, 1))) == (pytest.approx([0.5, 0.0]), pytest.approx([4.5, 4.0]))


@pytest.mark.parametrize(
    ("name", "words"),
    [("half_draco.glb", "KHR_draco"), ("draco_only.glb", "KHR_draco"), ("bad_index.glb", "index 9; allowed: 0 to 3")],
)
def test_meshes_that_are_refused(failing, name, words):
    with pytest.raises(InputError, match=words):
        _parts(failing / name)


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [("scale_1000.hdr", 0.015, 0.074), ("ignore_value.sli", 0.1, 0.5), ("latin1_unit.hdr", 0.1, 0.5)],
)
def test_spectra(failing, name, low, high):
    spectrum = read_spectrum(failing / name, Said(record="first"))
    assert (spectrum.reflectance.min(), spectrum.reflectance.max()) == pytest.approx((low, high), abs=1e-4)
    assert (spectrum.wavelength[0], spectrum.wavelength[-1]) == pytest.approx((0.4, 14.0))


@pytest.mark.parametrize(("name", "peak"), [("tirs_rsr.csv", 10.9), ("response_decimal_comma.csv", 9.0)])
def test_responses(failing, name, peak):
    response = parse_response(read_text(failing / name), name)
    assert response.wavelength[np.argmax(response.response)] == pytest.approx(peak) and response.response.min() == 0.0


@pytest.mark.parametrize(("name", "readings"), [("half_hourly.epw", 48), ("asos.csv", 24), ("psm.csv", 24)])
def test_weather(failing, name, readings):
    assert (
        len(read_weather(failing / name, date(2026, 7, 1), 0.0 if name == "asos.csv" else 1.0).hourly.time) == readings
    )


@pytest.mark.parametrize(
    ("name", "words"), [("hours_0_23.epw", "allowed: 1 to 24"), ("era5_zip.nc", "is a zip archive")]
)
def test_weather_that_is_refused(failing, name, words):
    with pytest.raises(InputError, match=words):
        read_weather(failing / name, date(2026, 7, 1), 1.0)


def test_a_year_of_another_zone_is_doubted_and_its_light_not_taken(failing, tmp_path):
    job = {
        "skyshine": 1,
        "name": "zone",
        "site": {"latitude_deg": 45, "longitude_deg": 9, "date": "2026-07-01", "utc_offset_h": 1},
        "states": [{"profile": "midlatitude_summer", "weather": {"file": "wrong_zone.epw"}}],
        "bands": [],
        "materials": ["asphalt_road"],
    }
    (tmp_path / "wrong_zone.epw").write_bytes((failing / "wrong_zone.epw").read_bytes())
    (tmp_path / "job.yaml").write_text(yaml.safe_dump(job), encoding="utf-8")
    loaded = load_job(tmp_path / "job.yaml")
    said = " ".join(loaded.warnings)
    assert "8.6 h from the Sun" in said and "has light at night" in said
    assert loaded.trimmed.states[0].weather.hourly.direct_normal_w_m2 is None


def test_a_name_too_long_for_a_file_is_one_line(failing):
    with pytest.raises(InputError, match="a name of .* bytes; allowed: names of 255 at most") as refused:
        load_job(failing / "long_name.yaml")
    assert "\n" not in str(refused.value)


def test_all_files_are_tested(failing):
    """A file that is added takes a test here; those that others name come with them."""
    text = Path(__file__).read_text(encoding="utf-8")
    beside = {"README.md", "blank name.bin", "scale_1000.sli", "ignore_value.hdr", "latin1_unit.sli"}
    assert [path.name for path in failing.iterdir() if path.name not in beside and path.name not in text] == []
