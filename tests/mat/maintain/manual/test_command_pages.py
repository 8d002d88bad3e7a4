"""The pages of the commands hold what `--help` lists."""

import re

import pytest
from click.testing import CliRunner

from mat.maintain.manual import command_pages


def listed(group, *words):
    """Names that the help of a group of commands lists, by running it."""
    done = CliRunner().invoke(command_pages.GROUPS[group], [*words, "--help"])
    assert done.exit_code == 0, done.output
    _, found, names = done.output.partition("\nCommands:\n")
    return re.findall(r"^  ([a-z][\w-]*)", names, re.MULTILINE) if found else []


@pytest.mark.parametrize("group", command_pages.GROUPS)
def test_each_command_of_the_help_has_its_section(group):
    text = command_pages.page(group)
    names = listed(group)
    assert len(names) >= 7
    for name in names:
        assert f"## `{group} {name}`" in text
        for below in listed(group, name):
            assert f"## `{group} {name} {below}`" in text


@pytest.mark.parametrize("group", command_pages.GROUPS)
def test_each_option_of_a_command_stands_in_its_section(group):
    sections = command_pages.page(group).split("\n## ")
    for words, context in command_pages.commands(group):
        (section,) = [part for part in sections if part.startswith(f"`{words}`\n")]
        for option in context.command.params:
            if option.param_type_name == "option" and not option.hidden:
                assert option.opts[-1] in section, (words, option.opts)


def test_an_option_that_holds_a_bar_stays_in_its_cell():
    rows = [row for name in command_pages.GROUPS for row in command_pages.page(name).splitlines() if row[:2] == "| "]
    assert rows
    for row in rows:
        assert len(re.findall(r"(?<!\\)\|", row)) == 3, row
