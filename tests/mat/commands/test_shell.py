"""What a shell asks of the commands: short help, the nearest option, completion."""

import os
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.shell_completion import ShellComplete

from skyshine.mat.cli import main as mat
from skyshine.tmm.cli import main as tmm

PROGRAMS = {"mat": mat, "tmm": tmm}


def commands(group, path):
    """Every command below a group with its path: ('mat', 'lines', 'build')."""
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        yield (*path, name)
        if isinstance(command, click.Group):
            yield from commands(command, (*path, name))


ALL = [path for name, group in PROGRAMS.items() for path in commands(group, (name,))]


@pytest.mark.parametrize("path", ALL, ids=" ".join)
def test_short_help_is_help(path, capsys):
    shown = []
    for option in ("-h", "--help"):
        with pytest.raises(SystemExit) as stop:
            PROGRAMS[path[0]].main([*path[1:], option], prog_name=path[0])
        written = capsys.readouterr()
        shown.append(written.out)
        assert stop.value.code == 0, written.err
    assert shown[0] == shown[1] and shown[0].startswith("Usage:")


def test_one_option_has_one_name_and_one_range():
    """Options of a number: the range of one name is the same in all commands, but for heights and widths of two things.

    The range of an angle around the whole circle is -360 to 360; kilometres are not taken for such an angle.
    """
    ranges = {}
    for program, *path in ALL:
        command = PROGRAMS[program]
        for name in path:
            command = command.get_command(click.Context(command), name)
        for option in command.params:
            if isinstance(option.type, click.FloatRange | click.IntRange):
                ranges.setdefault(option.opts[0], set()).add((option.type.min, option.type.max))
    assert {name for name, limits in ranges.items() if len(limits) > 1} == {"--altitude"}
    assert ranges["--altitude"] == {(-0.5, 9), (-0.5, 100_000)}  # of a surface, of an observer
    assert ranges["--azimuth"] == ranges["--heading"] == {(-360, 360)} and ranges["--range"] == {(0, 100_000)}


@pytest.mark.parametrize(
    ("typed", "nearest"),
    [
        (["mat", "buld"], "'build'"),
        (["mat", "build", "job.yaml", "--jbos", "2"], "--jobs"),
        (["tmm", "clasify"], "'classify'"),
    ],
)
def test_what_is_mistyped_is_answered_with_the_nearest(typed, nearest, capsys):
    with pytest.raises(SystemExit) as stop:
        PROGRAMS[typed[0]].main(typed[1:], prog_name=typed[0])
    complaint = capsys.readouterr().err
    assert stop.value.code == 2 and nearest in complaint and "id you mean" in complaint


@pytest.mark.parametrize("program", PROGRAMS.values(), ids=PROGRAMS)
def test_an_old_name_is_answered_with_the_new_one(program, capsys):
    assert program.moved
    for old, new in program.moved.items():
        assert old not in program.lines and new.split()[0] in program.lines
        with pytest.raises(SystemExit) as stop:
            program.main([old, "file"], prog_name=program.name)
        complaint = capsys.readouterr().err
        assert stop.value.code == 2 and f"{program.name} {new}" in complaint and complaint.count("\n") == 1


@pytest.mark.parametrize("program", PROGRAMS.values(), ids=PROGRAMS)
def test_help_has_a_line_for_each_command(program, capsys):
    with pytest.raises(SystemExit):
        program.main(["--help"], prog_name=program.name, terminal_width=80)
    shown = capsys.readouterr().out.splitlines()
    assert all(any(line.startswith(f"  {name} ") and line.endswith(".") for line in shown) for name in program.lines)


@pytest.mark.parametrize(
    ("typed", "completed"),
    [
        ("mat bui", "build"),
        ("mat build --jo", "--jobs"),
        ("tmm cla", "classify"),
        ("mat contrast built asph", "asphalt_road"),
        ("mat spectrum --profile tro", "tropical"),
    ],
)
def test_bash_completes_commands_and_options(typed, completed):
    """As the script of `_MAT_COMPLETE=bash_source mat` asks for it."""
    name = typed.split()[0]
    words = {"COMP_WORDS": typed, "COMP_CWORD": str(typed.count(" ")), f"_{name.upper()}_COMPLETE": "bash_complete"}
    program = Path(sys.executable).with_name(name)
    if not program.exists():
        pytest.skip("the commands are not installed beside this python")
    told = subprocess.run([program], env=os.environ | words, capture_output=True, text=True, check=True).stdout
    assert completed in {line.partition(",")[2] for line in told.splitlines()}
    source = {f"_{name.upper()}_COMPLETE": "bash_source"}
    script = subprocess.run([program], env=os.environ | source, capture_output=True, text=True, check=True).stdout
    assert f"complete -o nosort -F _{name}_completion {name}" in script


@pytest.mark.parametrize(
    ("words", "incomplete", "completed"),
    [
        (["materials"], "asphalt_r", {"asphalt_road", "asphalt_road_new", "asphalt_runway_black"}),
        (["materials", "new", "mine", "--like"], "concrete_l", {"concrete_light"}),
        (["temperature", "--material"], "concrete_l", {"concrete_light", "concrete_l"}),  # or a file
        (["contrast", "FOLDER", "concrete"], "concrete_l", {"concrete_light"}),
        (["contrast", "FOLDER", "a", "b", "--band"], "b0", {"b01"}),
        (["contrast", "nowhere", "a", "b", "--band"], "b0", set()),
        (["export", "FOLDER", "--to", "gazebo", "--band"], "", {"b01"}),
        (["export", "--to"], "g", {"gpu", "gazebo"}),
        (["export"], "", {"--to"}),
        (["export", "FOLDER", "--to"], "raw", {"raw"}),
        (["query", "FOLDER/b01.band.h5"], "blackbody_r", {"blackbody_radiance"}),
        (["query", "nowhere.h5"], "", set()),
        (["info", "--preset"], "thin", {"thin_cirrus"}),
        (["init", "demo", "--example"], "urb", {"urban_canyon"}),
        (["spectrum", "--stratosphere"], "back", {"background"}),
        (["spectrum", "--aerosol-optical-depth"], "t", {"typical"}),
    ],
)
def test_names_are_completed(words, incomplete, completed, small_build):
    words = [word.replace("FOLDER", str(small_build)) for word in words]
    shown = {item.value for item in ShellComplete(mat, {}, "mat", "_MAT_COMPLETE").get_completions(words, incomplete)}
    assert shown == completed
