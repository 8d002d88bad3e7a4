"""The estimate of `mat check` against the processor time that a build takes."""

import resource

import pytest

from skyshine.mat.builder.build import build
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.cost import estimate
from skyshine.mat.plan.plan import make_plan
from skyshine.materials.library import load_library

pytestmark = pytest.mark.validation
JOB = """\
skyshine: 1
name: cost
site: {{latitude_deg: 29.7, longitude_deg: -82.0, date: 2026-06-28, utc_offset_h: -5}}
states:
  - profile: midlatitude_summer
    weather: {{air_temperature_c: [22, 33]}}
bands:
  - wavelength_um: {band}
materials: [asphalt_road, grass_green, concrete]
output: {{folder: built, pictures: {pictures}}}
"""


@pytest.mark.parametrize("band, pictures", [("[8, 12]", "true"), ("[3, 5]", "false")])
def test_estimate_is_right_within_a_factor_of_two(band, pictures, tmp_path, monkeypatch):
    monkeypatch.setenv("SKYSHINE_CACHE", "")
    file = tmp_path / "job.yaml"
    file.write_text(JOB.format(band=band, pictures=pictures), encoding="utf-8")
    loaded = load_job(file)
    expected = sum(estimate(loaded, make_plan(loaded, load_library())).values())

    def spent():
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    before = spent()
    build(loaded, jobs=1)
    taken = spent() - before
    print(f"\n{band}: estimated {expected:.1f} s, took {taken:.1f} s")
    assert 0.5 <= taken / expected <= 2
