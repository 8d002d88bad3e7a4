"""Fixtures that the whole suite shares."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session", autouse=True)
def cache_of_the_tests(tmp_path_factory):
    """No test reads or writes the user's own cache of compiled bands."""
    before = os.environ.get("SKYSHINE_CACHE")
    os.environ["SKYSHINE_CACHE"] = str(tmp_path_factory.mktemp("cache"))
    yield
    os.environ.pop("SKYSHINE_CACHE") if before is None else os.environ.__setitem__("SKYSHINE_CACHE", before)


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of the reference data; the tests that need it are skipped where it is absent."""
    folder = Path(os.environ.get("SKYSHINE_DATA", Path(__file__).parents[2] / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip("reference data not present: set SKYSHINE_DATA to its folder")
    return folder
