"""The tutorials: every job, command and Python block of each page runs, in their order, in an empty folder.

The tests run the shortest page, and know the commands, jobs and names of all; `-m validation` runs all pages. What a
page shows as printed, after ``<!-- printed -->``, is what the block before it printed, but for clock times and seconds;
with SKYSHINE_WRITE its lines are written again.
"""

import contextlib
import importlib
import io
import json
import os
import re
import shlex
from functools import partial
from pathlib import Path

import pytest
from click.testing import CliRunner

from skyshine.mat.cli import main as mat
from skyshine.mat.job.load import load_job
from skyshine.tmm.cli import main as tmm
from skyshine.tmm.database.reader import open_tmm

FOLDER = Path(__file__).parents[2] / "examples" / "manual" / "tutorials"
PROGRAMS = {"mat": mat, "tmm": tmm}
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"# file: (\S+)\n")


PRINTED = re.compile(r"<!-- printed -->\n+$")
TIMES = re.compile(r"\d\d:\d\d:\d\d|\d+(\.\d)? s\b")


def run(command):
    """What the lines of a shell block print."""
    printed = ""
    for line in command.strip().splitlines():
        program, *arguments = shlex.split(line)
        result = CliRunner().invoke(PROGRAMS[program], arguments)
        assert result.exit_code == 0, f"{line}: {result.output[-400:]}"
        printed += result.output
    return printed


def without_times(line):
    return TIMES.sub("_", line.strip())


def shown_again(shown, printed):
    """Lines of a page as a block printed them: each in place of the one that begins most like it."""
    lines = [line.rstrip() for line in printed.splitlines()]
    known = {without_times(line) for line in lines}

    def alike(line, other):
        return next((at for at, (a, b) in enumerate(zip(line, other, strict=False)) if a != b), len(line))

    nearest = [
        line if not line or without_times(line) in known else max(lines, key=partial(alike, line))
        for line in shown.splitlines()
    ]
    return "\n".join(nearest) + "\n"


def follow(page, folder, monkeypatch):
    """The names that the Python blocks of a page leave, after all of its blocks."""
    monkeypatch.chdir(folder)
    names, printed, file = {}, "", FOLDER / f"{page}.md"
    page_text = file.read_text(encoding="utf-8")
    for block in BLOCK.finditer(page_text):
        kind, text = block.groups()
        given = FILE.match(text)
        if given and kind in ("yaml", "text"):
            (folder / given[1]).write_text(text[given.end() :], encoding="utf-8")
        elif kind == "sh":
            printed = run(text)
        elif kind == "python":
            with contextlib.redirect_stdout(io.StringIO()) as output:
                exec(compile(text, page, "exec"), names)
            printed = output.getvalue()
        elif PRINTED.search(page_text[: block.start()]) and (again := shown_again(text, printed)) != text:
            assert os.environ.get("SKYSHINE_WRITE"), f"{page}.md shows\n{text}but these lines were printed\n{again}"
            file.write_text(file.read_text(encoding="utf-8").replace(text, again), encoding="utf-8")
    return names


def test_these_are_the_five_users_and_the_three_ways():
    users = {"sensor_engineer", "runtime_engineer", "texture_artist", "researcher", "batch_operator"}
    assert {path.stem for path in FOLDER.iterdir()} == users | {"three_ways"}


def test_a_changed_figure_of_a_printed_block_is_noticed():
    printed = "12:00:01 a.h5: built in 6.2 s, 99 % within 0.59 K\nroad 3.1\ngrass 2.0\n"
    shown = "09:43:15 a.h5: built in 4.4 s, 99 % within 0.59 K\n\ngrass 2.0\n"
    assert shown_again(shown, printed) == shown
    assert shown_again("grass 2.1\n", printed) == "grass 2.0\n"


@pytest.mark.validation  # 18 s
def test_the_sensor_engineer_finds_contrast_and_transmittance(tmp_path, monkeypatch):
    values = follow("sensor_engineer", tmp_path, monkeypatch)
    hours, transmittance = values["hours"], values["transmittance"]
    for name in ("clear", "haze"):
        assert 24 > hours[name, 0.5] >= hours[name, 2.0] >= hours[name, 5.0] > 8
        assert transmittance[name, 0.5] > transmittance[name, 2.0] > transmittance[name, 10.0] > 0
    assert hours["haze", 5.0] < hours["clear", 5.0]
    assert transmittance["haze", 10.0] < 0.8 * transmittance["clear", 10.0]


@pytest.mark.validation  # 7 s
def test_the_runtime_engineer_s_pixel_is_the_reference_s(tmp_path, monkeypatch):
    values = follow("runtime_engineer", tmp_path, monkeypatch)
    assert abs(values["difference"]) < 1e-9 * values["total"]
    assert values["terms"]["emitted"] > values["terms"]["path"] > values["terms"]["reflected Sun"] > 0
    assert abs(values["apparent"] - values["kelvin"]) < 15


@pytest.mark.validation  # 14 s
def test_the_texture_artist_gets_materials_and_masks(tmp_path, monkeypatch):
    follow("texture_artist", tmp_path, monkeypatch)
    assert (tmp_path / "materials.png").stat().st_size > 10_000
    assert len(list((tmp_path / "exchange").rglob("*.png"))) >= 4
    assert (tmp_path / "pine" / "build" / "yellowstone_road.suggest.html").is_file()


def seed_texels(job):
    return json.loads(CliRunner().invoke(tmm, ["check", "--json", job]).output)["textures"][0]["seed_texels"]


@pytest.mark.validation  # 32 s
def test_the_three_ways_find_the_same_road_and_forest(tmp_path, monkeypatch):
    follow("three_ways", tmp_path, monkeypatch)
    found = {}
    for way in ("answers", "labels", "polygons", "all"):
        with open_tmm(tmp_path / "build" / f"{way}.tmm.h5") as file:
            assert set(file.usage) == {"asphalt_road", "grass_green", "conifer"}
            assert 0.06 < file.usage["asphalt_road"] < 0.12  # 0.08 by the polygons of the example
            found[way] = file.array("levels/0/code")
    seeds = {way: seed_texels(f"{way}.yaml") for way in found}
    for way in ("answers", "labels", "polygons"):
        assert (found[way] == found["all"]).mean() > 0.85, way
        assert all(seeds["all"][name] > number for name, number in seeds[way].items())
    questions = (tmp_path / "build" / "answers.suggest.html").read_text(encoding="utf-8")
    assert "://" not in re.sub(r"http://www.w3.org/\S+", "", questions)  # works without a network
    assert (tmp_path / "build" / "answers.suggest.png").stat().st_size > 10_000


def test_the_researcher_finds_what_was_planted(tmp_path, monkeypatch):
    pytest.importorskip("casadi")
    values = follow("researcher", tmp_path, monkeypatch)
    text = (
        CliRunner()
        .invoke(
            mat, ["materials", "fit", "--record", "roof.csv", "--material", "roof_membrane_black", "--free", "albedo"]
        )
        .output
    )
    low, high = map(float, re.search(r"albedo(?:\s+\S+){3}\s+(\S+)\s+(\S+)", text).groups())
    assert low < 0.20 < high and high - low < 0.02
    assert 0.2 < values["zenith"].transmittance.mean() < 0.9


@pytest.mark.validation  # 9 s
def test_the_batch_operator_finds_the_warmer_day(tmp_path, monkeypatch):
    noon = follow("batch_operator", tmp_path, monkeypatch)["noon"]
    assert noon["2026-06-03"] > noon["2026-06-01"] + 2
    assert len(list((tmp_path / "june").glob("*.htt.h5"))) == 4


@pytest.mark.parametrize("page", [*FOLDER.glob("*.md"), *FOLDER.parent.glob("[cp]*.md")], ids=lambda path: path.stem)
def test_links_hold_in_a_checkout(page):
    links = re.findall(r"\]\(([^)#]+)", page.read_text(encoding="utf-8"))
    assert links and all((page.parent / link).exists() for link in links if "://" not in link)


@pytest.mark.parametrize("name", ["comparisons", "physics_limits"])
def test_tests_that_pages_name_are_there(name):
    text = (FOLDER.parent / f"{name}.md").read_text(encoding="utf-8")
    named = set(re.findall(r"tests/\w+(?:/\w+)*\.py", text))
    assert len(named) > 4 and all((FOLDER.parents[2] / path).is_file() for path in named)


PAGES = sorted(path.stem for path in FOLDER.glob("*.md"))


@pytest.mark.parametrize("page", PAGES)
def test_commands_and_options_of_a_page_exist(page):
    """In blocks, which `validation` runs, and in single backticks, which nothing runs: their words and options."""
    text = (FOLDER / f"{page}.md").read_text(encoding="utf-8")
    commands = [line for kind, block in BLOCK.findall(text) if kind == "sh" for line in block.strip().splitlines()]
    commands += re.findall(r"`((?:mat|tmm) [^`]+)`", BLOCK.sub("", text))
    assert commands
    for command in commands:
        for part in command.split("&&"):
            program, *words = shlex.split(part)
            group, context = PROGRAMS[program], None
            if "--to" in words and hasattr(
                group.get_command(context, words[0]), "get_command"
            ):  # mat export --to FORMAT
                words = [words[0], words.pop(words.index("--to") + 1), *(word for word in words[1:] if word != "--to")]
            while words and hasattr(group, "get_command") and group.get_command(context, words[0]):
                group = group.get_command(context, words.pop(0))
            assert group is not PROGRAMS[program], command
            known = {name for option in group.params for name in (*option.opts, *option.secondary_opts)} | {"--help"}
            assert {word.split("=")[0] for word in words if word.startswith("--")} <= known, command


@pytest.mark.parametrize("page", PAGES)
def test_jobs_and_names_of_a_page_exist(page, tmp_path):
    """Jobs of `mat` load, and Python blocks name what the package has; `validation` builds and runs them."""
    blocks = BLOCK.findall((FOLDER / f"{page}.md").read_text(encoding="utf-8"))
    for _, text in blocks:
        if given := FILE.match(text):
            (tmp_path / given[1]).parent.mkdir(exist_ok=True)
            (tmp_path / given[1]).write_text(text[given.end() :], encoding="utf-8")
            if "\nstates:" in text and "\nskyshine: 1" in text:
                load_job(tmp_path / given[1])
    for kind, text in blocks:
        if kind == "python":
            compile(text, page, "exec")
            for package, name in re.findall(r"\bskyshine\.(mat|tmm)\.(\w+)\(", text):
                assert hasattr(importlib.import_module(f"skyshine.{package}"), name), name
