"""Fixtures that the whole suite shares."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of the reference data; the tests that need it are skipped where it is absent."""
    folder = Path(os.environ.get("SKYSHINE_DATA", Path(__file__).parents[2] / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip("reference data not present: set SKYSHINE_DATA to its folder")
    return folder
