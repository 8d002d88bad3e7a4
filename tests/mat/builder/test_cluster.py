"""What a worker of a cluster does: in the output folder where it sees it, otherwise elsewhere, with its files sent."""

import pytest

from skyshine.mat.builder.build import Outcome, _batches
from skyshine.mat.builder.cluster import Fetched, _place, on_worker
from skyshine.mat.builder.tasks import run_task
from skyshine.mat.job.load import JobSites, load_job


@pytest.fixture
def work(tmp_path, tiny_job):
    text = tiny_job().replace("bands:\n  - wavelength_um: [10.0, 10.2]\n", "bands: []\n")
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    return next(_batches(JobSites.of(load_job(tmp_path / "job.yaml")), None, Outcome()))[0]


def test_a_worker_that_does_not_see_the_folder_sends_the_same_bytes(work, tmp_path, contents):
    there, here = tmp_path / "there", tmp_path / "here"
    there.mkdir()
    (tmp_path / "token").touch()
    arguments = (work.task, work.loaded, there, ("asphalt_road",), False)
    report = on_worker(run_task, arguments, str(tmp_path / "token"))
    fetched = on_worker(run_task, arguments, str(tmp_path / "no_such_token"))
    assert isinstance(fetched, Fetched) and fetched.report.files == report.files == ("s01.htt.h5",)
    assert not fetched.report.kept and fetched.report.entries == report.entries
    _place(fetched, here)
    assert contents(here) == contents(there) != {}
