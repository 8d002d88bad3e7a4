"""Every packaged job is built, and its files hold."""

import shutil

import pytest

from skyshine.mat.api.examples import example_names, starter_files
from skyshine.mat.builder.build import build
from skyshine.mat.job.load import load_job
from skyshine.mat.tables.loader import open_table
from skyshine.mat.tables.verify import problems

pytestmark = pytest.mark.validation


@pytest.mark.parametrize("name", example_names()[1:])
def test_example(name, tmp_path):
    for file in starter_files(name):
        shutil.copyfile(file, tmp_path / file.name)
    build(load_job(tmp_path / "job.yaml"), jobs=1)
    files = sorted((tmp_path / "built").glob("*.h5"))
    assert files and [found for file in files for found in problems(file)] == []
    assert all((tmp_path / "built" / "pictures" / f"{file.name[:-3]}.png").is_file() for file in files)
    for file in files:
        if file.name.endswith(".htt.h5"):
            kelvin = open_table(file).root.variables["temperature"].data
            assert kelvin.min() > 230 and kelvin.max() < 700
