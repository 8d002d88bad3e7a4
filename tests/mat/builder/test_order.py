"""The order in which the processes of this machine get the tasks of a build."""

from concurrent.futures import Executor, Future
from contextlib import nullcontext
from types import SimpleNamespace

from skyshine.mat.builder import build
from skyshine.mat.plan.plan import Kind, Task
from skyshine.mat.products.product import TaskReport


class Ended(Executor):
    """Tasks that have ended as soon as they are submitted."""

    def __init__(self):
        self.order = []

    def submit(self, _, task, *arguments):
        self.order.append((task.kind, task.index))
        future = Future()
        future.set_result(TaskReport(()))
        return future


def test_temperatures_come_right_after_the_textures_that_they_wait_for(tmp_path, monkeypatch):
    monkeypatch.setattr(build, "_materials", lambda *_: ())
    monkeypatch.setattr(build, "_say", lambda *_: None)
    job = SimpleNamespace(name="road", states=[0], bands=[0])
    loaded = SimpleNamespace(trimmed=job, with_state_alone=lambda _: None)
    kinds = [(Kind.TEXTURE, 1), *((Kind.ATMOSPHERE, n) for n in (1, 2, 3)), (Kind.TEMPERATURE, 1), (Kind.BAND, 1)]
    works = [build.Work(Task(kind, index, 0, (f"{kind}{index}",), 1), loaded) for kind, index in kinds]
    executor = Ended()
    run = build._Run(tmp_path, False, executor, build.Outcome(), False, 2)
    run.all(works, iter(()), len(works), lambda *_: nullcontext(lambda _: None))
    assert executor.order == [kinds[0], kinds[1], *kinds[4:], *kinds[2:4]]
