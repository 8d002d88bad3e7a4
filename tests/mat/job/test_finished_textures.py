"""A job that names a finished texture: its materials are built, and nothing is classified."""

import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.plan.plan import make_plan
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError
from skyshine.tmm import TextureJob, map_texture, write_texture

JOB = """\
skyshine: 1
name: finished
site: {latitude_deg: 45, longitude_deg: 0, date: 2026-06-21, utc_offset_h: 0, altitude_km: 0}
states:
  - {profile: midlatitude_summer, weather: {air_temperature_c: 15}}
bands:
  - wavelength_um: [8, 12]
textures:
  - database: done.tmm.h5
"""


@pytest.fixture
def job(tmp_path):
    from PIL import Image

    image = Image.new("RGB", (8, 4), (90, 90, 90))
    image.putpixel((3, 2), (0, 200, 0))
    image.save(tmp_path / "photo.png")
    colours = {"#5a5a5a": "asphalt_road", "#00c800": "grass_green"}
    texture = TextureJob.model_validate({"image": "photo.png", "palette": {"colours": colours}})
    write_texture(map_texture(texture, tmp_path, load_library()), tmp_path / "done.tmm.h5")
    (tmp_path / "job.yaml").write_text(JOB, encoding="utf-8")
    return tmp_path / "job.yaml"


def test_its_materials_are_built_and_no_texture_is(job):
    plan = make_plan(load_job(job), load_library())
    assert set(plan.materials) == {"asphalt_road", "grass_green"}
    assert not any(name.endswith(".tmm.h5") for task in plan.tasks for name in task.files)


def test_a_job_may_name_both_kinds(job):
    text = JOB + "  - {image: photo.png, material: concrete}\n"
    job.write_text(text, encoding="utf-8")
    plan = make_plan(load_job(job), load_library())
    assert set(plan.materials) == {"asphalt_road", "grass_green", "concrete"}
    assert [task.files for task in plan.tasks if task.kind == "texture"] == [("photo.tmm.h5",)]


def test_its_most_common_level_material_is_the_ground(job):
    """Conifer has more of the texels, and is no ground; the road has fewer than the grass, and is written first."""
    from PIL import Image

    colours = {"#5a5a5a": "asphalt_road", "#00c800": "grass_green", "#003200": "conifer"}
    image = Image.new("RGB", (8, 4), (0, 50, 0))
    image.paste((0, 200, 0), (0, 0, 4, 3))
    image.paste((90, 90, 90), (4, 0, 6, 1))
    image.save(job.parent / "photo.png")
    texture = TextureJob.model_validate({"image": "photo.png", "palette": {"colours": colours}})
    write_texture(map_texture(texture, job.parent, load_library()), job.parent / "done.tmm.h5")
    (state,) = load_job(job).trimmed.states
    assert state.ground_material == "grass_green"
    assert state.ground_origin == "largest share of the finished textures"


@pytest.mark.parametrize(
    ("name", "words"),
    [("missing.tmm.h5", "found 'missing.tmm.h5', which is no file"), ("../../x.tmm.h5", "leads out of")],
)
def test_a_file_that_is_not_there_or_outside_is_refused_at_its_place(job, name, words):
    job.write_text(JOB.replace("done.tmm.h5", name), encoding="utf-8")
    with pytest.raises(InputError, match=rf"job.yaml:9:\d+.*{words}"):
        load_job(job)


def test_a_file_that_is_no_texture_is_refused(job):
    (job.parent / "done.tmm.h5").write_bytes(b"not HDF5")
    with pytest.raises(InputError, match=r"done.tmm.h5: is not a readable HDF5 file"):
        make_plan(load_job(job), load_library())
