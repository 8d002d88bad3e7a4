"""What a build leaves alone in its folder, and what it writes nowhere else."""

import os
import pty
import shutil
import subprocess
import sys

import pytest

from skyshine.mat.builder.folder import sole_build_in
from skyshine.mat.builder.tasks import draw_file
from skyshine.mat.job.load import load_job
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import part_file
from skyshine.schemas.paths import job_path

ON_A_TERMINAL = """
import sys
from skyshine.schemas.commands import progress
with progress(2, f"building {sys.argv[1]}") as advance:
    advance(1)
"""


def test_part_files_of_a_killed_build_go_and_those_of_a_user_stay(tmp_path):
    own, picture = part_file(tmp_path / "s01.htt.h5"), part_file(tmp_path / "s01.htt.png")
    picture = picture.with_name(f"{picture.name}.png")
    users = [tmp_path / ".x.part", tmp_path / ".x.part.png", tmp_path / "x.part"]
    for file in (own, picture, *users):
        file.write_text("half")
    with sole_build_in(tmp_path):
        assert not own.exists() and not picture.exists()
    assert all(file.exists() for file in users)


@pytest.mark.parametrize("name", ["link/../evil", "link", "link/deeper", "../evil", "inside/../../evil"])
def test_a_path_through_a_link_leads_out_only_with_leave(tmp_path, monkeypatch, name):
    for folder in ("job/inside", "elsewhere/deep"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "job" / "link").symlink_to(tmp_path / "elsewhere" / "deep")
    with pytest.raises(ValueError, match="leads out of the job's folder"):
        job_path(tmp_path / "job", name)
    monkeypatch.setenv("SKYSHINE_ALLOW_OUTSIDE", "1")
    assert job_path(tmp_path / "job", name) == tmp_path / "job" / name


@pytest.mark.parametrize("name", ["inside", "inside/../new", "own", "."])
def test_a_path_inside_is_taken_also_through_a_link(tmp_path, name):
    (tmp_path / "inside").mkdir()
    (tmp_path / "own").symlink_to(tmp_path / "inside")
    assert job_path(tmp_path, name) == tmp_path / name


class Drawn:
    """A database whose picture says how often it was drawn."""

    file = "s01.htt.h5"
    count = 0

    def draw(self, folder, picture):
        self.count += 1
        picture.write_text(f"drawn {self.count}")


def test_pictures_are_not_drawn_through_a_link_out_of_the_folder(tmp_path):
    for folder in ("built", "elsewhere"):
        (tmp_path / folder).mkdir()
    (tmp_path / "built" / "pictures").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InputError, match="leads out of the job's folder"):
        draw_file(Drawn(), tmp_path / "built")
    assert not list((tmp_path / "elsewhere").iterdir())
    (tmp_path / "built" / "pictures").unlink()
    draw_file(Drawn(), tmp_path / "built")
    assert (tmp_path / "built" / "pictures" / "s01.htt.png").read_text() == "drawn 1"
    assert len(list((tmp_path / "built" / "pictures").iterdir())) == 1


def test_a_picture_is_drawn_again_where_its_file_is_younger(tmp_path):
    database, picture, file = Drawn(), tmp_path / "pictures" / "s01.htt.png", tmp_path / "s01.htt.h5"
    file.write_text("")
    draw_file(database, tmp_path)
    draw_file(database, tmp_path)
    assert picture.read_text() == "drawn 1"
    os.utime(file, (picture.stat().st_mtime + 5,) * 2)
    draw_file(database, tmp_path)
    assert picture.read_text() == "drawn 2"


def test_databases_of_an_earlier_job_are_named(build_inline, tiny_job, tiny_build, tmp_path):
    (tmp_path / "job.yaml").write_text(tiny_job(), encoding="utf-8")
    shutil.copytree(tiny_build, tmp_path / "built")
    (tmp_path / "built" / "s02.htt.h5").write_text("of an earlier job")
    report = build_inline(load_job(tmp_path / "job.yaml"), jobs=1)
    assert report["not_of_this_job"] == ["s02.htt.h5"] and (tmp_path / "built" / "s02.htt.h5").exists()


def test_a_name_that_looks_like_markup_is_shown_on_a_terminal(tmp_path):
    master, slave = pty.openpty()
    command = [sys.executable, "-c", ON_A_TERMINAL, "x [/bold]"]
    process = subprocess.Popen(command, stdout=slave, stderr=slave, env={**os.environ, "TERM": "xterm"})
    os.close(slave)
    shown = b""
    while True:
        try:
            part = os.read(master, 4096)
        except OSError:  # the other end is closed
            break
        if not part:
            break
        shown += part
    assert process.wait() == 0 and b"building x [/bold]" in shown, shown


def test_a_missing_input_is_named_itself(tmp_path):
    output, photograph = tmp_path / "built", tmp_path / "road.png"
    output.mkdir()
    with pytest.raises(InputError, match=r"road\.png: does not exist"), sole_build_in(output):
        photograph.read_bytes()
    with pytest.raises(InputError, match=r"built: cannot be written"), sole_build_in(output):
        (output / "gone").read_bytes()
