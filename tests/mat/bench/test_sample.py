"""A sample of a job's states, for measurements."""

import pytest

from skyshine.mat.bench.sample import sampled
from skyshine.mat.job.load import load_job


@pytest.fixture
def loaded(tmp_path, tiny_job):
    states = "\n".join(f"  - {{profile: tropical, weather: {{air_temperature_c: {20 + k}}}}}" for k in range(9))
    text = tiny_job().replace("bands:", states + "\nbands:").replace("pictures: false", "pictures: true")
    (tmp_path / "job.yaml").write_text(text)
    return load_job(tmp_path / "job.yaml")


def test_a_sample_takes_the_ends_and_spreads_between_without_pictures(loaded):
    job = sampled(loaded, 4).trimmed
    assert job.states == [loaded.trimmed.states[i] for i in (0, 3, 6, 9)]
    assert loaded.trimmed.output.pictures and not job.output.pictures


def test_a_sample_of_more_than_all_is_all(loaded):
    assert sampled(loaded, 50).trimmed.states == loaded.trimmed.states
