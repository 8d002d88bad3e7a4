"""Threads of one process: the same results in the same order, however many."""

import threading

import pytest

from skyshine.mat.threads import VARIABLE, parallel_map, thread_count


@pytest.mark.parametrize("threads", ["1", "2", "7"])
def test_results_keep_the_order_of_their_arguments(monkeypatch, threads):
    monkeypatch.setenv(VARIABLE, threads)
    assert parallel_map(lambda a, b: 10 * a + b, range(20), range(20)) == [11 * n for n in range(20)]


def test_several_threads_work_at_once(monkeypatch):
    monkeypatch.setenv(VARIABLE, "3")
    together = threading.Barrier(3, timeout=60)  # breaks unless three items are in work together
    assert sorted(parallel_map(lambda _: together.wait(), range(3))) == [0, 1, 2]


def test_arguments_of_different_length_are_refused():
    with pytest.raises(ValueError, match="zip"):
        parallel_map(lambda a, b: a, range(3), range(2))


def test_no_items_give_no_results():
    assert parallel_map(lambda a: a, []) == []


@pytest.mark.parametrize(("text", "count"), [("1", 1), ("5", 5), ("0", 1)])
def test_the_environment_sets_the_number_of_threads(monkeypatch, text, count):
    monkeypatch.setenv(VARIABLE, text)
    assert thread_count() == count
