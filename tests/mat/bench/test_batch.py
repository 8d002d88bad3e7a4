"""The bench of batches: a sample spread over the states; the time of a whole batch from that of its sample."""

import pytest

from mat.maintain.bench.batch_timing import BatchTiming, Size
from skyshine.mat.bench.sample import sampled
from skyshine.mat.job.load import load_job


def timing(workers, seconds=10.0, further=2.0, choice=6.0):
    return BatchTiming("here", workers, seconds, 8.0, {}, further, choice, True)


@pytest.fixture(scope="module")
def loaded(tmp_path_factory, tiny_job):
    file = tmp_path_factory.mktemp("batch") / "job.yaml"
    states = "\n".join(f"  - {{profile: tropical, weather: {{air_temperature_c: {20 + k}}}}}" for k in range(9))
    file.write_text(tiny_job().replace("bands:", states + "\nbands:").replace("pictures: false", "pictures: true"))
    return load_job(file)


def test_a_sample_takes_the_ends_and_spreads_between_without_pictures(loaded):
    job = sampled(loaded, 4).trimmed
    assert job.states == [loaded.trimmed.states[i] for i in (0, 3, 6, 9)]
    assert loaded.trimmed.output.pictures and not job.output.pictures


def test_a_sample_of_more_than_all_is_all(loaded):
    assert sampled(loaded, 50).trimmed.states == loaded.trimmed.states


def test_size_counts_states_and_their_airs(loaded):
    size = Size.of(loaded)
    assert size.states == 10 and 1 <= size.airs <= 10
    assert Size.of(sampled(loaded, 1)) == Size(1, 1)


def test_the_sample_itself_takes_its_own_time():
    assert timing(4).whole(Size(5, 1), Size(5, 1)) == 10.0


def test_further_states_share_the_workers():
    """100 more states at 2 s each on 4 workers are 50 s more."""
    assert timing(4).whole(Size(5, 1), Size(105, 1)) == pytest.approx(60.0)


def test_further_airs_are_chosen_by_each_process_that_meets_them():
    """One process: 6 s for each of 3 more airs. Four processes and 10 states of each air: all four choose each."""
    assert timing(1).whole(Size(40, 1), Size(40, 4)) == pytest.approx(10 + 3 * 6)
    assert timing(4).whole(Size(40, 1), Size(40, 4)) == pytest.approx(10 + 3 * 6)
    # With two states of an air at most two processes meet it.
    assert timing(4).whole(Size(8, 1), Size(8, 4)) == pytest.approx(10 + 3 * 2 * 6 / 4)
