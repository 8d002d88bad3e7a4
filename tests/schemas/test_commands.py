"""The contract of the commands: exit statuses, one line of complaint, JSON."""

import json

import click
import pytest

from skyshine.schemas.commands import CommandGroup, emit_json, write_measured
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


def test_measured_figures_and_their_picture_stand_side_by_side(tmp_path):
    write_measured(tmp_path / "new" / "a.json", {"b": 1}, lambda picture: picture.write_bytes(b"png"))
    assert json.loads((tmp_path / "new" / "a.json").read_text()) == {"b": 1}
    assert (tmp_path / "new" / "a.png").read_bytes() == b"png"
    with pytest.raises(InputError, match="cannot be written"):
        write_measured(tmp_path / "new" / "a.json" / "b.json", {}, lambda picture: None)
