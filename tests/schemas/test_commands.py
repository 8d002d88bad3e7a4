"""The contract of the commands: exit statuses, one line of complaint, JSON."""

import json
import logging
import re

import click
import pytest

from skyshine.schemas.commands import CommandGroup, emit_json, log_lines
from skyshine.schemas.errors import CheckFailed, InputError
from skyshine.schemas.quantity import quantity


@pytest.fixture
def group():
    made = CommandGroup("tool", package="none", commands={})
    raised = {"input": InputError("is wrong", file="f", line=3, column=4), "check": CheckFailed("does not hold")}

    @click.command()
    @click.argument("kind", type=click.Choice(["input", "check", "stop", "bare", "fine"]))
    def run(kind):
        if kind == "stop":
            raise KeyboardInterrupt
        if kind == "bare":
            raise ModuleNotFoundError("No module named 'numba'", name="numba")
        if kind in raised:
            raise raised[kind]
        emit_json({"a": quantity([1.0, float("nan")], "K"), "b": quantity(2.5, "km")})

    made.get_command = lambda ctx, name: run if name == "run" else None
    return made


@pytest.mark.parametrize(
    ("arguments", "status", "complaint"),
    [
        (["run", "fine"], 0, ""),
        (["run", "check"], 1, "tool: does not hold\n"),
        (["run", "input"], 2, "tool: f:3:4: is wrong\n"),
        (["run", "stop"], 130, "tool: interrupted; finished parts are kept\n"),
        (["run", "bare"], 2, "needs the package 'numba'; install it with: pip install 'skyshine[spectroscopy]'"),
        (["run", "other"], 2, "'other' is not one of"),
        (["other"], 2, "No such command 'other'"),
    ],
)
def test_exit_status_and_complaint(group, capsys, arguments, status, complaint):
    with pytest.raises(SystemExit) as stop:
        group.main(arguments)
    shown = capsys.readouterr()
    assert stop.value.code == status and complaint in shown.err and shown.err.strip().count("\n") == 0
    if status == 0:
        read = json.loads(shown.out)
        assert read == {"a": {"units": "K", "values": [1.0, None]}, "b": {"units": "km", "value": 2.5}}


def test_a_mistyped_command_is_answered_with_the_nearest(capsys):
    made = CommandGroup("tool", package="none", commands={"build": "Build.", "check": "Check."})
    for typed, nearest in (("buld", "; did you mean 'build'?"), ("zzz", "")):
        with pytest.raises(SystemExit) as stop:
            made.main([typed])
        assert stop.value.code == 2
        assert capsys.readouterr().err.startswith(f"tool: No such command '{typed}'{nearest}")


def test_h_is_help(capsys):
    made = CommandGroup("tool", package="none", commands={"build": "Build."})
    with pytest.raises(SystemExit) as stop:
        made.main(["-h"])
    assert stop.value.code == 0 and "Build." in capsys.readouterr().out


def test_lines_of_the_log_reach_standard_error_while_a_command_works(capsys):
    log = logging.getLogger("skyshine.mat.build")
    with log_lines(3, "building") as advance:
        log.info("s01.htt.h5, state %d of %d", 1, 3)
        advance(1)
    log.info("not heard")
    heard = capsys.readouterr().err
    assert re.fullmatch(r"\d\d:\d\d:\d\d s01.htt.h5, state 1 of 3\n", heard)
    assert not logging.getLogger("skyshine").handlers
