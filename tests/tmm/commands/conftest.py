"""The commands, called as the shell would."""

import pytest
from click.testing import CliRunner

from skyshine.tmm.cli import main


@pytest.fixture
def run():
    def invoke(*arguments):
        return CliRunner().invoke(main, [str(argument) for argument in arguments])

    return invoke
