"""What the check accepts is built: a part of the program beside this file."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
import check_proves_build

pytestmark = pytest.mark.validation


def test_accepted_jobs_are_built():
    outcomes, failures = check_proves_build.run(60, 2, 600.0)
    assert not failures and outcomes["built"] > 20
