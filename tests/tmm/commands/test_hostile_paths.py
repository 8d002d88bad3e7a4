"""Pipes and devices as inputs, part files, files outside the job's folder, full disks, terminals."""

import json
import os
import platform
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from skyshine.schemas.whole_files import PART
from skyshine.tmm.cli import main

PROGRAM = [sys.executable, "-c", "from skyshine.tmm.cli import main; main()"]
SECONDS = 40  # a command that waits for a pipe never ends
posix = pytest.mark.skipif(os.name != "posix", reason="pipes and devices of POSIX")


def run(*arguments):
    """Run a command in this process; one that waits for a pipe is interrupted."""

    def interrupt(*_) -> None:
        raise TimeoutError("the command waits")

    if os.name == "posix":
        signal.signal(signal.SIGALRM, interrupt)
        signal.alarm(SECONDS)
    try:
        return CliRunner().invoke(main, [str(argument) for argument in arguments])
    finally:
        if os.name == "posix":
            signal.alarm(0)


def refused(result) -> bool:
    return result.exit_code == 2 and result.output.count("\n") == 1 and isinstance(result.exception, SystemExit)


@pytest.fixture
def write_job(tmp_path):
    def write(file: str = "job.yaml", /, **texture) -> Path:
        (tmp_path / file).write_text(json.dumps({"textures": [texture]}))
        return tmp_path / file

    return write


@pytest.fixture
def built(write_image, write_job, tmp_path):
    image = write_image("a.png", np.full((8, 8, 3), 90, np.uint8))
    assert run("classify", write_job(image=image, material="grass_green")).exit_code == 0
    return tmp_path / "build" / "a.tmm.h5"


@posix
@pytest.mark.parametrize("kind", ["pipe", "device"])
@pytest.mark.parametrize("role", ["image", "labels", "layer", "seeds", "job", "table", "world file"])
def test_pipes_and_devices_are_refused_at_once(kind, role, write_image, write_job, built, tmp_path):
    special = tmp_path / {"table": "t.xml", "world file": "a.pgw"}.get(role, "special")
    if kind == "pipe":
        os.mkfifo(special)
    else:
        special.symlink_to("/dev/zero")
    image, palette = "a.png", {"1": "grass_green"}
    write_image("indices.png", np.ones((4, 4, 1), np.uint8))
    texture = {
        "image": {"image": special.name, "material": "grass_green"},
        "labels": {"image": image, "seeds": {"labels": {"image": special.name, "palette": palette}}},
        "layer": {"image": image, "rules": {"layers": {"h": special.name}, "rules": [{"material": "grass_green"}]}},
        "seeds": {"image": image, "seeds": {"file": special.name}},
        "world file": {"image": image, "material": "grass_green"},
    }
    if role in texture:
        command = ("classify", write_job("hostile.yaml", **texture[role]))
    elif role == "table":
        pytest.importorskip("lxml")
        place = tmp_path / "Tiles/N12/E044"
        raster = place / "005_RMTexture/LC/U0/N12E044_D005_S001_T001_LC10_U0_R0.png"
        raster.parent.mkdir(parents=True)
        write_image(str(raster.relative_to(tmp_path)), np.ones((1, 1, 1), np.uint8))
        raster.rename(raster.with_suffix(".tif"))
        table = place / "006_RMDescriptor/LC/U0/N12E044_D006_S001_T001_LC10_U0_R0.xml"
        table.parent.mkdir(parents=True)
        special.rename(table)
        command = ("export", "--to", "tmm", raster.with_suffix(".tif"), "--out", tmp_path / "out")
    else:
        command = ("check", special)
    result = run(*command)
    if role == "world file":  # what is no file beside the image is no world file
        assert result.exit_code == 0, result.output
    else:
        assert refused(result), result.output


def test_part_files_of_ended_processes_go_and_all_others_stay(built, write_job, tmp_path):
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    stem = f".{built.name}.{platform.node()}"
    abandoned = built.with_name(f"{stem}.{ended.pid}{PART}")
    others = [
        built.with_name(name)
        for name in (
            ".a.part",
            f".{built.name}.part",
            f"{stem}.{os.getppid()}{PART}",
            f"{stem}.x{PART}",
            f".{built.name}.elsewhere.{ended.pid}{PART}",
            f".b.tmm.h5.{platform.node()}.{ended.pid}{PART}",
        )
    ]
    for path in (abandoned, *others):
        path.write_text("x")
    assert run("classify", write_job(image="a.png", material="grass_green")).exit_code == 0
    assert abandoned.exists() == (os.name != "posix")
    assert [path for path in others if path.exists()] == others


def test_what_a_file_outside_the_folder_holds_is_not_shown(built, write_job, tmp_path):
    (tmp_path / "in").mkdir()
    secret = tmp_path / "secret"
    job = tmp_path / "in" / "job.yaml"
    (tmp_path / "in" / "link").symlink_to(secret)
    (tmp_path / "a.png").rename(tmp_path / "in" / "a.png")
    for text in ("hunter2:x:0:0\n", '{"type": "hunter2"}', "{hunter2", "hunter2: [hunter2\n"):
        secret.write_text(text)
        for name in (str(secret), "link"):
            job.write_text(json.dumps({"textures": [{"image": "a.png", "seeds": {"file": name}}]}))
            result = run("check", job)
            assert refused(result) and "hunter2" not in result.output, result.output


@posix
@pytest.mark.parametrize("command", ["preview", "--help"])
def test_a_full_disk_behind_standard_output_is_one_line(command, built):
    if not Path("/dev/full").exists():
        pytest.skip("this system has no /dev/full")
    place = () if command == "--help" else (built,)
    with open("/dev/full", "w") as full:
        program = [*PROGRAM, *command.split(), *map(str, place)]
        result = subprocess.run(program, stdout=full, stderr=subprocess.PIPE, text=True, timeout=SECONDS)
    assert result.returncode == 2 and result.stderr.count("\n") == 1 and "Traceback" not in result.stderr, result.stderr


@posix
@pytest.mark.parametrize(
    "names",
    [
        pytest.param(("classify", "content", "picture"), id="three"),
        pytest.param(
            ("check", "classify", "content", "truth", "picture"), id="all", marks=pytest.mark.validation
        ),  # 6 s: a process each
    ],
)
def test_brackets_in_names_are_text_on_a_terminal(write_image, write_job, tmp_path, names):
    import pty

    image = "x [/bold][red].png"  # a folder "x [" and a file in it: together they read as markup
    for folder in ("x [", "truth [", "p ["):
        (tmp_path / folder).mkdir()

    write_image("a.png", np.full((8, 8, 3), 90, np.uint8))
    (tmp_path / "a.png").rename(tmp_path / image)
    seeds = {"polygons": {"grass_green": [[[1, 1]]], "asphalt_road": [[[6, 6]]]}}
    job = write_job("job [red].yaml", image=image, name="x", seeds=seeds)
    database = tmp_path / "build" / "x.tmm.h5"
    write_image("labels.png", np.ones((8, 8, 1), np.uint8))
    (tmp_path / "truth [/i].yaml").write_text('{"image": "../labels.png", "palette": {"1": "grass_green"}}')
    commands = {
        "check": ("check", job, image),
        "classify": ("classify", job, "grass_green"),
        "content": ("preview", database, image),
        "truth": ("check", database, "--truth", tmp_path / "truth [/i].yaml", "grass_green"),
        "picture": ("preview", database, "--out", tmp_path / "p [/b].png", "--image", tmp_path / image, "p [/b].png"),
    }
    for name in names:
        *arguments, shown = commands[name]
        leader, follower = pty.openpty()
        with os.fdopen(follower, "w") as terminal:
            result = subprocess.Popen([*PROGRAM, *map(str, arguments)], stdout=terminal, stderr=terminal)
        text = b""
        while True:
            try:
                part = os.read(leader, 4096)
            except OSError:  # the other end is closed
                break
            if not part:
                break
            text += part
        os.close(leader)
        assert result.wait(SECONDS) == 0, text.decode()
        assert "Traceback" not in text.decode() and shown in text.decode().replace("\r\n", ""), (name, text.decode())
