"""What pages load from other machines is found; links that a reader may follow are not."""

import doctest

import pytest

from mat.maintain.manual import outside


@pytest.mark.parametrize(
    "text",
    [
        '<script src="https://cdn.example/a.js"></script>',
        '<script src="//cdn.example/a.js"></script>',
        '<link rel="stylesheet" href="http://fonts.example/a.css">',
        '<img src="HTTPS://pictures.example/a.png">',
        '<iframe src="https://video.example/1"></iframe>',
        "<style>@import 'https://fonts.example/a.css';</style>",
        "<style>p {background: url(//pictures.example/a.png)}</style>",
        '<p style="background: url(https://pictures.example/a.png)">',
    ],
)
def test_a_load_is_found(text):
    assert outside.requests_of_html(text)


@pytest.mark.parametrize(
    "text",
    [
        '<a href="https://example.org">a page</a>',
        '<script src="_static/a.js"></script><img src="../a.png">',
        '<link rel="canonical" href="https://example.org/page">',
        '<img src="data:image/png;base64,AAAA">',
        "<p>written as https://example.org in words</p>",
    ],
)
def test_what_loads_nothing_is_left_alone(text):
    assert outside.requests_of_html(text) == []


def test_a_folder_names_the_file(tmp_path):
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "a.html").write_text('<img src="https://example.org/a.png">', encoding="utf-8")
    (tmp_path / "b.css").write_text("@font-face {src: url('https://example.org/b.woff')}", encoding="utf-8")
    (tmp_path / "c.html").write_text('<img src="c.png">', encoding="utf-8")
    found = outside.requests_of_folder(tmp_path)
    assert [line.partition(":")[0] for line in found] == ["b.css", "below/a.html"]


def test_the_example_runs():
    result = doctest.testmod(outside)
    assert result.attempted == 1 and result.failed == 0
