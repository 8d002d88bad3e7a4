"""A tree without MT_CKD builds jobs with LOWTRAN7's water vapour continuum, and refuses MT_CKD in one line.

The band model of these tests is the packaged one with LOWTRAN7's water vapour continuum in its place and without words
on MT_CKD: it stands for the form of such a table, not for its figures, which take line lists to make.
"""

import os
import shutil
import site
import subprocess
import sys
from pathlib import Path

import h5py
import pytest
from click.testing import CliRunner

from mat.maintain.without_mt_ckd import main
from skyshine import atmospheres
from skyshine.mat.spectroscopy.lowtran_continua import LowtranContinua
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import content_hash

CHECKOUT = Path(__file__).parents[3]
FOLDERS = ("mat", "tmm", "materials", "atmospheres", "schemas", "examples")


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    """A band model and broadband points in the form of those without MT_CKD."""
    pytest.importorskip("numba")
    folder = tmp_path_factory.mktemp("tables")
    absorption, broadband = (
        Path(shutil.copy(atmospheres.path(name), folder)) for name in ("absorption.h5", "broadband.h5")
    )
    with h5py.File(absorption, "r+") as file:
        coefficients = LowtranContinua().water_coefficients(file["points/point"][()])
        for name, values in zip(("self_continuum", "foreign_continuum", "self_exponent"), coefficients, strict=True):
            file["points"][name][...] = values
        file.attrs.update({"water_continuum": "lowtran7", "data_name": "test", "citation": "test", "notice": "test"})
        file["points"].attrs["notice"] = "test"
        for gas in file["gases"].values():
            for key in ("sources", "terms"):
                gas.attrs[key] = [f"test {number}" for number in range(len(gas.attrs[key]))]
        content = content_hash(file)
        file.attrs["content_sha256"] = content
    with h5py.File(broadband, "r+") as file:
        file.attrs["absorption_sha256"] = content
    return absorption, broadband


@pytest.fixture(scope="module")
def tree(tables, tmp_path_factory):
    out = tmp_path_factory.mktemp("tree") / "out"
    made = CliRunner().invoke(main, _arguments(out, *tables), catch_exceptions=False)
    assert made.exit_code == 0, made.output
    return out


@pytest.fixture(scope="module")
def mat(tree):
    """Run the command `mat` of the tree; gives the finished process."""
    package = tree / "site" / "skyshine"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text('__version__ = "0.1.0+lowtran7"\n', encoding="utf-8")
    for folder in FOLDERS:
        (package / folder).symlink_to(tree / folder, target_is_directory=True)

    # Without `site`, whose .pth files put the packages of an editable installation before all of PYTHONPATH.
    folders = (str(tree / "site"), *site.getsitepackages())

    def run(*arguments, cwd):
        environment = dict(os.environ, PYTHONPATH=os.pathsep.join(folders), SKYSHINE_CACHE="")
        command = [sys.executable, "-S", "-c", "from skyshine.mat.cli import main; main()", *arguments]
        return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True)

    return run


def _arguments(out, absorption, broadband):
    return [str(CHECKOUT), str(out), "--absorption", str(absorption), "--broadband", str(broadband)]


def test_nothing_of_mt_ckd_is_in_the_data_or_the_terms_of_the_tree(tree):
    assert not list((tree / "atmospheres").rglob("mt_ckd*")) and not (tree / "LICENSES").exists()
    project = (tree / "pyproject.toml").read_text(encoding="utf-8")
    assert 'license = "Apache-2.0"\n' in project and 'version = "0.1.0+lowtran7"' in project
    assert "MT_CKD" not in project + (tree / "NOTICE").read_text(encoding="utf-8")
    assert "built without MT_CKD" in (tree / "README.md").read_text(encoding="utf-8")


@pytest.mark.validation  # 7 s
def test_the_tree_builds_a_job_with_the_continuum_of_lowtran7(mat, tiny_job, tmp_path):
    (tmp_path / "job.yaml").write_text(tiny_job().replace("slope_deg: [0, 45]", "slope_deg: [0]"), encoding="utf-8")
    built = mat("build", "job.yaml", "--jobs", "1", cwd=tmp_path)
    assert built.returncode == 0, built.stderr
    names = {file.name for file in (tmp_path / "built").glob("*.h5")}
    assert {"s01.htt.h5", "s01b01.atmq.h5"} <= names
    with h5py.File(tmp_path / "built" / "s01b01.atmq.h5") as file:
        assert "lowtran7" in file.attrs["job"]
    verified = mat("verify", *(f"built/{name}" for name in sorted(names)), cwd=tmp_path)
    assert verified.returncode == 0, verified.stdout + verified.stderr


def test_a_job_that_asks_the_tree_for_mt_ckd_ends_in_one_line(mat, tiny_job, tmp_path):
    text = tiny_job()
    (tmp_path / "job.yaml").write_text(f"{text}water_continuum: mt_ckd_4.3\n", encoding="utf-8")
    refused = mat("build", "job.yaml", cwd=tmp_path)
    lines = refused.stderr.strip().splitlines()
    assert refused.returncode == 2 and len(lines) == 1, refused.stderr
    assert f"job.yaml:{text.count(chr(10)) + 1}:" in lines[0]
    assert "allowed: lowtran7; this package was built without MT_CKD" in lines[0]


def test_the_spectrum_command_of_the_tree_refuses_mt_ckd_in_one_line(mat, tmp_path):
    refused = mat("spectrum", "--wavenumber", "900:910", "--water-continuum", "mt_ckd_2.4", cwd=tmp_path)
    assert refused.returncode == 2 and len(refused.stderr.strip().splitlines()) == 1, refused.stderr
    assert "this package was built without MT_CKD" in refused.stderr


def test_tables_with_mt_ckd_are_refused(tables, tmp_path):
    absorption, broadband = tables
    packaged = atmospheres.path("absorption.h5")
    with pytest.raises(InputError, match="contains figures of MT_CKD"):
        CliRunner().invoke(main, _arguments(tmp_path / "a", packaged, broadband), catch_exceptions=False)
    named = Path(shutil.copy(absorption, tmp_path))
    with h5py.File(named, "r+") as file:
        file["gases/N2"].attrs["sources"] = ["lines; N2 continuum of MT_CKD"]
    with pytest.raises(InputError, match="gases/N2@sources"):
        CliRunner().invoke(main, _arguments(tmp_path / "b", named, broadband), catch_exceptions=False)
    with pytest.raises(InputError, match="was not chosen from"):
        other = atmospheres.path("broadband.h5")
        CliRunner().invoke(main, _arguments(tmp_path / "c", absorption, other), catch_exceptions=False)
    assert not any((tmp_path / name).exists() for name in "abc")
