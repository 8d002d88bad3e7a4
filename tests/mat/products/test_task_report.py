"""What a task reports of its stages."""

from skyshine.mat.products import product
from skyshine.mat.products.product import TaskReport


class Clock:
    """Stands in for `time`, with readings by the clock and by the processor."""

    def __init__(self, wall, processor):
        self.wall, self.processor = iter(wall), iter(processor)

    def perf_counter(self):
        return next(self.wall)

    def process_time(self):
        return next(self.processor)


def test_a_stage_counts_clock_and_processor_apart_and_adds_up(monkeypatch):
    monkeypatch.setattr(product, "time", Clock(wall=[10.0, 13.0, 20.0, 21.0], processor=[1.0, 2.0, 5.0, 5.5]))
    report = TaskReport(("a.h5",))
    for _ in range(2):
        with report.stage("tables"):
            pass
    assert report.stages == {"tables": 4.0}
    assert report.processor_stages == {"tables": 1.5}
