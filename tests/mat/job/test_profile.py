"""The profile of a state: named, blended by weights, or by place and date."""

import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.schemas.errors import InputError

LINE = "  - profile: midlatitude_summer\n    weather"


def load(folder, tiny_job, profile):
    assert LINE in tiny_job()
    line = "  - weather" if profile is None else f"  - profile: {profile}\n    weather"
    (folder / "job.yaml").write_text(tiny_job().replace(LINE, line), encoding="utf-8")
    return load_job(folder / "job.yaml").trimmed


@pytest.mark.parametrize("profile", ["auto", None])
def test_without_a_name_it_follows_from_latitude_and_date(tmp_path, tiny_job, profile):
    """29.7 N on 28 June: 0.51 tropical and 0.49 of 45 degrees, 18 days from midsummer, in steps of 0.02."""
    (state,) = load(tmp_path, tiny_job, profile).states
    assert state.profile == {"tropical": 0.5, "midlatitude_summer": 0.48, "midlatitude_winter": 0.02}


def test_a_state_of_another_date_has_the_air_of_its_date(tmp_path, tiny_job):
    text = "auto\n    date: 2026-01-15"
    (state,) = load(tmp_path, tiny_job, text).states
    assert state.profile == {"tropical": 0.52, "midlatitude_winter": 0.48}


def test_the_blend_reaches_the_air(tmp_path, tiny_job):
    job = load(tmp_path, tiny_job, "{tropical: 0.25, subarctic_winter: 0.75}\n    air: profile")
    air = atmospheric_state(job.site, job.states[0])
    assert air.temperature[0] == pytest.approx(0.25 * 299.7 + 0.75 * 257.2)
    assert "0.75 subarctic_winter" in air.name


@pytest.mark.parametrize(
    ("profile", "message"),
    [
        ("tropcal", r"found 'tropcal'; did you mean 'tropical'"),
        ("{tropcal: 1}", r"found 'tropcal'; did you mean 'tropical'"),
        ("{tropical: 0.5, us_standard: 0.4}", "found weights with the sum 0.9; allowed: the sum 1"),
        ("{tropical: 1.5, us_standard: -0.5}", "found 1.5 for tropical; allowed: a weight above 0, up to 1"),
        ("{tropical: true}", "found True for tropical"),
        ("{tropical: .nan}", "found nan for tropical"),
        ("{}", "found weights with the sum 0"),
        ("[tropical]", r"found \['tropical'\]; allowed: auto, a standard profile"),
        ("3", "found 3; allowed: auto, a standard profile"),
    ],
)
def test_other_profiles_are_refused_in_one_line(tmp_path, tiny_job, profile, message):
    with pytest.raises(InputError, match=rf"job.yaml:\d+:\d+: states.0.profile.*{message}"):
        load(tmp_path, tiny_job, profile)
